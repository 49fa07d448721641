// SPDX-License-Identifier: Apache-2.0
//
// Float to half precision (IEEE 754 binary16) as every writer of ours does it: rounded to nearest,
// ties to even, and set to +-65504 where half cannot hold the value, so that Inf never comes out.
// NaN stays NaN, made quiet, with the upper bits of its payload. Pure functions, same bits on every
// machine; a line of a picture costs a small part of a nanosecond a value where the processor
// converts by itself (F16C), ten times that where it does not.
#pragma once

#include <cstddef>
#include <cstdint>

namespace flare {

inline constexpr float kLargestHalf = 65504.0f;

// Writes the bits of `count` values to `halves`; says whether one of them was beyond +-65504.
bool ConvertToHalf(const float* values, std::size_t count, std::uint16_t* halves);

// The same without special instructions, for processors that lack them and as a second opinion.
bool ConvertToHalfPortably(const float* values, std::size_t count, std::uint16_t* halves);

}  // namespace flare
