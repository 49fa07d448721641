// SPDX-License-Identifier: Apache-2.0
//
// In the plane of light and axis a bundle has one unknown, the place u across the beam. It is
// scanned for the stretches whose rays pass, whose ends are then bisected. Where no ray of the scan
// passes, it is repeated around the rays that came deepest: a ghost's stretch may be a thousandth
// of the front element.
#include "core/drawing/beam_rays.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/tracing/chief_ray.h"

namespace flare {
namespace {

constexpr int kScan = 2048;
constexpr int kMaxZooms = 6;
constexpr std::size_t kFanRays = 7;
constexpr std::size_t kMaxStretches = 3;

struct Stretch {
    double u0 = 0.0, u1 = 0.0;
};

class BeamSearch {
  public:
    BeamSearch(const BeamView& view, const BounceSequence& sequence, double field_rad,
               double wavelength_nm)
        : view_(view),
          bundle_(view.lens, std::abs(field_rad), 0.0,
                  view.section == Section::kX ? 0.0 : 0.5 * kPi),
          list_(WriteOut(view.lens, sequence, wavelength_nm)),
          // Light of a bundle travels upwards, so the picture is turned over.
          upright_(field_rad < 0.0 ? 1.0 : -1.0) {}

    const LightBundle& bundle() const { return bundle_; }

    // The stretches that pass, the widest first.
    std::vector<Stretch> Passing() const {
        double u0 = bundle_.centre_u() - bundle_.half_width();
        double u1 = bundle_.centre_u() + bundle_.half_width();
        for (int zoom = 0; zoom <= kMaxZooms; ++zoom) {
            const double step = (u1 - u0) / kScan;
            std::vector<int> depth;
            for (int i = 0; i <= kScan; ++i) depth.push_back(Depth(u0 + step * i));
            const int deepest = *std::max_element(depth.begin(), depth.end());
            if (deepest == Through()) return Stretches(depth, u0, step);
            const auto first = std::find(depth.begin(), depth.end(), deepest);
            const auto last = std::find(depth.rbegin(), depth.rend(), deepest).base() - 1;
            u1 = u0 + step * static_cast<double>(last - depth.begin() + 1);
            u0 += step * static_cast<double>(first - depth.begin() - 1);
        }
        return {};
    }

    // Empty where it does not come through. Unclipped: past rims, iris and all.
    std::optional<DrawnRay> Draw(double u, bool clip) const {
        RayRecord record;
        const TraceOptions options{clip, &view_.iris, true};
        const TraceResult result = TraceRay(list_, bundle_.At(u, 0.0), options, &record);
        if (result.fate != RayFate::kArrived) return std::nullopt;
        DrawnRay ray;
        ray.passes = clip || Depth(u) == Through();
        // Light of a beam starts on one plane across it; the first point is set by StartTogether.
        ray.points.emplace_back();
        for (const Vec3d& p : record.points) ray.points.push_back(OnPaper(p));
        ray.points.push_back(OnPaper({result.sensor_mm.x, result.sensor_mm.y, list_.sensor_z_mm}));
        for (std::size_t i = 0; i < list_.steps.size(); ++i) {
            if (list_.steps[i].kind == InteractionKind::kReflect) ray.turns.push_back(i + 1);
        }
        return ray;
    }

    void StartTogether(const std::vector<DrawnRay*>& rays) const {
        if (rays.empty()) return;
        const Vec2d travel = OnPaper(bundle_.At(0.0, 0.0).direction);
        double start = rays.front()->points[1].dot(travel);
        for (const DrawnRay* ray : rays) start = std::min(start, ray->points[1].dot(travel));
        start -= view_.lead_mm;
        for (DrawnRay* ray : rays) {
            const Vec2d hit = ray->points[1];
            ray->points[0] = hit - travel * (hit.dot(travel) - start);
        }
    }

  private:
    int Through() const { return static_cast<int>(list_.steps.size()) + 1; }

    // How many interactions the ray gets through; Through() if it arrives.
    int Depth(double u) const {
        const TraceOptions options{true, &view_.iris, false};
        const TraceResult result = TraceRay(list_, bundle_.At(u, 0.0), options, nullptr);
        if (result.fate == RayFate::kArrived) return Through();
        return result.ended_at < 0 ? Through() - 1 : result.ended_at;
    }

