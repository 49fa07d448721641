// SPDX-License-Identifier: Apache-2.0
//
// Discrete Fourier transforms of square complex arrays, by kissfft. Element (i, j) stands at
// [j * side + i], the origin at (0, 0), negative frequencies in the upper half: frequency k of a
// transform is element (k + side) mod side. Forward: sum of value * exp(-2 pi i k x / side), not
// normalised; Inverse: the other sign, divided by side^2, so that it undoes Forward.
//
// A plan is immutable and safe from any thread; the threads of the pool share the rows, and the
// result does not depend on how many they are.
#pragma once

#include <complex>
#include <memory>
#include <vector>

#include "core/base/parallel.h"

namespace flare {

using Complex = std::complex<double>;

class SquareFourier {
  public:
    // `side` is a power of two, 2 or more.
    explicit SquareFourier(int side);
    ~SquareFourier();
    SquareFourier(const SquareFourier&) = delete;
    SquareFourier& operator=(const SquareFourier&) = delete;

    int side() const { return side_; }
    void Forward(std::vector<Complex>& values, ThreadPool& threads) const;
    void Inverse(std::vector<Complex>& values, ThreadPool& threads) const;

  private:
    struct Plans;

    int side_;
    std::unique_ptr<const Plans> plans_;
};

}  // namespace flare
