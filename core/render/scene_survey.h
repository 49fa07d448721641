// SPDX-License-Identifier: Apache-2.0
//
// What must be known of a scene to tell the error of a picture of it without drawing: its brightest
// lights' ghosts, sampled, and located on the meshes of one tolerance.
#pragma once

#include <vector>

#include "core/render/ghost_builder.h"
#include "core/render/ghost_plan.h"

namespace flare {

class SceneSurvey {
  public:
    // The meshes are those of `tolerance`. Unfinished when cancelled; lights that cannot be placed
    // are passed over.
    SceneSurvey(const FlareRequest& request, double tolerance, const RenderContext& context);

    // Of a picture at any tolerance; where its meshes are others, what they miss is scaled from the
    // surveyed ones.
    EstimatedError At(double tolerance) const;
    // Are its meshes and its ghosts among the surveyed ones?
    bool Covers(double tolerance) const;

  private:
    struct Ghost {
        MeshMiss miss;
        double dispersion_px = 0.0;
    };
    struct Light {
        PlacedLight placed;
        std::vector<GhostSample> samples;
        std::vector<std::optional<GhostMotion>> motions;
        std::vector<Ghost> ghosts;
    };

    FlareRequest request_;
    double finest_;  // tolerance whose ghosts were located
    RenderScene scene_;
    GhostPlanner planner_;
    std::vector<BounceSequence> sequences_;
    std::vector<Light> lights_;
};

}  // namespace flare
