// SPDX-License-Identifier: Apache-2.0
//
// What a cell's Bezier nets tell about it without evaluating the surface: bounds, bends, lengths
// and how much the density of light changes.
#pragma once

#include "core/base/vec.h"
#include "core/mesh/ghost_surface.h"

namespace flare {

struct NetRange {
    double lo = 0.0, hi = 0.0;
};
NetRange RangeOf(const BezierNet& net);
// Of the net that has these values and slopes at its corners.
NetRange RangeOf(const CellJets& jets);

// Distance of the box of (x, y) values from the origin: its nearest and its farthest point.
double NearestToOrigin(const NetRange& x, const NetRange& y);
double FarthestFromOrigin(const NetRange& x, const NetRange& y);

// (x, y) = offset + per_x * x + per_y * y, in place.
void MapNets(BezierNet& x, BezierNet& y, const Vec2d& per_x, const Vec2d& per_y,
             const Vec2d& offset);
void MapNets(CellJets& x, CellJets& y, const Vec2d& per_x, const Vec2d& per_y, const Vec2d& offset);

// Largest second difference and largest length of the net's lines along u and along v.
struct NetShape {
    double bend_u = 0.0, bend_v = 0.0, length_u = 0.0, length_v = 0.0;
};
NetShape ShapeOf(const BezierNet& x, const BezierNet& y);
NetShape ShapeOf(const BezierNet& x);

// Relative change of the Jacobian over the cell, from its corners: 0 for an affine map, 2 across a
// fold.
double DensityChange(const BezierNet& x, const BezierNet& y);

// The four cubic Bernstein polynomials at t.
std::array<double, 4> Bernstein(double t);

}  // namespace flare
