// SPDX-License-Identifier: Apache-2.0
//
// How a ghost moves over the picture when its light turns, which is what a light of some size blurs
// it by. A ghost's edge is the image of a mask's, and its caustics move with the rays that make
// them: every edge and fold has its own speed across itself, and the ghost's motion is the one
// matrix that fits them best, weighted by the light that a wrong speed would misplace. For an edge
// that the iris cuts, this is d(sensor)/d(angle) at a fixed stop point; for a rim's, at a fixed
// point of the rim; at a fixed point of the front it would be another number. What the fit leaves
// over tells how wrong one matrix is. Formulas: docs/physics/area-lights.md.
//
// From some 850 rays in columns, 0.2 ms a ghost. Continuous like a GhostSample.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/render/ghost_sample.h"

namespace flare {

struct GhostMotion {
    bool known = false;  // some edge of it was seen
    // Pixels a radian when the light's travel leans towards +u and +v (LightBundle).
    Vec2d along_u{0.0, 0.0}, along_v{0.0, 0.0};
    // Estimated rel_l1 of the ghost when the whole source is blurred by this one matrix.
    double error = 0.0;
    std::uint64_t rays = 0;
};

// Of the ghost whose rays pass in `region` (GhostSample) for a source of this radius.
GhostMotion MotionOf(const SampleScene& scene, const BounceSequence& sequence, const Rect& region,
                     double radius_rad);

// How far the image of a disc of this radius reaches, pixels along each axis.
inline Vec2d ReachOf(const GhostMotion& motion, double radius_rad) {
    return Vec2d(std::hypot(motion.along_u.x, motion.along_v.x),
                 std::hypot(motion.along_u.y, motion.along_v.y)) *
           radius_rad;
}

}  // namespace flare
