// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

namespace flare {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kMmPerMetre = 1000.0;

constexpr double RadiansFromDegrees(double degrees) {
    return degrees * (kPi / 180.0);
}
constexpr double DegreesFromRadians(double radians) {
    return radians * (180.0 / kPi);
}

}  // namespace flare
