// SPDX-License-Identifier: Apache-2.0
//
// The lines along which a grid of values crosses one half (marching squares; between the middles of
// cells the value goes linearly). Pure.
#pragma once

#include <vector>

#include "core/base/vec.h"

namespace flare {

// Closed loops, anticlockwise around what is above one half, in cells: cell (i, j) of the
// `side` x `side` grid, at values[j * side + i], has its middle at (i + 0.5, j + 0.5). Around the
// grid all is 0.
std::vector<std::vector<Vec2d>> OutlinesOf(const std::vector<float>& values, int side);

}  // namespace flare
