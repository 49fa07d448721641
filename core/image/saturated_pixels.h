// SPDX-License-Identifier: Apache-2.0
//
// How many of the pixels [first, first + count) have a value beyond +-largest in one of the planes.
// A NaN is not beyond. Writers ask this only where a conversion has found such a value.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace flare {

inline std::uint64_t SaturatedPixels(const std::vector<const float*>& planes, std::size_t first,
                                     std::size_t count, float largest) {
    std::vector<unsigned char> saturated(count, 0);
    for (const float* plane : planes) {
        for (std::size_t i = 0; i < count; ++i) {
            if (std::abs(plane[first + i]) > largest) saturated[i] = 1;
        }
    }
    return static_cast<std::uint64_t>(
        std::count(saturated.begin(), saturated.end(), static_cast<unsigned char>(1)));
}

}  // namespace flare
