// SPDX-License-Identifier: Apache-2.0
//
// The inner loop of a convolution, in SIMD (Highway; the widest instructions that the processor has
// are chosen at run time). Products and sums are rounded one by one and in one order, so the
// results are the same bits whatever the instructions.
#pragma once

#include <span>

namespace flare {

// Pixels that are summed up together.
inline constexpr int kBlurRun = 64;

// A row of light that a row of weights is laid over: pixel k of the run gets weights[i] * light[k -
// i] for i from `first` to before `end`.
struct BlurRow {
    const float* light = nullptr;
    const float* weights = nullptr;
    int first = 0, end = 0;
};

// Sets all of `sums` (kBlurRun of them).
void SumBlurRows(std::span<const BlurRow> rows, float* sums);

}  // namespace flare
