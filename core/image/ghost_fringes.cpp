// SPDX-License-Identifier: Apache-2.0
#include "core/image/ghost_fringes.h"

#include <algorithm>
#include <cmath>

namespace flare {

double GhostFringes::PerMm(std::size_t crossing, Vec2d stop_mm, Vec2d normal,
                           const StopOnPicture& on) const {
    const Crossing& c = crossings[crossing];
    // Beyond where it was sampled the polynomial is not to be trusted.
    const double outside = stop_mm.length() / (1.5 * c.unit_mm);
    const Vec2d p = stop_mm / (c.unit_mm * std::max(1.0, outside));
    const std::array<double, 6> powers = {1.0, p.x, p.y, p.x * p.x, p.x * p.y, p.y * p.y};
    std::array<double, 4> at{};
    for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t k = 0; k < 4; ++k) at[k] += c.spread[i][k] * powers[i];
    }
    const Vec2d picture(at[0] * normal.x + at[2] * normal.y, at[1] * normal.x + at[3] * normal.y);
    const double z = std::abs(normal.dot(on.right * picture.x + on.down * picture.y));
    // A fold has no inverse: its distance is the largest.
    const double kept = std::isfinite(z) ? std::clamp(z, c.least_mm, c.most_mm) : c.most_mm;
    return std::sqrt(2.0 / (wavelength_mm * kept));
}

}  // namespace flare
