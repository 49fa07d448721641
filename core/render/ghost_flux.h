// SPDX-License-Identifier: Apache-2.0
//
// The light of a whole ghost, wherever it falls on the sensor plane.
#pragma once

#include <memory>

#include "core/image/ghost_walk.h"
#include "core/mesh/transmission.h"
#include "core/tracing/light_bundle.h"

namespace flare {

struct GhostFlux {
    double flux_mm2 = 0.0;        // for E0 = 1 perpendicular to the beam
    Vec2d centroid_mm{0.0, 0.0};  // lens space, canonical azimuth
};

// At the first wavelength of `tables`. `pose` turns stop places into the iris's, which matters
// where it has blades.
GhostFlux FluxOf(const std::shared_ptr<const GhostSurface>& surface, const LightBundle& bundle,
                 const Lens& lens, const TransmissionTables& tables, const Iris& iris,
                 const WalkTolerance& tolerance, const CanonicalPose& pose = {});

}  // namespace flare
