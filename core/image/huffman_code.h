// SPDX-License-Identifier: Apache-2.0
//
// A prefix code for Deflate (RFC 1951, 3.2.2) from the counts of its symbols: short for frequent
// ones, never longer than `longest` bits. Depends on the counts alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace flare {

struct HuffmanCode {
    std::vector<std::uint8_t> lengths;  // bits of each symbol, 0 where it does not occur
    std::vector<std::uint16_t> codes;   // with the first bit lowest, as Deflate writes them
};

// A symbol that occurs alone gets one bit. There must be room: at most 2^longest symbols occur.
HuffmanCode MakeHuffmanCode(std::vector<std::uint32_t> counts, int longest);

}  // namespace flare
