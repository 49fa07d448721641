// SPDX-License-Identifier: Apache-2.0
//
// Vectors are Imath's, in double precision. Lens space: origin at the vertex of surface 0, z
// towards the sensor, x right, y up as seen from behind the camera; millimetres
// (docs/conventions.md).
#pragma once

#include <Imath/ImathVec.h>

namespace flare {

using Vec2d = Imath::V2d;
using Vec3d = Imath::V3d;

}  // namespace flare
