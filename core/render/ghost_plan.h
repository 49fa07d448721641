// SPDX-License-Identifier: Apache-2.0
//
// Which ghosts of a light are drawn, and how strongly: every ghost is sampled (ghost_sample.h),
// then culled by the request's rule (ghost_culling.h). The whole frame decides, so that a crop is
// drawn as the frame is; with overscan, ghosts that lie wholly beyond the frame are drawn as well,
// and so are those that a light of some size blurs into it.
// Depends on request and light alone, not on threads, caches or other lights.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/render/error_estimate.h"
#include "core/render/ghost_motion.h"
#include "core/render/ghost_sample.h"
#include "core/render/lights.h"
#include "core/render/quality.h"
#include "core/render/renderer.h"

namespace flare {

struct PlannedGhost {
    std::size_t index = 0;  // in the sequences that were given
    double weight = 1.0;    // 0: left out
    bool unseen = false;    // not to be drawn after all, since nobody can see it (visible.h)
    bool plain = false;     // drawn without what cannot be seen of it
    GhostSample sample;
    std::optional<GhostMotion> motion;  // of a light of some size
    // Filled in by who prepares the ghost.
    double dispersion_step_px = 0.0;
    MeshMiss miss;
};

struct GhostPlan {
    std::vector<PlannedGhost> drawn, left_out;
    CullingFacts facts;
    VisibleFacts visible;
    double frame_light = 0.0, lost_light = 0.0;  // of all wavelengths, weighted
    std::uint64_t rays = 0;
};

class GhostPlanner {
  public:
    // `scene_factor` takes sensor irradiance to the request's units. The arguments must outlive the
    // planner.
    GhostPlanner(const FlareRequest& request, const Iris& iris, double scene_factor,
                 const RenderContext& context);

    // Before anything is sampled; takes all threads. Does nothing when called again.
    void MakeTables();

    // A light's ghosts looked at, one sample a sequence. Unfinished when cancelled.
    std::vector<GhostSample> Sample(const PlacedLight& light,
                                    const std::vector<BounceSequence>& sequences,
                                    const RenderContext& context) const;
    // How those move that are drawn at these settings as the light turns; none for a point.
    std::vector<std::optional<GhostMotion>> Motions(const PlacedLight& light,
                                                    const std::vector<BounceSequence>& sequences,
                                                    const std::vector<GhostSample>& samples,
                                                    const QualitySettings& settings,
                                                    const RenderContext& context) const;
    // How one ghost moves about this light, sampled anew.
    GhostMotion MotionAlone(const PlacedLight& light, const BounceSequence& sequence) const;
    // What to draw of them at these settings, or at coarser ones than their motions are for. Only
    // ghosts of two reflections are culled: those of four have been chosen already.
    GhostPlan Plan(const PlacedLight& light, const std::vector<BounceSequence>& sequences,
                   const std::vector<GhostSample>& samples,
                   const std::vector<std::optional<GhostMotion>>& motions,
                   const QualitySettings& settings) const;

  private:
    std::vector<double> Weights(const std::vector<BounceSequence>& sequences,
                                const std::vector<GhostSample>& samples,
                                const QualitySettings& settings) const;
    void BringIn(double radius_rad, const std::vector<GhostSample>& samples,
                 const std::vector<std::optional<GhostMotion>>& motions,
                 std::vector<double>& weights) const;
    SampleScene SceneOf(const PlacedLight& light, const LightBundle& bundle) const;

    const FlareRequest& request_;
    const Iris& iris_;
    double scene_factor_;
    const RenderContext& context_;
    std::shared_ptr<const TransmissionTables> tables_;
};

}  // namespace flare
