// SPDX-License-Identifier: Apache-2.0
//
// A picture as a sum of levels: level p has pixels of 2^p x 2^p, laid out from the same origin, for
// light that has no finer detail. Levels are opened out into each other, from the coarsest on: a
// pixel's light goes to the next finer pixels around with the weights 3/4 and 1/4 along each axis
// (quadratic B-splines in the limit), so that no light is lost and nothing has corners. Memory is
// taken by the levels that are used.
#pragma once

#include <optional>
#include <vector>

#include "core/image/source_kernel.h"

namespace flare {

class CoarseLevels {
  public:
    // `window` of level 0, from the origin that levels are laid out from.
    CoarseLevels(const PixelWindow& window, std::size_t channels);

    // The part of level p that the window needs.
    PixelWindow WindowOf(int level) const;
    LightPlanes& Level(int level);

    // Opens all levels out: the light of each pixel of the window. Leaves them black.
    LightPlanes Take(ThreadPool& threads);

  private:
    std::size_t channels_;
    std::vector<PixelWindow> windows_;
    std::vector<std::optional<LightPlanes>> levels_;
};

inline constexpr int kCoarsest = 7;

}  // namespace flare
