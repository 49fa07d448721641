// SPDX-License-Identifier: Apache-2.0
//
// Where a line meets a surface, in double precision; the truth for every faster intersection. Of
// the points where the line crosses the surface it is the one where it passes from the front to
// the back (forward) or from the back to the front, whatever the direction of travel looks like
// from the axis: light beyond 90 degrees, as a fisheye sees it, is met rightly too.
//
// Planes, spheres, conics and cylinders in closed form, in curvature form from the point of the
// line nearest to the vertex (Welford, Aberrations of Optical Systems, ch. 4): no centre of
// curvature, which loses all digits for weak surfaces, and no division by d_z. Aspheres and toroids
// by Newton's method from the conic or sphere beneath them, with a search and bisection where
// Newton does not settle. docs/physics/tracing.md.
#pragma once

#include "core/base/vec.h"
#include "core/optics/surface_shape.h"

namespace flare {

struct SurfaceHit {
    bool met = false;
    double distance = 0.0;       // along the line, mm
    Vec3d point{0.0, 0.0, 0.0};  // relative to the vertex
    // n . d with n towards the back of the surface, unit length; its sign is the crossing's.
    double cosine = 0.0;
    Vec3d normal{0.0, 0.0, 1.0};
};

// The line through p (relative to the vertex) along the unit vector d. The semi-diameter bounds the
// search on aspheres and toroids; hits beyond it are found as long as Newton's method finds them.
SurfaceHit MeetSurface(const SurfaceShape& shape, double semi_diameter_mm, bool forward,
                       const Vec3d& p, const Vec3d& d);

}  // namespace flare