    std::vector<Stretch> Stretches(const std::vector<int>& depth, double u0, double step) const {
        const auto passes = [&](int i) {
            return i >= 0 && i <= kScan && depth[static_cast<std::size_t>(i)] == Through();
        };
        std::vector<Stretch> stretches;
        for (int i = 0; i <= kScan; ++i) {
            if (!passes(i)) continue;
            const double u = u0 + step * i;
            if (!passes(i - 1)) stretches.push_back({Edge(u, u - step), u});
            if (!passes(i + 1)) stretches.back().u1 = Edge(u, u + step);
        }
        std::stable_sort(
            stretches.begin(), stretches.end(),
            [](const Stretch& a, const Stretch& b) { return a.u1 - a.u0 > b.u1 - b.u0; });
        return stretches;
    }

    // The last place that passes between one that does and one that does not.
    double Edge(double passes, double fails) const {
        for (int i = 0; i < 60; ++i) {
            const double middle = 0.5 * (passes + fails);
            if (middle == passes || middle == fails) break;
            (Depth(middle) == Through() ? passes : fails) = middle;
        }
        return passes;
    }

    Vec2d OnPaper(const Vec3d& p) const {
        return {p.z, upright_ * (view_.section == Section::kX ? p.x : p.y)};
    }

    BeamView view_;
    LightBundle bundle_;
    InteractionList list_;
    double upright_;
};

}  // namespace

DirectBeam TraceDirectBeam(const BeamView& view, double field_rad, double wavelength_nm) {
    const BeamSearch search(view, {}, field_rad, wavelength_nm);
    DirectBeam beam;
    if (const std::vector<Stretch> passing = search.Passing(); !passing.empty()) {
        beam.upper = search.Draw(passing.front().u0, true);
        beam.lower = search.Draw(passing.front().u1, true);
    }
    if (const auto chief = FindChiefRay(view.lens, search.bundle(), wavelength_nm)) {
        beam.chief = search.Draw(chief->u, false);
    }
    std::vector<DrawnRay*> rays;
    for (std::optional<DrawnRay>* ray : {&beam.upper, &beam.lower, &beam.chief}) {
        if (*ray) rays.push_back(&**ray);
    }
    search.StartTogether(rays);
    if (beam.upper && beam.lower && beam.upper->points[1].y < beam.lower->points[1].y) {
        std::swap(beam.upper, beam.lower);
    }
    return beam;
}

std::vector<DrawnRay> TraceGhostFan(const BeamView& view, const BounceSequence& sequence,
                                    double field_rad, double wavelength_nm) {
    const BeamSearch search(view, sequence, field_rad, wavelength_nm);
    std::vector<Stretch> passing = search.Passing();
    if (passing.size() > kMaxStretches) passing.resize(kMaxStretches);
    double whole = 0.0;
    for (const Stretch& stretch : passing) whole += stretch.u1 - stretch.u0;

    std::vector<DrawnRay> rays;
    for (const Stretch& stretch : passing) {
        const double width = stretch.u1 - stretch.u0;
        const double share = whole > 0.0 ? width / whole : 1.0;
        // An odd number, so that there is a middle one; each stretch shows its two edges.
        const int count =
            2 * std::max(1, static_cast<int>(std::lround(share * (kFanRays - 1) / 2.0))) + 1;
        for (int i = 0; i < count; ++i) {
            // Just inside the edges, where rims do not stop the ray by a rounding.
            const double place = 0.002 + 0.996 * i / (count - 1);
            if (auto ray = search.Draw(stretch.u0 + width * place, true)) rays.push_back(*ray);
        }
    }
    std::vector<DrawnRay*> all;
    for (DrawnRay& ray : rays) all.push_back(&ray);
    search.StartTogether(all);
    std::stable_sort(rays.begin(), rays.end(), [](const DrawnRay& a, const DrawnRay& b) {
        return a.points[1].y < b.points[1].y;
    });
    return rays;
}

}  // namespace flare
