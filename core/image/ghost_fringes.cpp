// SPDX-License-Identifier: Apache-2.0
#include "core/image/ghost_fringes.h"

#include <algorithm>
#include <cmath>

namespace flare {

double GhostFringes::PerMm(std::size_t crossing, Vec2d stop_mm, Vec2d normal,
                           double distance_mm) const {
    const Crossing& c = crossings[crossing];
    const Vec2d between = stop_mm - normal * (distance_mm / 3.0);
    // Beyond where it was sampled the polynomial is not to be trusted.
    const double outside = between.length() / (1.5 * c.unit_mm);
    const Vec2d p = between / (c.unit_mm * std::max(1.0, outside));
    const std::array<double, 6> powers = {1.0, p.x, p.y, p.x * p.x, p.x * p.y, p.y * p.y};
    std::array<double, 4> q{};
    for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t k = 0; k < 4; ++k) q[k] += c.bend[i][k] * powers[i];
    }
    // n . Q^-1 n, Q = (q0 q1; q2 q3); infinite at a fold.
    const double inverse = normal.x * (q[3] * normal.x - q[1] * normal.y) +
                           normal.y * (q[0] * normal.y - q[2] * normal.x);
    const double z = std::abs(inverse / (q[0] * q[3] - q[1] * q[2]));
    const double kept = std::isfinite(z) ? std::clamp(z, c.least_mm, c.most_mm) : c.most_mm;
    return std::sqrt(2.0 / (wavelength_mm * kept));
}

}  // namespace flare
