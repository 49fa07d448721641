// SPDX-License-Identifier: Apache-2.0
//
// A ghost as the lens bends it: a grid of exactly traced rays over the ghost's own pass region. A
// mesh knows neither the iris, nor the coatings, nor the colour of the light: at each vertex it
// keeps the ray behind the last surface, the place at every stop crossing, the rims' radius ratios,
// the incidence cosines and the ways through absorbing glass, and everything else is worked out
// from those. So one mesh serves every f-number, blade count, coating, spectrum and place of the
// sensor (unless the sensor itself reflects): unit focusing traces nothing. Geometry goes on past
// the rims; masks decide what passes.
//
// The light is in its canonical place (LightBundle); callers turn or mirror the result
// (CanonicalPose). Immutable once built.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/vec.h"
#include "core/tracing/bounce_sequence.h"

namespace flare {

enum class CellUse : std::uint8_t {
    kOutside,   // no ray of the cell passes
    kUsed,      // four living corners
    kTriangle,  // three living corners (only in patches)
    kPatched,   // a finer grid stands in for it
};

// The fields of one traced wavelength, in float: 1e-6 mm on a sensor.
struct MeshNode {
    double wavelength_nm = 0.0;
    std::vector<float> fields;   // [vertex][field]: see GhostMesh::stored_count
    std::vector<float> passage;  // [vertex][passage_count]: see transmission.h
};

struct MeshGrid {
    double u0 = 0.0, v0 = 0.0, du = 0.0,
           dv = 0.0;     // vertex (i, j) is the ray (u0 + i du, v0 + j dv)
    int nu = 0, nv = 0;  // vertices
    bool smooth = true;  // cubic between vertices; a patch with dead vertices is bilinear
    std::vector<std::uint8_t> alive;  // [vertex]: arrived at every traced wavelength
    std::vector<CellUse> cells;       // [(nv - 1) * (nu - 1)]
    std::vector<MeshNode> nodes;

    std::size_t Vertex(int i, int j) const {
        return static_cast<std::size_t>(j) * static_cast<std::size_t>(nu) +
               static_cast<std::size_t>(i);
    }
    std::size_t Cell(int i, int j) const {
        return static_cast<std::size_t>(j) * static_cast<std::size_t>(nu - 1) +
               static_cast<std::size_t>(i);
    }
};

struct GhostMesh {
    BounceSequence sequence;
    double field_rad = 0.0, azimuth_rad = 0.0;
    double inverse_distance = 0.0;
    int stop_crossings = 0;
    int interactions = 0;
    std::vector<int> rims;       // interactions whose rim cuts the ghost, one field each
    std::vector<int> absorbing;  // interactions that the light reaches through absorbing glass

    // grids[0] covers the pass region; the others are patches where it is too coarse or rays die.
    // Empty if nothing passes.
    std::vector<MeshGrid> grids;

    bool in_doubles = false;  // traced one ray at a time by the reference
    std::uint64_t rays_traced = 0;
    std::uint64_t ray_surfaces = 0;

    // Fields of a vertex: x, y on the sensor; x, y at each stop crossing, mm; for each rim in
    // `rims` (q - 1) / (q + 1) with q = (distance from the axis / semi-diameter)^2: negative
    // inside, bounded however far out a ray goes. Stored are x, y in the tangent plane of the last
    // vertex in place of those on the sensor and, after all other fields, the slopes dx/dz, dy/dz
    // behind it.
    int field_count() const { return 2 + 2 * stop_crossings + static_cast<int>(rims.size()); }
    int stored_count() const { return field_count() + 2; }
    int passage_count() const { return interactions + static_cast<int>(absorbing.size()); }
    int stop_field(int crossing) const { return 2 + 2 * crossing; }
    int rim_field(int rim) const { return 2 + 2 * stop_crossings + rim; }

    // Where the ray of a vertex, whose stored fields are `stored`, meets a sensor this far behind
    // the last vertex.
    Vec2d SensorPlace(const float* stored, double sensor_gap_mm) const {
        const float* const slope = stored + field_count();
        return {static_cast<double>(stored[0]) + sensor_gap_mm * static_cast<double>(slope[0]),
                static_cast<double>(stored[1]) + sensor_gap_mm * static_cast<double>(slope[1])};
    }

    std::size_t bytes() const;
};

}  // namespace flare
