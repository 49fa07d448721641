// SPDX-License-Identifier: Apache-2.0
//
// Many rays through one bounce sequence at once, in single precision and SIMD (Highway; the widest
// instructions that the processor has are chosen at run time). The fast twin of trace_reference.h:
// the same formulas, unclipped, one lane a ray, masks in place of branches, positions relative to
// the vertex at hand so that floats keep their digits. Results depend on the instructions chosen
// by some units in the last place (fused multiply-add); ArithmeticClass names the choice.
//
// Rims and stop are recorded, not applied; a ray goes on until it misses a surface or is totally
// reflected. Errors against the reference: docs/physics/tracing.md. Pure, safe from any thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/tracing/interaction_list.h"
#include "core/tracing/trace_reference.h"

namespace flare {

// Rays by column, in lens space but with z from the vertex of the first interaction. Choose the
// origin near that vertex: floats lose digits with distance.
struct RayColumns {
    std::vector<float> x, y, z, dx, dy, dz;

    std::size_t size() const { return x.size(); }
    void Resize(std::size_t rays);
    void Set(std::size_t ray, const Vec3d& from_first_vertex, const Vec3d& direction);
};

// What to record besides the ray behind the lens.
struct ColumnNeeds {
    bool passage = true;        // rare_cos2 of every interaction
    bool hits = false;          // where every interaction was met
    std::vector<int> segments;  // interactions whose way from the one before is wanted
};

// [k] is ray k; [s * stride + k] ray k at interaction s, where stride() >= rays.
struct TraceColumns {
    static constexpr std::int32_t kArrived = -1;

    std::size_t rays = 0, stride = 0;
    std::vector<std::int32_t> ended_at;  // interaction at which a ray was lost; kArrived
    std::vector<std::uint8_t> fate;      // RayFate: arrived, missed or tir
    // 1 if surfaces were met out of order, 2 if that happened within all rims met so far.
    std::vector<std::uint8_t> disorder;
    // Behind the lens: place in the tangent plane of the last interaction's vertex, and slopes.
    std::vector<float> exit_x, exit_y, slope_x, slope_y;
    std::vector<float> path_mm;     // optical length from the origin to that place
    std::vector<float> rim_ratio2;  // (distance from the axis / semi-diameter)^2, each interaction
    std::vector<float> rare_cos2;   // as in transmission.h, each interaction
    std::vector<float> stop_x, stop_y;  // each stop crossing
    std::vector<float> hit_x, hit_y;    // each interaction
    std::vector<float> segment_mm;      // each of ColumnNeeds::segments
};

// Reuses the memory of `out`.
void TraceInColumns(const InteractionList& list, const RayColumns& rays, const ColumnNeeds& needs,
                    TraceColumns& out);

// Names the arithmetic whose results are equal to the last bit: "AVX3", "AVX2", "SSE4", ...
std::string ArithmeticClass();

}  // namespace flare
