// SPDX-License-Identifier: Apache-2.0
//
// FreeD's D1 message: where a camera stands and how its lens is set, 29 bytes, big endian. Byte 0
// is D1, byte 1 the camera's id, then pan, tilt and roll (signed, 1/32768 degree) and x, y and z
// (signed, 1/64 mm) of three bytes each, zoom and focus as unsigned counts of three, two bytes that
// are free, and a checksum that makes the sum of all bytes 0x40. The lens's counts need a
// calibration table. Source: the published Vinten Radamec free-d manual, appendix A.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/result.h"

namespace flare {

inline constexpr std::size_t kFreeDBytes = 29;

struct FreeDMessage {
    int camera = 0;
    std::uint32_t zoom = 0, focus = 0;
    std::uint16_t spare = 0;
};

std::uint8_t FreeDChecksum(std::span<const std::uint8_t> bytes);

// Error code "bad_data".
Result<FreeDMessage> DecodeFreeD(std::span<const std::uint8_t> bytes);

}  // namespace flare
