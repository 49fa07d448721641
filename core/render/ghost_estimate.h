// SPDX-License-Identifier: Apache-2.0
//
// The light of one ghost straight from its mesh, without drawing it: good to about one percent
// of the flux (tests/physics/ghost_estimate_test.cpp), at a hundredth of the cost of
// ghost_flux.h, which is exact. For reports and for choosing what to draw.
#pragma once

#include "core/image/ghost_walk.h"
#include "core/mesh/transmission.h"
#include "core/tracing/light_bundle.h"

namespace flare {

inline constexpr double kPeakPixel_mm = 0.01875;  // over which a peak is a mean

struct GhostEstimate {
    double flux_mm2 = 0.0;        // on the whole sensor plane, for E0 = 1
    Vec2d centroid_mm{0.0, 0.0};  // of that light, canonical lens space
    // Largest mean over a pixel of kPeakPixel_mm, as far as the mesh resolves it: near a caustic it
    // is within a factor of a few.
    double peak_irradiance = 0.0;
};

// At the first wavelength of `tables`, which must be one that the mesh was traced at or between.
GhostEstimate EstimateOf(const GhostSurface& surface, const LightBundle& bundle, const Lens& lens,
                         const TransmissionTables& tables, const Iris& iris,
                         const CanonicalPose& pose);

}  // namespace flare
