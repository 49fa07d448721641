// SPDX-License-Identifier: Apache-2.0
#include "core/render/ghost_layer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/base/units.h"
#include "core/render/ghost_choice.h"

namespace flare {
namespace {

constexpr int kGhostsPerBatch = 12;
// A wider light is taken apart before its ghosts are chosen.
constexpr double kWidest_rad = RadiansFromDegrees(2.5);

double BrightestChannel(const std::vector<LightSpec>& lights) {
    double brightest = 0.0;
    for (const LightSpec& light : lights) {
        const Vec3d& e = light.irradiance;
        brightest = std::max({brightest, e.x, e.y, e.z});
    }
    return brightest > 0.0 ? brightest : 1.0;
}

}  // namespace

GhostLayer::GhostLayer(const RenderScene& scene, const RenderContext& context, Report& report)
    : scene_(scene),
      context_(context),
      report_(report),
      sequences_(TwoReflectionSequences(scene.lens, scene.request.model.sensor_reflection)),
      planner_(scene.request, scene.iris, scene.units_factor, context.threads),
      error_(scene.lens, scene.settings, scene.spectral()) {
    MakePicture();
    canvas_ = GhostCanvas::Of(scene, tile_picture_ ? &*tile_picture_ : nullptr);
    builder_.emplace(scene, context);
    for (const BounceSequence& sequence : sequences_) {
        report_.facts.ghosts.push_back({sequence, "geometric", 0.0});
    }
}

void GhostLayer::MakePicture() {
    const FlareRequest& request = scene_.request;
    if (!scene_.settings.tiles || scene_.spectral()) {
        picture_.emplace(scene_.window,
                         scene_.spectral() ? static_cast<int>(scene_.channel_count()) : 0);
        return;
    }
    tile_picture_.emplace(scene_.window, request.image.width, request.image.height,
                          BrightestChannel(request.lights));
}

std::optional<Error> GhostLayer::Add(const PlacedLight& light, bool reported) {
    const Vec3d& e = light.irradiance;
    if (e.x == 0.0 && e.y == 0.0 && e.z == 0.0) return std::nullopt;
    if (light.angular_diameter_rad == 0.0) {
        if (std::optional<Error> error = AddLight(light, nullptr, {}, reported)) return error;
    } else {
        const SourceDisc disc(scene_.lens, light);
        const int side = static_cast<int>(std::ceil(light.angular_diameter_rad / kWidest_rad));
        for (int k = 0; k < side * side; ++k) {
            const SourceSquare part = SourceSquare().Part(k % side, k / side, side);
            if (std::optional<Error> error = AddLight(disc.LightOf(part), &disc, part, reported)) {
                return error;
            }
        }
    }
    return std::nullopt;
}

std::optional<Error> GhostLayer::AddLight(const PlacedLight& light, const SourceDisc* disc,
                                          const SourceSquare& part, bool reported) {
    std::vector<std::size_t> ghosts_of_light(sequences_.size());
    std::iota(ghosts_of_light.begin(), ghosts_of_light.end(), std::size_t{0});
    if (scene_.request.model.reflections == 4) {
        const double before = context_.now_ms();
        if (std::optional<Error> error = AddFourReflections(light, ghosts_of_light)) return error;
        report_.work.mesh_ms += context_.now_ms() - before;
    }
    std::vector<PlannedGhost> planned = PlanGhosts(light, ghosts_of_light, reported);
    if (disc) AddBlurredGhosts(light, *disc, part, planned, reported);
    for (std::size_t first = 0; first < planned.size(); first += kGhostsPerBatch) {
        if (context_.cancel.cancelled()) break;
        const std::size_t count = std::min<std::size_t>(kGhostsPerBatch, planned.size() - first);
        AddBatch(light, std::span(planned).subspan(first, count), reported);
    }
    if (context_.cancel.cancelled()) return Error{"cancelled", "the work was cancelled", ""};
    return std::nullopt;
}

void GhostLayer::AddBatch(const PlacedLight& light, std::span<PlannedGhost> planned,
                          bool reported) {
    const double t0 = context_.now_ms();
    std::vector<GhostBuilder::Built> built(planned.size());
    context_.threads.For(static_cast<int>(planned.size()), [&](int i) {
        const auto n = static_cast<std::size_t>(i);
        const PlannedGhost& ghost = planned[n];
        built[n] = builder_->Build(light, report_.facts.ghosts[ghost.index].sequence, ghost.weight,
                                   reported, canvas_);
    });
    std::vector<TiledGhost> ghosts;
    for (std::size_t n = 0; n < planned.size(); ++n) {
        PlannedGhost& ghost = planned[n];
        ghost.miss = built[n].miss;
        ghost.dispersion_step_px = built[n].dispersion_step_px.value_or(ghost.dispersion_step_px);
        error_.AddDrawn(ghost.sample, ghost.weight, ghost.dispersion_step_px, ghost.miss);
        report_.facts.ghosts[ghost.index].flux_mm2 += light.share * built[n].flux_mm2;
        report_.work.Add(built[n].work);
        ghosts.push_back(std::move(built[n].ghost));
    }
    const double t1 = context_.now_ms();
    report_.work.mesh_ms += t1 - t0;
    if (context_.cancel.cancelled()) return;
    Draw(ghosts, MapOf(scene_.request, light.pose));
    report_.work.raster_ms += context_.now_ms() - t1;
}

void GhostLayer::AddBlurredGhosts(const PlacedLight& light, const SourceDisc& disc,
                                  const SourceSquare& part, std::vector<PlannedGhost>& planned,
                                  bool reported) {
    const std::vector<BlurChoice> choices =
        ChooseBlur(planned, 0.5 * light.angular_diameter_rad, scene_.settings);
    std::vector<BlurredGhosts::Job> jobs;
    std::vector<PlannedGhost> sharp;
    for (std::size_t n = 0; n < planned.size(); ++n) {
        GhostFacts& facts = report_.facts.ghosts[planned[n].index];
        const int side = choices[n].side;
        facts.source_directions = std::max(facts.source_directions, side * side);
        if (side == 0) {
            sharp.push_back(planned[n]);
        } else {
            jobs.push_back({&planned[n], &facts.sequence, choices[n]});
        }
    }
    if (!blurred_) blurred_.emplace(scene_, context_, *builder_, canvas_);
    const std::vector<BlurredGhosts::Drawn> drawn =
        blurred_->Add(disc, part, light, jobs, reported, report_.work);
    for (std::size_t n = 0; n < jobs.size(); ++n) {
        const PlannedGhost& ghost = *jobs[n].planned;
        report_.facts.ghosts[ghost.index].flux_mm2 += light.share * drawn[n].flux_mm2;
        const int side = jobs[n].choice.side;
        error_.AddDrawn(ghost.sample, ghost.weight, drawn[n].dispersion_step_px.value_or(0.0),
                        drawn[n].miss);
        error_.AddSource(ghost.sample, ghost.weight, ghost.motion->error / (side * side));
    }
    planned = std::move(sharp);
}

void GhostLayer::Draw(std::vector<TiledGhost>& ghosts, const PictureMap& map) {
    const auto count = [&](const auto& drawn) {
        report_.work.polygons += drawn.pieces;
        report_.work.fragments += drawn.fragments;
    };
    if (tile_picture_) {
        count(tile_picture_->Draw(ghosts, scene_.iris, tile_picture_->MapFromMiddle(map),
                                  scene_.settings.walk, context_.threads, context_.cancel));
        return;
    }
    std::vector<GhostLight> lights;
    for (TiledGhost& ghost : ghosts) lights.push_back(std::move(ghost.light));
    count(picture_->Draw(lights, scene_.iris, map, scene_.settings.walk, context_.threads,
                         context_.cancel));
}

// Leaves out the ghosts that need not be drawn, and says so.
std::vector<PlannedGhost> GhostLayer::PlanGhosts(const PlacedLight& light,
                                                 const std::vector<std::size_t>& indices,
                                                 bool reported) {
    const double before = context_.now_ms();
    std::vector<BounceSequence> sequences;
    for (const std::size_t i : indices) {
        sequences.push_back(report_.facts.ghosts[i].sequence);
    }
    GhostPlan plan = planner_.Plan(light, sequences, context_);
    Facts& facts = report_.facts;
    facts.culling.culled += plan.facts.culled;
    facts.culling.faded += plan.facts.faded;
    facts.culling.frame_flux_mm2 += light.share * plan.facts.frame_flux_mm2;
    facts.culling.lost_flux_mm2 += light.share * plan.facts.lost_flux_mm2;
    facts.culled_flux_mm2 += light.share * plan.facts.lost_flux_mm2;
    error_.AddLight(plan.frame_light, plan.lost_light);
    drawn_.resize(facts.ghosts.size());
    for (PlannedGhost& ghost : plan.drawn) {
        ghost.index = indices[ghost.index];
        drawn_[ghost.index] = true;
    }
    for (const PlannedGhost& ghost : plan.left_out) {
        if (reported)
            facts.ghosts[indices[ghost.index]].flux_mm2 += light.share * ghost.sample.flux_mm2;
    }
    report_.work.sampled_rays += plan.rays;
    report_.work.cull_ms += context_.now_ms() - before;
    return std::move(plan.drawn);
}

// The ghosts of four reflections that this light makes bright enough, by their places in the
// report.
std::optional<Error> GhostLayer::AddFourReflections(const PlacedLight& light,
                                                    std::vector<std::size_t>& ghosts_of_light) {
    const Result<GhostChoice> choice =
        ChooseFourReflections(scene_.lens, scene_.request.model, scene_.iris, light, context_);
    if (!choice) return choice.error();
    Facts& facts = report_.facts;
    FourReflectionFacts four = choice->facts;
    four.rendered_flux_mm2 *= light.share;
    four.lost_flux_mm2 *= light.share;
    facts.culled_flux_mm2 += four.lost_flux_mm2;
    if (facts.four_reflections) {
        four.rendered_flux_mm2 += facts.four_reflections->rendered_flux_mm2;
        four.lost_flux_mm2 += facts.four_reflections->lost_flux_mm2;
    }
    report_.work.rays_traced += choice->rays_traced;
    for (const BounceSequence& sequence : choice->sequences) {
        const auto [known, added] = fours_.emplace(sequence, facts.ghosts.size());
        if (added) facts.ghosts.push_back({sequence, "geometric", 0.0});
        ghosts_of_light.push_back(known->second);
    }
    four.rendered = fours_.size();
    facts.four_reflections = four;
    return std::nullopt;
}

void GhostLayer::Finish() {
    for (std::size_t i = 0; i < drawn_.size(); ++i) {
        if (!drawn_[i]) report_.facts.ghosts[i].model = "culled";
    }
    report_.facts.estimated_error = error_.Value();
}

std::vector<std::vector<float>> GhostLayer::Resolve(double scale) {
    std::vector<std::vector<float>> planes(scene_.channel_count());
    if (tile_picture_) {
        std::ranges::move(tile_picture_->Resolve(scale, context_.threads), planes.begin());
    } else {
        context_.threads.For(static_cast<int>(planes.size()), [&](int c) {
            planes[static_cast<std::size_t>(c)] = picture_->Channel(c, scale);
        });
    }
    if (!blurred_) return planes;
    const LightPlanes blurred = blurred_->Take();
    constexpr double kMost = std::numeric_limits<float>::max();
    context_.threads.For(static_cast<int>(planes.size()), [&](int c) {
        std::vector<float>& plane = planes[static_cast<std::size_t>(c)];
        const std::vector<float>& more = blurred.channels[static_cast<std::size_t>(c)];
        for (std::size_t k = 0; k < plane.size(); ++k) {
            const double sum = static_cast<double>(plane[k]) + scale * static_cast<double>(more[k]);
            plane[k] = static_cast<float>(std::clamp(sum, -kMost, kMost));
        }
    });
    return planes;
}

}  // namespace flare
