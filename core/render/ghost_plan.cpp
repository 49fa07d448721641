// SPDX-License-Identifier: Apache-2.0
#include "core/render/ghost_plan.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/render/ghost_culling.h"
#include "core/render/kept_tables.h"
#include "core/render/quality.h"
#include "core/render/visible.h"
#include "core/spectrum/spectrum.h"

namespace flare {
namespace {

constexpr double kSmallestHalf = 1.0 / (1 << 24);

// Where a ghost's colour is looked at besides the d line. Towards the ends of the spectrum coatings
// reflect many times what they do in its middle, and a ghost takes the square of that.
constexpr double kFirst_nm = 400.0, kStep_nm = 30.0;
constexpr int kColours = 11;

std::vector<double> SampledWavelengths(const FlareRequest& request) {
    if (request.color != ColorMode::kSpectral) {
        std::vector<double> wavelengths{kLineD};
        for (int i = 0; i < kColours; ++i) wavelengths.push_back(kFirst_nm + kStep_nm * i);
        return wavelengths;
    }
    const std::vector<double>& list = request.wavelengths_nm;
    if (list.size() <= 3) return list;
    return {list.front(), list[list.size() / 2], list.back()};
}

// What a light weighs at each of them, red, green and blue of Rec.709 added up, whatever the
// picture is made in.
std::vector<double> ColourWeights(const PlacedLight& light) {
    const Spectrum power = PowerOf(light);
    std::vector<double> weights{0.0};
    for (int i = 0; i < kColours; ++i) {
        const double wavelength_nm = kFirst_nm + kStep_nm * i;
        const auto sample = static_cast<std::size_t>(
            std::lround((wavelength_nm - kSpectrumFirst_nm) / kSpectrumStep_nm));
        const Vec3d response = Rec709Response()[sample];
        weights.push_back(std::max(0.0, response.x + response.y + response.z) *
                          std::max(0.0, power[sample]) * (kStep_nm / kSpectrumStep_nm));
    }
    return weights;
}

}  // namespace

GhostPlanner::GhostPlanner(const FlareRequest& request, const Iris& iris, double scene_factor,
                           const RenderContext& context)
    : request_(request), iris_(iris), scene_factor_(scene_factor), context_(context) {}

void GhostPlanner::MakeTables() {
    if (!tables_) tables_ = TablesOf(*request_.lens, SampledWavelengths(request_), context_);
}

SampleScene GhostPlanner::SceneOf(const PlacedLight& light, const LightBundle& bundle) const {
    FLARE_CHECK(tables_);
    SampleScene scene{
        *request_.lens, bundle, light.pose, iris_, *tables_, {}, MapOf(request_, light.pose)};
    if (request_.color == ColorMode::kSpectral) {
        scene.weights.assign(tables_->wavelengths_nm().size(), light.irradiance.x);
    } else {
        scene.weights = ColourWeights(light);
    }
    scene.width = request_.image.width;
    scene.height = request_.image.height;
    return scene;
}

std::vector<GhostSample> GhostPlanner::Sample(const PlacedLight& light,
                                              const std::vector<BounceSequence>& sequences,
                                              const RenderContext& context) const {
    const LightBundle bundle = BundleOf(*request_.lens, light);
    const SampleScene scene = SceneOf(light, bundle);
    std::vector<GhostSample> samples(sequences.size());
    context.threads.For(static_cast<int>(sequences.size()), [&](int i) {
        if (context.cancel.cancelled()) return;
        const auto n = static_cast<std::size_t>(i);
        samples[n] = SampleGhost(scene, sequences[n]);
    });
    return samples;
}

std::vector<std::optional<GhostMotion>> GhostPlanner::Motions(
    const PlacedLight& light, const std::vector<BounceSequence>& sequences,
    const std::vector<GhostSample>& samples, const QualitySettings& settings,
    const RenderContext& context) const {
    std::vector<std::optional<GhostMotion>> motions(samples.size());
    if (light.angular_diameter_rad == 0.0) return motions;
    const std::vector<double> weights = Weights(sequences, samples, settings);
    const LightBundle bundle = BundleOf(*request_.lens, light);
    const SampleScene scene = SceneOf(light, bundle);
    context.threads.For(static_cast<int>(samples.size()), [&](int i) {
        const auto n = static_cast<std::size_t>(i);
        // One beyond the frame may be brought into it.
        const bool culled = weights[n] == 0.0 && samples[n].frame_light > 0.0;
        if (context.cancel.cancelled() || culled || samples[n].flux_mm2 <= 0.0) return;
        motions[n] =
            MotionOf(scene, sequences[n], samples[n].region, 0.5 * light.angular_diameter_rad);
    });
    return motions;
}

GhostMotion GhostPlanner::MotionAlone(const PlacedLight& light,
                                      const BounceSequence& sequence) const {
    const LightBundle bundle = BundleOf(*request_.lens, light);
    const SampleScene scene = SceneOf(light, bundle);
    const GhostSample sample = SampleGhost(scene, sequence);
    GhostMotion motion;
    if (sample.flux_mm2 > 0.0) {
        motion = MotionOf(scene, sequence, sample.region, 0.5 * light.angular_diameter_rad);
    }
    motion.rays += sample.rays;
    return motion;
}

GhostPlan GhostPlanner::Plan(const PlacedLight& light, const std::vector<BounceSequence>& sequences,
                             const std::vector<GhostSample>& samples,
                             const std::vector<std::optional<GhostMotion>>& motions,
                             const QualitySettings& settings) const {
    std::vector<double> weights = Weights(sequences, samples, settings);
    BringIn(0.5 * light.angular_diameter_rad, samples, motions, weights);
    GhostPlan plan;
    for (std::size_t n = 0; n < samples.size(); ++n) {
        const GhostSample& sample = samples[n];
        const double weight = weights[n];
        plan.rays += sample.rays + (motions[n] ? motions[n]->rays : 0);
        plan.frame_light += sample.frame_light;
        plan.lost_light += (1.0 - weight) * sample.frame_light;
        plan.facts.frame_flux_mm2 += sample.frame_flux_mm2;
        plan.facts.lost_flux_mm2 += (1.0 - weight) * sample.frame_flux_mm2;
        plan.facts.culled += weight == 0.0 ? 1 : 0;
        plan.facts.faded += weight > 0.0 && weight < 1.0 ? 1 : 0;
        (weight > 0.0 ? plan.drawn : plan.left_out)
            .push_back({n, weight, false, false, sample, motions[n], 0.0, {}});
    }
    if (request_.visible) LeaveOutUnseen(request_, light, scene_factor_, sequences, plan);
    return plan;
}

// Ghosts that only their motion brings into the frame get a weight.
void GhostPlanner::BringIn(double radius_rad, const std::vector<GhostSample>& samples,
                           const std::vector<std::optional<GhostMotion>>& motions,
                           std::vector<double>& weights) const {
    if (request_.model.culling != CullingRule::kAuto) return;
    const double width = request_.image.width, height = request_.image.height;
    for (std::size_t n = 0; n < samples.size(); ++n) {
        const GhostSample& sample = samples[n];
        const bool beyond = weights[n] == 0.0 && sample.frame_light <= 0.0 && sample.flux_mm2 > 0.0;
        if (!beyond || !motions[n]) continue;
        const Vec2d reach = ReachOf(*motions[n], radius_rad);
        const bool near = sample.box_lo_px.x < width + reach.x &&
                          sample.box_lo_px.y < height + reach.y && sample.box_hi_px.x > -reach.x &&
                          sample.box_hi_px.y > -reach.y;
        if (near && motions[n]->known) weights[n] = 1.0;
    }
}

std::vector<double> GhostPlanner::Weights(const std::vector<BounceSequence>& sequences,
                                          const std::vector<GhostSample>& samples,
                                          const QualitySettings& settings) const {
    const ImageSpec& image = request_.image;
    const double frame_px2 = static_cast<double>(image.width) * image.height;
    std::vector<GhostSample> of_two;
    for (std::size_t n = 0; n < samples.size() && sequences[n].size() == 2; ++n) {
        of_two.push_back(samples[n]);
    }
    std::vector<double> weights;
    const CullingRule rule = request_.model.culling;
    if (rule == CullingRule::kAuto) {
        const Vec2d pitch = PixelPitch(request_);
        double light = 0.0;
        for (const GhostSample& sample : of_two) light += sample.frame_light;
        CullLimits limits;
        limits.lost_share = settings.culled_share * settings.tolerance;
        // Against the frame's mean; half floats show nothing fainter than their smallest number.
        limits.peak = std::max(settings.tolerance * light / (frame_px2 * pitch.x * pitch.y),
                               kSmallestHalf / scene_factor_);
        weights = CullByLight(of_two, limits);
        for (std::size_t n = 0; n < weights.size(); ++n) {
            const bool beyond = of_two[n].frame_light <= 0.0;
            if (beyond && image.overscan != std::array<int, 4>{}) weights[n] = 1.0;
        }
    } else if (rule != CullingRule::kNone) {
        std::vector<int> crossings;
        for (std::size_t n = 0; n < of_two.size(); ++n) {
            crossings.push_back(WriteOut(*request_.lens, sequences[n], kLineD).stop_crossings);
        }
        weights = CullByOldRules(of_two, crossings, frame_px2, rule);
    }
    weights.resize(samples.size(), 1.0);
    // A ghost that an artist has a hand on stays, however faint the lens makes it.
    for (std::size_t n = 0; n < weights.size(); ++n) {
        if (ArtistOf(request_, sequences[n])) weights[n] = 1.0;
    }
    return weights;
}

}  // namespace flare
