// SPDX-License-Identifier: Apache-2.0
//
// The exact sequential ray tracer in double precision: the truth that every faster tracer is tested
// against. Pure functions, safe from any thread.
//
// Intersections are those of surface_hit.h; docs/physics/tracing.md.
#pragma once

#include <vector>

#include "core/base/vec.h"
#include "core/optics/iris.h"
#include "core/tracing/interaction_list.h"
#include "core/tracing/ray_fate.h"

namespace flare {

struct Ray {
    Vec3d origin;     // lens space, mm
    Vec3d direction;  // unit length
};

// What the ray met, one entry an interaction as far as it came. Reused between rays.
struct RayRecord {
    std::vector<double> cos_in;      // cosine of incidence, 0..1 (1 at the stop: unused)
    std::vector<double> rim_ratio2;  // (distance from the axis / semi-diameter)^2
    std::vector<double> segment_mm;  // from the interaction before (the first: from the origin)
    std::vector<Vec2d> stop_mm;      // one a stop crossing
    std::vector<Vec3d> points;       // where it met each interaction, filled only if asked
};

struct TraceResult {
    RayFate fate = RayFate::kMissed;
    int ended_at = -1;  // index of the interaction where a lost ray ended, -1: at the sensor
    bool out_of_order = false;         // met a surface behind the one before, seen along the ray
    bool out_of_order_inside = false;  // ... and within the rims of all surfaces met so far
    Vec2d sensor_mm{0.0, 0.0};
    Vec3d exit_direction{0.0, 0.0, 1.0};
    double path_mm = 0.0;         // optical length from the ray's origin
    double max_rim_ratio2 = 0.0;  // over all surfaces met but the stop
};

struct TraceOptions {
    bool clip = true;            // end a ray at a rim, the iris or a surface met out of order
    const Iris* iris = nullptr;  // with clip; null: the stop's own rim
    bool record_points = false;
};

// Two hits along a ray count as in order if the second lies no more than this before the first.
inline constexpr double kOrderTolerance_mm = 1e-7;

// `record` may be null.
TraceResult TraceRay(const InteractionList& list, const Ray& ray, const TraceOptions& options,
                     RayRecord* record);

// Product of unpolarised R and T and of what the glass lets through along the path, from the
// recorded cosines and segments.
double PathWeight(const Lens& lens, const InteractionList& list, const RayRecord& record);

}  // namespace flare
