// SPDX-License-Identifier: Apache-2.0
//
// The ghosts of all lights: chooses those that are worth drawing, builds them in batches (to bound
// memory) and adds them to one picture, light after light.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "core/render/blurred_ghosts.h"
#include "core/render/ghost_builder.h"
#include "core/render/ghost_list.h"
#include "core/render/ghost_plan.h"
#include "core/render/ghost_split.h"
#include "core/render/kept_ghost.h"

namespace flare {

class GhostLayer {
  public:
    // The arguments must outlive the layer; facts and work are added to `report`.
    GhostLayer(const RenderScene& scene, const RenderContext& context, Report& report);

    // Adds a light's ghosts. `reported`: their fluxes stand in the report. Error: cancelled.
    std::optional<Error> Add(const PlacedLight& light, bool reported);
    // After the last light: what was never drawn, and the error.
    void Finish();

    // Light in a pixel times `scale`.
    LayerPlanes Resolve(double scale);
    // The layers of single ghosts, where the request splits the ghosts; once.
    void AppendSplit(FlareImage& image, double scale);
    // Back to a picture without light; what the report holds stays.
    void Clear() {
        picture_.Clear();
        blurred_.reset();
    }

  private:
    void AddFact(const BounceSequence& sequence);
    std::pair<std::shared_ptr<const SeenGhosts>, bool> See(
        const PlacedLight& light, const std::vector<BounceSequence>& sequences,
        const std::optional<GhostKeys>& keys);
    // `keys`: of the light's ghosts, where they are kept.
    std::vector<PlannedGhost> PlanGhosts(const PlacedLight& light,
                                         const std::vector<std::size_t>& indices,
                                         const std::optional<GhostKeys>& keys, bool reported);
    std::optional<Error> AddFourReflections(const PlacedLight& light,
                                            std::vector<std::size_t>& ghosts_of_light);
    // One direction; of a light that is no point, a part of it.
    std::optional<Error> AddLight(const PlacedLight& light, const SourceDisc* disc,
                                  const SourceSquare& part, bool reported);
    // A ghost of a batch: kept, or built.
    struct Batched {
        Fingerprint key;
        std::shared_ptr<const KeptGhost> kept;
        bool keep = true;  // once it is drawn
        GhostBuilder::Built built;
    };
    std::vector<Batched> FindKept(std::span<const PlannedGhost> planned,
                                  const std::optional<GhostKeys>& keys) const;
    void Build(const PlacedLight& light, std::span<const PlannedGhost> planned,
               std::span<Batched> batch, bool reported);
    std::optional<Error> AddBatch(const PlacedLight& light, std::span<PlannedGhost> planned,
                                  std::span<Batched> batch, bool reported);
    // Draws those that blur is to be seen in, and leaves the others.
    void AddBlurredGhosts(const PlacedLight& light, const SourceDisc& disc,
                          const SourceSquare& part, std::vector<PlannedGhost>& planned,
                          bool reported);

    const RenderScene& scene_;
    const RenderContext& context_;
    Report& report_;
    GhostPicture picture_;
    std::optional<GhostSplit> split_;
    std::vector<BounceSequence> sequences_;        // of two reflections
    std::map<BounceSequence, std::size_t> fours_;  // of four: place in the report
    GhostCanvas canvas_;
    GhostBuilder builder_;
    std::optional<BlurredGhosts> blurred_;  // once a light is no point
    GhostPlanner planner_;
    ErrorEstimate error_;
    std::vector<bool> drawn_, unseen_;  // each ghost of the report, for some light
};

}  // namespace flare
