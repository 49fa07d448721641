// SPDX-License-Identifier: Apache-2.0
//
// A ghost of one light as it was drawn: its tiles, the pixels of what polygons drew, and what the
// report says of it. Whoever draws the same light again, with other lights moved or another layer
// asked for, needs no mesh and no light on it. A key holds all that a kept ghost depends on, so a
// picture has the same bytes whether its ghosts were kept or made.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/fingerprint.h"
#include "core/render/error_estimate.h"
#include "core/render/ghost_builder.h"
#include "core/render/ghost_motion.h"
#include "core/render/lights.h"
#include "core/render/render_keeper.h"
#include "core/render/render_scene.h"
#include "core/render/report.h"
#include "core/render/tile_picture.h"

namespace flare {

struct KeptGhost {
    static constexpr KeptKind kKind = KeptKind::kGhost;
    std::shared_ptr<const GhostTiles> tiles;  // null: none of it reaches the picture
    LeftPixels left;
    std::shared_ptr<const GhostFringes> fringes;
    MeshMiss miss;
    std::optional<double> dispersion_step_px;
    RingingFacts ringing;
    double flux_mm2 = 0.0;

    std::size_t bytes() const;
};

// What was built and drawn, to be kept; and back. What is given back leans on `kept`.
std::shared_ptr<const KeptGhost> KeptOf(const GhostBuilder::Built& built, LeftPixels left);
GhostBuilder::Built BuiltOf(const KeptGhost& kept);

// What is looked at before a light's ghosts are chosen (ghost_plan.h).
struct SeenGhosts {
    static constexpr KeptKind kKind = KeptKind::kSeen;
    std::vector<GhostSample> samples;
    std::vector<std::optional<GhostMotion>> motions;

    std::size_t bytes() const;
};

// Names what GhostBuilder::Build makes for one light.
class GhostKeys {
  public:
    GhostKeys(const RenderScene& scene, const PlacedLight& light, const GhostCanvas& canvas,
              bool with_flux);
    Fingerprint Of(const BounceSequence& sequence, double weight, bool plain) const;
    // What they are chosen by.
    Fingerprint OfSeen(const std::vector<BounceSequence>& sequences) const;

  private:
    const RenderScene& scene_;
    const PlacedLight& light_;
    Fingerprint common_;
};

}  // namespace flare
