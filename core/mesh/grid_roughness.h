// SPDX-License-Identifier: Apache-2.0
//
// How well cubic interpolation between the vertices of a main grid would do, from differences of
// the vertices alone. Used by the mesh builder to choose patches.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh/raw_grid.h"

namespace flare {

// Against the tolerances: kRough misses them, kVery by more than eight times.
enum class Roughness : std::uint8_t { kUnknown, kSmooth, kRough, kVery };

// A rim ratio^2 as meshes store it, see GhostMesh.
inline double RimField(double ratio2) {
    return (ratio2 - 1.0) / (ratio2 + 1.0);
}

// Of one main grid. All arguments must outlive it.
class GridRoughness {
  public:
    GridRoughness(const GridTracer& tracer, const MeshSpec& spec, const Lens& lens,
                  const RawGrid& main);

    // At the cell's worst corner.
    Roughness Worst(int i, int j);

  private:
    // Five rays in a row along one direction, and how x and y of each count: those of mirror images
    // have one of them turned round.
    struct Stencil {
        std::array<std::size_t, 5> ray{};
        std::array<bool, 5> mirrored{};
    };

    Roughness At(int i, int j, std::size_t direction);
    // By this share of the tolerances.
    bool Rough(int i, int j, int di, int dj, double share) const;
    std::array<double, 5> Values(const float* column, std::size_t axis, const Stencil& at) const;
    bool RoughPlace(const TraceColumns& node, const Stencil& at, double share) const;
    bool RoughStop(const TraceColumns& node, const Stencil& at, double share) const;
    bool RoughMasks(const TraceColumns& node, const Stencil& at, double share) const;

    const GridTracer& tracer_;
    const MeshSpec& spec_;
    const RawGrid& main_;
    double sensor_gap_mm_, stop_semi_diameter_mm_;
    std::vector<Roughness> judged_;  // [vertex][direction]
};

}  // namespace flare
