// SPDX-License-Identifier: Apache-2.0
#include "core/render/scene_survey.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/render/blurred_ghosts.h"
#include "core/render/error_estimate.h"
#include "core/render/ghost_list.h"

namespace flare {
namespace {

// The error of a picture of very many lights is told from the brightest.
constexpr std::size_t kMostLights = 16;

FlareRequest AtTolerance(FlareRequest request, double tolerance) {
    request.quality = Quality::Tolerance(tolerance);
    return request;
}

std::vector<std::size_t> BrightestLights(const std::vector<LightSpec>& lights) {
    std::vector<std::size_t> order(lights.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto light = [&](std::size_t i) {
        const Vec3d& e = lights[i].irradiance;
        return e.x + e.y + e.z;
    };
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return light(a) > light(b); });
    order.resize(std::min(order.size(), kMostLights));
    return order;
}

}  // namespace

SceneSurvey::SceneSurvey(const FlareRequest& request, double tolerance,
                         const RenderContext& context)
    : request_(AtTolerance(request, tolerance)),
      finest_(0.5 * tolerance),
      scene_(request_),
      planner_(request_, scene_.iris, scene_.units_factor, context) {
    if (!request_.layers.ghosts) return;
    planner_.MakeTables();
    sequences_ = TwoReflectionSequences(scene_.lens, request_.model.sensor_reflection);
    const GhostBuilder builder(scene_, context);
    const GhostCanvas canvas = GhostCanvas::Of(scene_, nullptr);
    for (const std::size_t i : BrightestLights(request_.lights)) {
        const Result<PlacedLight> placed = PlaceLight(request_, i);
        if (!placed || context.cancel.cancelled()) continue;
        Light light;
        light.placed = SourceDisc(scene_.lens, *placed).LightOf(SourceSquare());
        light.samples = planner_.Sample(light.placed, sequences_, context);
        light.motions = planner_.Motions(light.placed, sequences_, light.samples,
                                         SettingsFor(finest_), context);
        light.ghosts.resize(sequences_.size());
        const GhostPlan plan = planner_.Plan(light.placed, sequences_, light.samples, light.motions,
                                             SettingsFor(finest_));
        context.threads.For(static_cast<int>(plan.drawn.size()), [&](int n) {
            if (plan.drawn[static_cast<std::size_t>(n)].unseen) return;
            const std::size_t ghost = plan.drawn[static_cast<std::size_t>(n)].index;
            const GhostBuilder::Located located =
                builder.Locate(light.placed, sequences_[ghost], canvas);
            light.ghosts[ghost] = {located.miss, located.dispersion_px};
        });
        lights_.push_back(std::move(light));
    }
}

bool SceneSurvey::Covers(double tolerance) const {
    const QualitySettings settings = SettingsFor(tolerance);
    return tolerance >= finest_ && settings.mesh_cells == scene_.settings.mesh_cells &&
           settings.position_tolerance_mm == scene_.settings.position_tolerance_mm;
}

EstimatedError SceneSurvey::At(double tolerance) const {
    const QualitySettings settings = SettingsFor(tolerance);
    // A cubic misses with the fourth power of the cell, its slope with the third.
    const double cell = static_cast<double>(scene_.settings.mesh_cells) / settings.mesh_cells;
    const double third = cell * cell * cell;
    ErrorEstimate estimate(scene_.lens, settings, scene_.spectral());
    for (const Light& light : lights_) {
        const GhostPlan plan =
            planner_.Plan(light.placed, sequences_, light.samples, light.motions, settings);
        std::vector<BlurChoice> blurs(plan.drawn.size());
        if (light.placed.angular_diameter_rad > 0.0)
            blurs = ChooseBlur(plan.drawn, light.placed, settings);
        estimate.AddLight(plan.frame_light, plan.lost_light);
        for (std::size_t n = 0; n < plan.drawn.size(); ++n) {
            const PlannedGhost& planned = plan.drawn[n];
            if (planned.unseen) continue;
            const int side = blurs[n].side;
            if (side > 0) {
                estimate.AddSource(planned.sample, planned.weight,
                                   planned.motion->error / (side * side));
            }
            const Ghost& ghost = light.ghosts[planned.index];
            LightColour colour;
            colour.dispersion_px = ghost.dispersion_px;
            colour.dispersion_step_px = settings.dispersion_step_px;
            colour.most_drawn = settings.most_drawn;
            const double step = ghost.dispersion_px / (DrawnWavelengths(colour) - 1);
            estimate.AddDrawn(planned.sample, planned.weight, scene_.spectral() ? 0.0 : step,
                              {ghost.miss.position_px * third * cell, ghost.miss.density * third});
        }
    }
    return estimate.Value();
}

}  // namespace flare
