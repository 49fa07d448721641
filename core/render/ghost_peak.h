// SPDX-License-Identifier: Apache-2.0
//
// How bright a ghost is where it is brightest: at a caustic, which a mesh's corners do not show.
// The ghost is cut into pieces as for drawing, but coarsely and without a picture: light that falls
// on less than a few pixels is added up pixel by pixel in a sparse map. Within a factor of two
// (tests/physics/four_reflections_test.cpp), a few ms a ghost.
#pragma once

#include <memory>

#include "core/image/ghost_walk.h"
#include "core/mesh/transmission.h"
#include "core/tracing/light_bundle.h"

namespace flare {

// Largest mean irradiance over a pixel of kPeakPixel_mm, for E0 = 1, at the first wavelength of
// `tables`.
double PeakOfPieces(const std::shared_ptr<const GhostSurface>& surface, const LightBundle& bundle,
                    const Lens& lens, const TransmissionTables& tables, const Iris& iris,
                    const CanonicalPose& pose);

}  // namespace flare
