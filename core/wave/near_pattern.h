// SPDX-License-Identifier: Apache-2.0
//
// The middle of a Fraunhofer pattern, as light inside rectangles: |F(k)|^2 of an aperture by one
// Fourier transform of its exact mask, summed up from the corner, so that any rectangle costs four
// look-ups and neighbouring ones lose nothing between them. Several outlines give the mean of their
// patterns (their light over the sum of their areas).
//
// Frequencies k are the inverse of the outline's unit. The pattern is normalised: over all k it
// holds 1. Valid for |k| up to limit(); about D k = 38 with `side` 1024 and 77 with 2048, D being
// the aperture's larger extent.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/base/parallel.h"
#include "core/base/vec.h"
#include "core/wave/aperture_outline.h"

namespace flare {

class NearPattern {
  public:
    // `side` is a power of two. With `without_core` the light inside the first dark ring (the
    // ellipse of the aperture's second moments; exact for discs) is left out.
    NearPattern(const std::vector<ApertureOutline>& outlines, int side, bool without_core,
                ThreadPool& threads);

    double limit() const { return limit_; }
    // Share of all light inside the first dark ring.
    double core_share() const { return core_share_; }

    // Lines across one direction at which rectangles begin and end, looked up once.
    struct Line {
        std::size_t first = 0;  // of six columns or rows
        std::array<double, 6> weights{};
    };
    Line LineAt(double k) const;
    // Light below and left of the crossing of two lines.
    double Below(const Line& x, const Line& y) const;

  private:
    void RemoveCore(const std::vector<ApertureOutline>& outlines, bool without_core);
    void ToCellMeans(std::size_t step);
    void SumUp();

    int side_;
    double cell_ = 0.0;  // in k
    double limit_ = 0.0;
    double core_share_ = 0.0;
    std::vector<double> cells_;  // light in each cell of k, k = 0 in the middle of cell side / 2
    std::vector<double> sums_;   // at the corners of cells: (side + 1)^2
};

}  // namespace flare
