// SPDX-License-Identifier: Apache-2.0
#include "core/render/ghost_layer.h"

#include <algorithm>
#include <numeric>

#include "core/render/fringe_plan.h"
#include "core/render/ghost_choice.h"

namespace flare {
namespace {

GhostFacts FactsOf(const BounceSequence& sequence) {
    GhostFacts facts;
    facts.sequence = sequence;
    facts.model = facts.ringing.model;
    return facts;
}

constexpr int kGhostsPerBatch = 12;

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
    builder_.emplace(scene, tile_picture_ ? &*tile_picture_ : nullptr, context);
    for (const BounceSequence& sequence : sequences_) {
        report_.facts.ghosts.push_back(FactsOf(sequence));
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
    std::vector<std::size_t> ghosts_of_light(sequences_.size());
    std::iota(ghosts_of_light.begin(), ghosts_of_light.end(), std::size_t{0});
    if (scene_.request.model.reflections == 4) {
        const double before = context_.now_ms();
        if (std::optional<Error> error = AddFourReflections(light, ghosts_of_light)) return error;
        report_.work.mesh_ms += context_.now_ms() - before;
    }
    std::vector<PlannedGhost> planned = PlanGhosts(light, ghosts_of_light, reported);
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
                                   reported);
    });
    std::vector<TiledGhost> ghosts;
    for (std::size_t n = 0; n < planned.size(); ++n) {
        PlannedGhost& ghost = planned[n];
        ghost.miss = built[n].miss;
        ghost.dispersion_step_px = built[n].dispersion_step_px.value_or(ghost.dispersion_step_px);
        error_.AddDrawn(ghost.sample, ghost.weight, ghost.dispersion_step_px, ghost.miss);
        GhostFacts& facts = report_.facts.ghosts[ghost.index];
        facts.flux_mm2 += built[n].flux_mm2;
        JoinRinging(built[n].ringing, facts.ringing);
        facts.model = facts.ringing.model;
        AddWork(built[n].work);
        ghosts.push_back(std::move(built[n].ghost));
    }
    const double t1 = context_.now_ms();
    report_.work.mesh_ms += t1 - t0;
    if (context_.cancel.cancelled()) return;
    Draw(ghosts, MapOf(scene_.request, light.pose));
    report_.work.raster_ms += context_.now_ms() - t1;
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
    GhostPlan plan =
        planner_.Plan(sequences, planner_.Sample(light, sequences, context_), scene_.settings);
    Facts& facts = report_.facts;
    facts.culling.culled += plan.facts.culled;
    facts.culling.faded += plan.facts.faded;
    facts.culling.frame_flux_mm2 += plan.facts.frame_flux_mm2;
    facts.culling.lost_flux_mm2 += plan.facts.lost_flux_mm2;
    facts.culled_flux_mm2 += plan.facts.lost_flux_mm2;
    error_.AddLight(plan.frame_light, plan.lost_light);
    drawn_.resize(facts.ghosts.size());
    for (PlannedGhost& ghost : plan.drawn) {
        ghost.index = indices[ghost.index];
        drawn_[ghost.index] = true;
    }
    for (const PlannedGhost& ghost : plan.left_out) {
        if (reported) facts.ghosts[indices[ghost.index]].flux_mm2 += ghost.sample.flux_mm2;
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
    if (facts.four_reflections) {
        four.rendered_flux_mm2 += facts.four_reflections->rendered_flux_mm2;
        four.lost_flux_mm2 += facts.four_reflections->lost_flux_mm2;
    }
    facts.culled_flux_mm2 += choice->facts.lost_flux_mm2;
    report_.work.rays_traced += choice->rays_traced;
    for (const BounceSequence& sequence : choice->sequences) {
        const auto [known, added] = fours_.emplace(sequence, facts.ghosts.size());
        if (added) facts.ghosts.push_back(FactsOf(sequence));
        ghosts_of_light.push_back(known->second);
    }
    four.rendered = fours_.size();
    facts.four_reflections = four;
    return std::nullopt;
}

void GhostLayer::AddWork(const Work& w) {
    report_.work.rays_traced += w.rays_traced;
    report_.work.ray_surfaces += w.ray_surfaces;
    report_.work.cells += w.cells;
    report_.work.mesh_hits += w.mesh_hits;
    report_.work.mesh_misses += w.mesh_misses;
    report_.work.mesh_disk_hits += w.mesh_disk_hits;
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
        return planes;
    }
    context_.threads.For(static_cast<int>(planes.size()), [&](int c) {
        planes[static_cast<std::size_t>(c)] = picture_->Channel(c, scale);
    });
    return planes;
}

}  // namespace flare
