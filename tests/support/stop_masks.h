// SPDX-License-Identifier: Apache-2.0
//
// Masks for the stop, drawn from shapes that are known exactly.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/optics/stop_picture.h"

namespace flare::testing {

// A shape drawn by 8 x 8 points a cell.
template <class Inside>
inline StopGrid Drawn(int side, double half_width_mm, Inside inside) {
    StopGrid grid{side, half_width_mm, {}};
    constexpr int kPoints = 8;
    for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
            int hits = 0;
            for (int k = 0; k < kPoints * kPoints; ++k) {
                const double x = i + (k % kPoints + 0.5) / kPoints;
                const double y = j + (k / kPoints + 0.5) / kPoints;
                const double cell = grid.cell_mm();
                hits += inside(Vec2d(x * cell - half_width_mm, y * cell - half_width_mm)) ? 1 : 0;
            }
            grid.values.push_back(static_cast<float>(hits) / (kPoints * kPoints));
        }
    }
    return grid;
}

// Of five points, radii 8 and 3.2 mm, a point at +y.
inline bool InStar(Vec2d p) {
    const double turn = std::fmod(std::atan2(p.x, p.y) + 10.0 * kPi, 0.4 * kPi);
    const double angle = std::min(turn, 0.4 * kPi - turn);
    const Vec2d q(p.length() * std::cos(angle), p.length() * std::sin(angle));
    const Vec2d tip(8.0, 0.0);
    const Vec2d inner(3.2 * std::cos(0.2 * kPi), 3.2 * std::sin(0.2 * kPi));
    return (inner - tip).cross(q - tip) > 0.0;
}

inline constexpr double kStarArea = 10.0 * 0.5 * 8.0 * 3.2 * 0.58778525229247313;  // sin 36 degrees

}  // namespace flare::testing
