// SPDX-License-Identifier: Apache-2.0
//
// How much of each cell of a grid lies inside closed loops of straight sides: exact areas, for
// apertures that are to be transformed. Loops that turn the same way add up, the other way they
// subtract (holes). Pure; cost is proportional to the length of the loops in cells plus the grid.
#pragma once

#include <vector>

#include "core/base/vec.h"

namespace flare {

// A closed loop; the last point joins the first.
using Loop = std::vector<Vec2d>;

// Positive if the loop runs anticlockwise (x right, y up).
double SignedArea(const Loop& loop);

// Share 0..1 of each cell of a grid of `side` x `side` cells of size `pitch`, cell (i, j) centred
// at ((i - side / 2) pitch, (j - side / 2) pitch), at [j * side + i]. The loops must lie in the
// grid.
std::vector<double> Coverage(const std::vector<Loop>& loops, int side, double pitch);

// Samples of the aperture in place of means over cells: what averaging over a cell takes from high
// frequencies f, a factor sinc(f pitch) in each direction, is given back to fourth order (the
// mean less 1/24 of its second difference). For transforms; values near edges leave 0..1.
std::vector<double> Sharpened(const std::vector<double>& shares, int side);

}  // namespace flare
