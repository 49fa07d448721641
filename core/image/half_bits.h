// SPDX-License-Identifier: Apache-2.0
//
// Float to half precision as every writer of ours does it: rounded to nearest, and set to +-65504
// where half cannot hold the value, so that Inf never comes out. NaN stays NaN.
#pragma once

#include <Imath/half.h>

#include <algorithm>
#include <limits>

namespace flare {

inline constexpr float kLargestHalf = 65504.0f;

inline Imath::half SaturatedHalf(float value) {
    // A NaN passes std::clamp: it is neither below nor above.
    return Imath::half(std::clamp(value, -kLargestHalf, kLargestHalf));
}

inline float SaturatedFloat(float value) {
    return std::clamp(value, -std::numeric_limits<float>::max(), std::numeric_limits<float>::max());
}

}  // namespace flare
