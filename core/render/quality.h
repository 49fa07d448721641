// SPDX-License-Identifier: Apache-2.0
//
// What a quality means: how densely a ghost is traced, coloured and cut up. All settings follow
// from one tolerance, about the rel_l1 that they leave: draft is 0.05, preview 0.02, final 0.005;
// between those they go smoothly in its logarithm, but for the mesh, which stays that of the
// nearest preset so that tolerances share cached meshes. `reference` stands apart.
#pragma once

#include <optional>

#include "core/image/ghost_tiles.h"
#include "core/image/ghost_walk.h"
#include "core/mesh/mesh_builder.h"
#include "core/render/flare_request.h"

namespace flare {

struct QualitySettings {
    int mesh_cells = 32;                  // along each side of a ghost's pass region
    int patch_cells = 8;                  // of the finer grid where that is too coarse or rays die
    double position_tolerance_mm = 0.03;  // of interpolation in the mesh
    double mask_tolerance = 0.01;
    int traced_wavelengths = 3;
    int colour_bands = 21;            // where transmittances are evaluated, 380-780 nm
    double dispersion_step_px = 4.0;  // between two drawn wavelengths
    int most_drawn = 24;
    double light_tolerance = 2e-4;  // of transmittance interpolated within a cell
    WalkTolerance walk;
    std::optional<TileTolerance> tiles =
        std::nullopt;  // of colour pictures; absent: polygons alone
    MeshArithmetic arithmetic = MeshArithmetic::kFloat;
    // rel_l1 that the preset is to keep, and the share of it that culling may use up.
    double tolerance = 0.02;
    double culled_share = 0.25;
    // Of lights that are no points: rel_l1 that blurring by one motion may cost, directions along a
    // side of the source at most, and pixels across a semi-axis of what one direction is blurred by
    // at least, before pixels are made larger.
    double blur_tolerance = 0.01;
    int most_blur_side = 4;
    double least_blur_px = 2.0;
    bool cubic = true;  // between a mesh's vertices; false: bilinear
};

// Of a plan; a quality that is to be looked for gets those of its preset.
QualitySettings SettingsOf(const Quality& quality);
// The request's own, or its quality's.
QualitySettings SettingsOf(const FlareRequest& request);
QualitySettings SettingsFor(double tolerance);

// What a picture costs with its meshes at hand, against the coarsest tolerance: measured on four
// lenses, and towards the dearest of them (docs/accuracy.md). A guess, for planning alone.
double RelativeCost(double tolerance);

// Layers of the lens's most elaborate coating.
std::size_t MostCoatingLayers(const Lens& lens);

// The colour bands that a lens needs: the more layers a coating has, the faster its reflectance
// changes with wavelength. With 21 bands a ghost's colour is right to 0.12 % for one layer but only
// to 4 % for three and 35 % for a multilayer; with 41 to 0.007, 0.23 and 1.8 %
// (docs/physics/coatings.md). A thick stack gets eight bands a fringe, as far as there are any.
int ColourBandsFor(const Lens& lens, const QualitySettings& settings);

// Wavelengths that geometry is traced and drawn over for colour; light beyond is drawn at the ends.
inline constexpr double kTracedLow_nm = 405.0, kTracedHigh_nm = 705.0;
inline constexpr double kDrawnLow_nm = 415.0, kDrawnHigh_nm = 690.0;

}  // namespace flare
