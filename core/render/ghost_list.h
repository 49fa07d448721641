// SPDX-License-Identifier: Apache-2.0
//
// The ranked list of a lens's ghosts for a collimated light that travels along
// (sin a cos b, sin a sin b, cos a) in lens space, a being the field angle and b the azimuth (0: in
// the x-z plane). Fluxes are per unit irradiance E0 perpendicular to the beam, so they are areas,
// mm^2.
#pragma once

#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/base/vec.h"
#include "core/optics/paraxial.h"
#include "core/render/renderer.h"

namespace flare {

// One passage of a ghost through the stop (first-order, d line).
struct GhostCrossing {
    double a1 = 0.0;        // A of front -> stop
    double m = 0.0;         // stop -> sensor magnification A / A1
    double z_eff_mm = 0.0;  // effective propagation distance B2 A1 / A
};

// A ghost's first-order path in one section.
struct GhostSection {
    Abcd abcd;                             // vertex 0 -> sensor
    std::vector<GhostCrossing> crossings;  // in the order the light meets the stop
    int largest_crossing = 0;              // index of the crossing with the largest |A1|
};

struct GhostEntry {
    std::vector<int> sequence;
    GhostSection x, y;             // equal for a rotational lens
    double flux_mm2 = 0.0;         // on the whole sensor plane
    Vec2d centroid_mm{0.0, 0.0};   // of the flux, lens space
    double peak_irradiance = 0.0;  // largest mean over an 18.75 um pixel, E0 = 1
};

struct GhostListOptions {
    double wavelength_nm = kLineD;
    std::optional<double> f_number;  // absent: wide open
    double field_deg = 0.0;
    double azimuth_deg = 0.0;
    ModelSpec model;         // which ghosts
    bool with_peaks = true;  // peaks need a raster of every ghost
};

struct GhostList {
    double total_flux_mm2 = 0.0;
    std::vector<GhostEntry> ghosts;  // brightest flux first
    std::optional<FourReflectionFacts> four_reflections;
};

Result<GhostList> RankGhosts(const std::shared_ptr<const Lens>& lens,
                             const GhostListOptions& options, const RenderContext& context);

}  // namespace flare
