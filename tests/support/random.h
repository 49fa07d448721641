// SPDX-License-Identifier: Apache-2.0
//
// Random numbers that are the same on every machine and in every library (splitmix64), so that a
// test that fails fails everywhere.
#pragma once

#include <cstdint>

namespace flare::testing {

class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}

    double Uniform(double lo, double hi) {
        return lo + (hi - lo) * (static_cast<double>(Next() >> 11U) * 0x1p-53);
    }
    // 0 ... count - 1.
    int Below(int count) { return static_cast<int>(Next() % static_cast<std::uint64_t>(count)); }

  private:
    std::uint64_t Next() {
        state_ += 0x9e3779b97f4a7c15U;
        std::uint64_t z = state_;
        z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
        z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
        return z ^ (z >> 31U);
    }

    std::uint64_t state_;
};

}  // namespace flare::testing
