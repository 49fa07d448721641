// SPDX-License-Identifier: Apache-2.0
//
// Ghosts of a light that is no point: each is drawn as that of a point and blurred by the image of
// the source that its own motion makes (ghost_motion.h), on pixels as coarse as the blur allows;
// where one motion is not true enough for the whole source, by parts of the source that fade into
// each other (source_disc.h), each from its own direction and with its own motion.
// docs/physics/area-lights.md.
//
// Bytes do not depend on threads; a crop holds what the frame does: levels are laid out from the
// frame's middle, everything is drawn with a margin of the kernel's reach, and what is chosen for a
// ghost is chosen by the whole frame. Memory: a picture of floats, and another while a ghost is
// drawn.
#pragma once

#include <span>
#include <vector>

#include "core/image/coarse_levels.h"
#include "core/render/ghost_builder.h"
#include "core/render/ghost_plan.h"
#include "core/render/source_disc.h"

namespace flare {

// How a ghost of a disc is drawn.
struct BlurChoice {
    int side = 0;    // side^2 directions; 0: as of a point, its blur is far below a pixel
    int coarse = 0;  // pixels of 2^coarse
};

// One for each ghost of a light that is no point, by what all of them may be wrong together.
std::vector<BlurChoice> ChooseBlur(std::span<const PlannedGhost> ghosts, const PlacedLight& light,
                                   const QualitySettings& settings);

class BlurredGhosts {
  public:
    // `canvas` is the picture's own. The arguments must outlive this.
    BlurredGhosts(const RenderScene& scene, const RenderContext& context,
                  const GhostBuilder& builder, const GhostPlanner& planner,
                  const GhostCanvas& canvas);

    // Ghosts of one part of a disc; `light` is that part as a point light.
    struct Job {
        const PlannedGhost* planned = nullptr;
        const BounceSequence* sequence = nullptr;
        BlurChoice choice;
    };
    struct Drawn {
        MeshMiss miss;
        RingingFacts ringing;
        std::optional<double> dispersion_step_px;
        double flux_mm2 = 0.0;  // if asked for; mean over the directions
    };
    // One result for each job; stops early when cancelled. Work is added to `work`.
    std::vector<Drawn> Add(const SourceDisc& disc, const SourceSquare& part,
                           const PlacedLight& light, std::span<const Job> jobs, bool with_flux,
                           Work& work);

    // What all ghosts put on the picture's window.
    LightPlanes Take() { return levels_.Take(context_.threads); }

  private:
    struct Group;
    std::vector<Group> GroupsOf(const SourceDisc& disc, const SourceSquare& part,
                                const PlacedLight& light, std::span<const Job> jobs,
                                Work& work) const;
    std::vector<Group> PartsOf(const SourceDisc& disc, const SourceSquare& part,
                               const PlacedLight& light, std::span<const Job> jobs,
                               Work& work) const;
    GhostCanvas CanvasOf(const Group& group) const;
    void AddGroups(std::span<const Group> groups, std::span<const Job> jobs, bool with_flux,
                   std::vector<Drawn>& drawn, Work& work);
    LightPlanes Draw(const Group& group, std::vector<TiledGhost> ghosts, Work& work) const;

    const RenderScene& scene_;
    const RenderContext& context_;
    const GhostBuilder& builder_;
    const GhostPlanner& planner_;
    const GhostCanvas& canvas_;
    CoarseLevels levels_;
};

}  // namespace flare
