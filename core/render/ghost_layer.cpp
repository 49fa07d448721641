// SPDX-License-Identifier: Apache-2.0
#include "core/render/ghost_layer.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/units.h"
#include "core/render/fringe_plan.h"
#include "core/render/ghost_choice.h"
#include "core/render/kept_ghost.h"
#include "core/render/visible.h"

namespace flare {
namespace {

constexpr int kGhostsPerBatch = 12;
// Pixels that polygons draw, of the ghosts of a batch that are to be kept; more are not.
constexpr std::size_t kMostLeftBytes = std::size_t{1} << 26;
// A wider light is taken apart before its ghosts are chosen.
constexpr double kWidest_rad = RadiansFromDegrees(2.5);

}  // namespace

GhostLayer::GhostLayer(const RenderScene& scene, const RenderContext& context, Report& report)
    : scene_(scene),
      context_(context),
      report_(report),
      picture_(scene, context),
      sequences_(TwoReflectionSequences(scene.lens, scene.request.model.sensor_reflection)),
      builder_(scene, context),
      planner_(scene.request, scene.iris, scene.units_factor, context),
      error_(scene.lens, scene.settings, scene.spectral()) {
    canvas_ = GhostCanvas::Of(scene, picture_.tiles());
    if (scene.request.split == SplitBy::kGhost) split_.emplace(scene, context);
    for (const BounceSequence& sequence : sequences_) AddFact(sequence);
}

void GhostLayer::AddFact(const BounceSequence& sequence) {
    const ArtistGhost* const artist = ArtistOf(scene_.request, sequence);
    GhostFacts facts;
    facts.sequence = sequence;
    facts.model = artist && artist->mute ? "muted" : facts.ringing.model;
    report_.facts.ghosts.push_back(std::move(facts));
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
            if (!(disc.ShareOf(part) > 0.0)) continue;
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
    std::erase_if(ghosts_of_light,
                  [&](std::size_t i) { return report_.facts.ghosts[i].model == "muted"; });
    std::optional<GhostKeys> keys;
    if (context_.keeper) keys.emplace(scene_, light, canvas_, reported);
    std::vector<PlannedGhost> planned = PlanGhosts(light, ghosts_of_light, keys, reported);
    if (disc) AddBlurredGhosts(light, *disc, part, planned, reported);
    std::erase_if(planned, [](const PlannedGhost& ghost) { return ghost.unseen; });
    std::vector<Batched> ghosts = FindKept(planned, keys);
    for (std::size_t first = 0; first < planned.size();) {
        if (context_.cancel.cancelled()) break;
        std::size_t count = 0;
        for (int made = 0; first + count < planned.size(); ++count) {
            if (!ghosts[first + count].kept && ++made > kGhostsPerBatch) break;
        }
        if (std::optional<Error> error =
                AddBatch(light, std::span(planned).subspan(first, count),
                         std::span(ghosts).subspan(first, count), reported)) {
            return error;
        }
        first += count;
    }
    if (context_.cancel.cancelled()) return Error{"cancelled", "the work was cancelled", ""};
    return std::nullopt;
}

std::vector<GhostLayer::Batched> GhostLayer::FindKept(std::span<const PlannedGhost> planned,
                                                      const std::optional<GhostKeys>& keys) const {
    std::vector<Batched> ghosts(planned.size());
    if (!keys || !canvas_.tiles) return ghosts;
    for (std::size_t n = 0; n < planned.size(); ++n) {
        const BounceSequence& sequence = report_.facts.ghosts[planned[n].index].sequence;
        ghosts[n].key = keys->Of(sequence, planned[n].weight, planned[n].plain);
        ghosts[n].kept = context_.keeper->Find<KeptGhost>(ghosts[n].key);
    }
    return ghosts;
}

// Those that were not kept.
void GhostLayer::Build(const PlacedLight& light, std::span<const PlannedGhost> planned,
                       std::span<Batched> batch, bool reported) {
    if (std::all_of(batch.begin(), batch.end(), [](const Batched& one) { return one.kept; })) {
        return;
    }
    builder_.MakeTables();
    context_.threads.For(static_cast<int>(planned.size()), [&](int i) {
        const auto n = static_cast<std::size_t>(i);
        const PlannedGhost& ghost = planned[n];
        if (batch[n].kept) return;
        batch[n].built = builder_.Build(light, report_.facts.ghosts[ghost.index].sequence,
                                        ghost.weight, reported, canvas_, ghost.plain);
    });
}

std::optional<Error> GhostLayer::AddBatch(const PlacedLight& light, std::span<PlannedGhost> planned,
                                          std::span<Batched> batch, bool reported) {
    const double t0 = context_.now_ms();
    Build(light, planned, batch, reported);
    std::vector<TiledGhost> ghosts;
    std::vector<LeftPixels> left(batch.size());
    std::size_t room = kMostLeftBytes;
    for (std::size_t n = 0; n < planned.size(); ++n) {
        PlannedGhost& ghost = planned[n];
        GhostBuilder::Built& built = batch[n].built;
        if (batch[n].kept) built = BuiltOf(*batch[n].kept);
        ghost.miss = built.miss;
        ghost.dispersion_step_px = built.dispersion_step_px.value_or(ghost.dispersion_step_px);
        error_.AddDrawn(ghost.sample, ghost.weight, ghost.dispersion_step_px, ghost.miss);
        GhostFacts& facts = report_.facts.ghosts[ghost.index];
        facts.flux_mm2 += light.share * built.flux_mm2;
        JoinRinging(built.ringing, facts.ringing);
        facts.model = facts.ringing.model;
        report_.work.Add(built.work);
        ghosts.push_back(std::move(built.ghost));
        if (context_.keeper && !batch[n].kept && ghosts.back().tiles) {
            const std::size_t bytes = LeftPixels::BytesFor(*ghosts.back().tiles);
            batch[n].keep = bytes <= room;
            if (!batch[n].keep) continue;
            room -= bytes;
            left[n] = LeftPixels(*ghosts.back().tiles);
        }
    }
    const double t1 = context_.now_ms();
    report_.work.mesh_ms += t1 - t0;
    if (context_.cancel.cancelled()) return std::nullopt;
    const PictureMap map = MapOf(scene_.request, light.pose);
    picture_.Draw(ghosts, map, report_.work, left);
    for (std::size_t n = 0; split_ && n < ghosts.size(); ++n) {
        const BounceSequence& sequence = report_.facts.ghosts[planned[n].index].sequence;
        if (std::optional<Error> error = split_->Add(sequence, ghosts[n], map, report_.work))
            return error;
    }
    if (context_.keeper && canvas_.tiles && !context_.cancel.cancelled()) {
        for (std::size_t n = 0; n < batch.size(); ++n) {
            if (batch[n].kept || !batch[n].keep) continue;
            batch[n].built.ghost = std::move(ghosts[n]);
            context_.keeper->Keep(batch[n].key, KeptOf(batch[n].built, std::move(left[n])));
        }
    }
    report_.work.raster_ms += context_.now_ms() - t1;
    return std::nullopt;
}

void GhostLayer::AddBlurredGhosts(const PlacedLight& light, const SourceDisc& disc,
                                  const SourceSquare& part, std::vector<PlannedGhost>& planned,
                                  bool reported) {
    const std::vector<BlurChoice> choices = ChooseBlur(planned, light, scene_.settings);
    std::vector<BlurredGhosts::Job> jobs;
    std::vector<PlannedGhost> sharp;
    for (std::size_t n = 0; n < planned.size(); ++n) {
        if (planned[n].unseen) continue;
        GhostFacts& facts = report_.facts.ghosts[planned[n].index];
        const int side = choices[n].side;
        facts.source_directions = std::max(facts.source_directions, side * side);
        if (side == 0) {
            sharp.push_back(planned[n]);
        } else {
            jobs.push_back({&planned[n], &facts.sequence, choices[n]});
        }
    }
    builder_.MakeTables();
    planner_.MakeTables();
    if (!blurred_) blurred_.emplace(scene_, context_, builder_, planner_, canvas_);
    const std::vector<BlurredGhosts::Drawn> drawn =
        blurred_->Add(disc, part, light, jobs, reported, report_.work);
    for (std::size_t n = 0; n < jobs.size(); ++n) {
        const PlannedGhost& ghost = *jobs[n].planned;
        GhostFacts& facts = report_.facts.ghosts[ghost.index];
        facts.flux_mm2 += light.share * drawn[n].flux_mm2;
        JoinRinging(drawn[n].ringing, facts.ringing);
        facts.model = facts.ringing.model;
        const int side = jobs[n].choice.side;
        error_.AddDrawn(ghost.sample, ghost.weight, drawn[n].dispersion_step_px.value_or(0.0),
                        drawn[n].miss);
        error_.AddSource(ghost.sample, ghost.weight, ghost.motion->error / (side * side));
    }
    planned = std::move(sharp);
}

// How the ghosts look from afar, and whether that was kept.
std::pair<std::shared_ptr<const SeenGhosts>, bool> GhostLayer::See(
    const PlacedLight& light, const std::vector<BounceSequence>& sequences,
    const std::optional<GhostKeys>& keys) {
    Fingerprint key;
    if (keys) {
        key = keys->OfSeen(sequences);
        if (auto kept = context_.keeper->Find<SeenGhosts>(key)) return {std::move(kept), true};
    }
    planner_.MakeTables();
    auto seen = std::make_shared<SeenGhosts>();
    seen->samples = planner_.Sample(light, sequences, context_);
    seen->motions = planner_.Motions(light, sequences, seen->samples, scene_.settings, context_);
    if (context_.keeper && !context_.cancel.cancelled())
        context_.keeper->Keep<SeenGhosts>(key, seen);
    return {std::move(seen), false};
}

// Leaves out the ghosts that need not be drawn, and says so.
std::vector<PlannedGhost> GhostLayer::PlanGhosts(const PlacedLight& light,
                                                 const std::vector<std::size_t>& indices,
                                                 const std::optional<GhostKeys>& keys,
                                                 bool reported) {
    const double before = context_.now_ms();
    std::vector<BounceSequence> sequences;
    for (const std::size_t i : indices) {
        sequences.push_back(report_.facts.ghosts[i].sequence);
    }
    const auto [seen, kept] = See(light, sequences, keys);
    GhostPlan plan = planner_.Plan(light, sequences, seen->samples, seen->motions, scene_.settings);
    Facts& facts = report_.facts;
    facts.culling.culled += plan.facts.culled;
    facts.culling.faded += plan.facts.faded;
    facts.culling.frame_flux_mm2 += light.share * plan.facts.frame_flux_mm2;
    facts.culling.lost_flux_mm2 += light.share * plan.facts.lost_flux_mm2;
    facts.culled_flux_mm2 += light.share * plan.facts.lost_flux_mm2;
    if (facts.visible) AddUnseen(plan.visible, *facts.visible);
    error_.AddLight(plan.frame_light, plan.lost_light);
    drawn_.resize(facts.ghosts.size());
    unseen_.resize(facts.ghosts.size());
    for (PlannedGhost& ghost : plan.drawn) {
        ghost.index = indices[ghost.index];
        if (ghost.unseen && reported) {
            facts.ghosts[ghost.index].flux_mm2 += light.share * ghost.sample.flux_mm2;
        }
        (ghost.unseen ? unseen_ : drawn_)[ghost.index] = true;
    }
    for (const PlannedGhost& ghost : plan.left_out) {
        if (reported)
            facts.ghosts[indices[ghost.index]].flux_mm2 += light.share * ghost.sample.flux_mm2;
    }
    if (!kept) report_.work.sampled_rays += plan.rays;
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
        if (added) AddFact(sequence);
        ghosts_of_light.push_back(known->second);
    }
    four.rendered = fours_.size();
    facts.four_reflections = four;
    return std::nullopt;
}

void GhostLayer::Finish() {
    for (std::size_t i = 0; i < drawn_.size(); ++i) {
        std::string& model = report_.facts.ghosts[i].model;
        if (!drawn_[i] && model != "muted") model = unseen_[i] ? "unseen" : "culled";
    }
    report_.facts.estimated_error = error_.Value();
}

void GhostLayer::AppendSplit(FlareImage& image, double scale) {
    if (split_) split_->AppendTo(image, scale);
}

LayerPlanes GhostLayer::Resolve(double scale) {
    LayerPlanes planes = picture_.Resolve(scale);
    if (!blurred_) return planes;
    const LightPlanes blurred = blurred_->Take();
    context_.threads.For(static_cast<int>(planes.size()), [&](int c) {
        std::vector<float>& plane = planes[static_cast<std::size_t>(c)];
        const std::vector<float>& more = blurred.channels[static_cast<std::size_t>(c)];
        for (std::size_t k = 0; k < plane.size(); ++k) {
            plane[k] =
                PlaneValue(static_cast<double>(plane[k]) + scale * static_cast<double>(more[k]));
        }
    });
    return planes;
}

}  // namespace flare
