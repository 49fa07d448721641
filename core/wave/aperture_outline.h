// SPDX-License-Identifier: Apache-2.0
//
// The edge of an aperture: closed loops, anticlockwise around light and clockwise around holes,
// each cut into smooth pieces that meet in corners. Any unit of length; plain values.
#pragma once

#include <vector>

#include "core/base/vec.h"

namespace flare {

// Points of the edge in order, two or more, both ends included.
using EdgePiece = std::vector<Vec2d>;

struct EdgeLoop {
    // The last point of a piece is the first one of the next; the last piece joins the first.
    std::vector<EdgePiece> pieces;
    // One piece whose ends meet without a corner, as of a circle.
    bool smooth = false;
};

using ApertureOutline = std::vector<EdgeLoop>;

}  // namespace flare
