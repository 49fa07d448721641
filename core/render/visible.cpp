// SPDX-License-Identifier: Apache-2.0
#include "core/render/visible.h"

#include <algorithm>

namespace flare {
namespace {

// The most that the ghost puts on a pixel in any channel; none if that is not known.
std::optional<double> BoundOf(const FlareRequest& request, const PlacedLight& light,
                              double scene_factor, const PlannedGhost& ghost) {
    const GhostSample& sample = ghost.sample;
    // A sample that met no light of a ghost that is drawn all the same says nothing.
    if (!(sample.frame_light > 0.0)) return std::nullopt;
    if (light.angular_diameter_rad > 0.0) {
        // Another part of the source may show what is beyond the frame from here.
        const bool inside = ghost.motion && ghost.motion->known && sample.box_lo_px.x >= 0.0 &&
                            sample.box_lo_px.y >= 0.0 &&
                            sample.box_hi_px.x <= request.image.width &&
                            sample.box_hi_px.y <= request.image.height;
        if (!inside) return std::nullopt;
    }
    const double fringes = request.model.ringing ? kFringePeak : 1.0;
    const Vec2d pitch = PixelPitch(request);
    const double in_one_pixel = kLightDoubt * sample.frame_light / (pitch.x * pitch.y);
    return fringes * ghost.weight * scene_factor * std::min(kPeakDoubt * sample.peak, in_one_pixel);
}

void AddOne(double bound, const PlannedGhost& ghost, double share, UnseenFacts& facts) {
    ++facts.count;
    facts.peak += bound;
    facts.flux_mm2 += share * ghost.weight * ghost.sample.frame_flux_mm2;
}

void AddSum(const UnseenFacts& one, UnseenFacts& all) {
    all.count += one.count;
    all.peak += one.peak;
    all.flux_mm2 += one.flux_mm2;
}

}  // namespace

void LeaveOutUnseen(const FlareRequest& request, const PlacedLight& light, double scene_factor,
                    const std::vector<BounceSequence>& sequences, GhostPlan& plan) {
    struct Bounded {
        double bound;
        PlannedGhost* ghost;
    };
    std::vector<Bounded> faintest_first;
    for (PlannedGhost& ghost : plan.drawn) {
        if (ArtistOf(request, sequences[ghost.index])) continue;
        const std::optional<double> bound = BoundOf(request, light, scene_factor, ghost);
        if (bound) faintest_first.push_back({*bound, &ghost});
    }
    std::stable_sort(faintest_first.begin(), faintest_first.end(),
                     [](const Bounded& a, const Bounded& b) { return a.bound < b.bound; });
    const double floor =
        request.visible->Floor() * light.share / static_cast<double>(request.lights.size());
    double left = kUnseenGhosts * floor;
    auto next = faintest_first.begin();
    for (; next != faintest_first.end() && next->bound <= left; ++next) {
        left -= next->bound;
        next->ghost->unseen = true;
        const bool four = sequences[next->ghost->index].size() > 2;
        AddOne(next->bound, *next->ghost, light.share,
               four ? plan.visible.four_reflections : plan.visible.ghosts);
    }
    left += kUnseenDetails * floor;
    for (; next != faintest_first.end() && next->bound <= left; ++next) {
        left -= next->bound;
        next->ghost->plain = true;
        AddOne(next->bound, *next->ghost, light.share, plan.visible.details);
    }
}

void AddUnseen(const VisibleFacts& one, VisibleFacts& all) {
    AddSum(one.ghosts, all.ghosts);
    AddSum(one.four_reflections, all.four_reflections);
    AddSum(one.details, all.details);
    AddSum(one.starburst, all.starburst);
}

}  // namespace flare
