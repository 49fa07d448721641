// SPDX-License-Identifier: Apache-2.0
//
// Traces the mesh of one ghost for one light. The result depends on the key's values alone.
#pragma once

#include <vector>

#include "core/base/fingerprint.h"
#include "core/mesh/ghost_mesh.h"
#include "core/tracing/light_bundle.h"

namespace flare {

// What rays are traced in. Floats go many at once (trace_columns.h); a ghost that they place too
// far from the reference, by a sample of its rays, is traced in doubles after all.
enum class MeshArithmetic { kFloat, kDouble };

struct MeshSpec {
    BounceSequence sequence;
    double field_rad = 0.0;
    double azimuth_rad = 0.0;            // of the canonical light (CanonicalPose)
    double inverse_distance = 0.0;       // 1/mm
    std::vector<double> wavelengths_nm;  // traced; other wavelengths are interpolated between them
    int cells = 32;                      // of the grid along each side of the pass region
    int patch_cells = 8;  // of the finer grid inside a cell that needs one (0: none):
                          // rays die in it, or cubic interpolation is too far off:
    double position_tolerance_mm = 0.005;  // on the sensor
    double mask_tolerance = 0.002;         // at the stop and the rims, in semi-diameters
    double cosine_tolerance = 0.001;       // of a squared cosine near the critical angle
    MeshArithmetic arithmetic = MeshArithmetic::kFloat;
};

// Names the mesh of `spec` for `lens`: shape, glass and rims, not coatings; the sensor's place only
// if the sequence reflects there. Meshes in floats bear the name of the instructions that traced
// them (ArithmeticClass).
Fingerprint MeshKey(const Lens& lens, const MeshSpec& spec);

GhostMesh BuildMesh(const Lens& lens, const MeshSpec& spec);

}  // namespace flare
