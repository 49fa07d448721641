// SPDX-License-Identifier: Apache-2.0
//
// Does a ghost of one light show diffraction fringes, by which model, and what draws them
// (docs/physics/ringing.md)? Rays around the iris tell, at each passage through the stop, over
// which distance the light that passes there spreads on its way to the sensor. Fringes that the
// light's disc, the pixel or the nature of the pattern hide fade out, so that nothing pops as a
// light moves.
#pragma once

#include <memory>
#include <optional>

#include "core/image/ghost_fringes.h"
#include "core/image/ghost_walk.h"
#include "core/mesh/ghost_mesh.h"
#include "core/render/lights.h"
#include "core/render/report.h"

namespace flare {

struct FringePlan {
    RingingFacts facts;
    std::shared_ptr<GhostFringes> fringes;  // without tables; none: the edges are sharp
};

// Keeps the facts that show more, of several passages or lights.
void JoinRinging(const RingingFacts& one, RingingFacts& all);

// `map`: sensor to picture; `spectral`: planes of one wavelength each. Costs some hundred rays.
FringePlan PlanFringes(const Lens& lens, const GhostMesh& mesh, const PlacedLight& light,
                       const Iris& iris, const PictureMap& map, bool spectral);

// Makes the tables for a ghost's drawn bands, which must not be changed any more. In colour a band
// stands for the wavelengths around it.
void FillTables(const Iris& iris, const GhostLight& ghost, bool spectral, GhostFringes& fringes);

}  // namespace flare
