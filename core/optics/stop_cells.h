// SPDX-License-Identifier: Apache-2.0
//
// The cells behind a StopPicture: values, their means and bounds over larger and larger cells, and
// the distance to edges. Everything is in cells, from the grid's lower left corner. Immutable once
// built; side for side as large as the grid.
#pragma once

#include <vector>

#include "core/optics/stop_picture.h"

namespace flare {

inline constexpr float kStopBand = 4.0F;  // distances to edges are known up to here

struct StopPlane {
    int side = 0;
    std::vector<float> values;
};

// Between the middles of cells; beyond the plane all is `outside`.
float Bilinear(const StopPlane& plane, const Vec2d& p, float outside);

struct StopCells {
    StopCells(int side, std::vector<float> values, bool sharp_edges);

    void MakeLevels();
    void FindEdges();
    void FindShades(const std::vector<float>& values);
    void MakeRanges();
    void MeasureRadii();
    StopRange Over(Vec2d lo, Vec2d hi) const;
    double ShadeAt(const StopPlane& shade, const Vec2d& p, double otherwise) const {
        return shade.side == 0 ? otherwise : static_cast<double>(Bilinear(shade, p, 0.0F));
    }
    double DistanceAt(const Vec2d& p) const {
        return static_cast<double>(Bilinear(distance, p, kStopBand));
    }
    double SharpAt(const Vec2d& p, const Vec2d& right, const Vec2d& down, const Vec2d& smear) const;

    bool sharp;
    std::vector<StopPlane> levels;      // means over 2^level cells a side
    std::vector<StopPlane> lo, hi;      // of what interpolation may give in each cell
    StopPlane distance;                 // sharp: to the nearest edge, negative in the light
    StopPlane light_shade, dark_shade;  // on both sides of edges; empty: 1 and 0
    std::vector<std::vector<Vec2d>> outlines;
    double area = 0.0, outer_radius = 0.0, clear_radius = 0.0;
    Fingerprint fingerprint;  // of the values
};

}  // namespace flare
