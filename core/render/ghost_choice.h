// SPDX-License-Identifier: Apache-2.0
//
// Which bounce sequences a light's picture is made of. All ghosts of two reflections; and those of
// four whose peak irradiance reaches the request's threshold. Four reflections make thousands of
// sequences that together hold a few percent of the light of two, but some are focused and outshine
// most of the others: so they are chosen by peak, never by count, and what is left out is added up.
//
// Three steps, each dearer than the one before. First-order optics and the path's axial weight give
// a peak E = w / |A_x A_y|; as a caustic raises the real one up to 2000 times, sequences are
// dropped only where it is kCausticGain times below the threshold. The others get a coarse mesh of
// real rays at the light's own angle, whose cells show the peak to a factor of kMeshGain; and what
// may still reach the threshold is cut into pieces (ghost_peak.h), which decides. Measured in
// docs/physics/ghost-mesh.md.
#pragma once

#include <cstdint>
#include <vector>

#include "core/optics/iris.h"
#include "core/render/flare_request.h"
#include "core/render/ghost_estimate.h"
#include "core/render/lights.h"
#include "core/render/renderer.h"

namespace flare {

inline constexpr double kCausticGain = 1e4;
inline constexpr double kMeshGain = 300.0;

struct GhostChoice {
    std::vector<BounceSequence> sequences;  // of four reflections, in lexical order
    FourReflectionFacts facts;
    std::uint64_t rays_traced = 0;
};

// The sequences of four reflections worth rendering for this light. `iris` limits the stop. Fails
// with code "cancelled".
Result<GhostChoice> ChooseFourReflections(const Lens& lens, const ModelSpec& model,
                                          const Iris& iris, const PlacedLight& light,
                                          const RenderContext& context);

}  // namespace flare
