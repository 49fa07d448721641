// SPDX-License-Identifier: Apache-2.0
//
// Random numbers by counter: Philox4x32-10 (Salmon, Moraes, Dror and Shaw 2011, "Parallel Random
// Numbers: As Easy as 1, 2, 3"). A pure function of key and counter, so that sample number n has
// the same numbers on any thread and in any order.
#pragma once

#include <array>
#include <cstdint>

namespace flare {

using PhiloxCounter = std::array<std::uint32_t, 4>;
using PhiloxKey = std::array<std::uint32_t, 2>;

constexpr PhiloxCounter Philox(PhiloxCounter c, PhiloxKey key) {
    for (int round = 0; round < 10; ++round) {
        const std::uint64_t a = std::uint64_t{0xD2511F53} * c[0];
        const std::uint64_t b = std::uint64_t{0xCD9E8D57} * c[2];
        c = {static_cast<std::uint32_t>(b >> 32) ^ c[1] ^ key[0], static_cast<std::uint32_t>(b),
             static_cast<std::uint32_t>(a >> 32) ^ c[3] ^ key[1], static_cast<std::uint32_t>(a)};
        key[0] += 0x9E3779B9;
        key[1] += 0xBB67AE85;
    }
    return c;
}

// In (0, 1): the middle of one of 2^32 equal parts.
constexpr double UnitFrom(std::uint32_t word) {
    return (static_cast<double>(word) + 0.5) * (1.0 / 4294967296.0);
}

}  // namespace flare
