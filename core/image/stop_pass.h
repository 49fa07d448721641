// SPDX-License-Identifier: Apache-2.0
//
// How much of a small piece of a ghost passes the iris's picture, from where its corners cross the
// stop. Pure.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/optics/stop_picture.h"

namespace flare {

// Where the corners (0,0), (1,0), (1,1), (0,1) of a piece cross the stop, mm; between them the
// place goes bilinearly.
using StopCorners = std::array<Vec2d, 4>;

inline StopRange PassRange(const StopPicture& picture, const StopCorners& at) {
    Vec2d lo = at[0];
    Vec2d hi = at[0];
    for (const Vec2d& p : at) {
        lo = {std::min(lo.x, p.x), std::min(lo.y, p.y)};
        hi = {std::max(hi.x, p.x), std::max(hi.y, p.y)};
    }
    // What a mean over the piece looks at.
    const Vec2d room = (hi - lo) / 3.0;
    return picture.Over(lo.x - room.x, lo.y - room.y, hi.x + room.x, hi.y + room.y);
}

inline double PassMean(const StopPicture& picture, const StopCorners& at) {
    return picture.Mean({(at[0] + at[1] + at[2] + at[3]) * 0.25,
                         (at[1] - at[0] + at[2] - at[3]) * 0.5,
                         (at[3] - at[0] + at[2] - at[1]) * 0.5,
                         {0.0, 0.0}});
}

}  // namespace flare
