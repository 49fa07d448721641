// SPDX-License-Identifier: Apache-2.0
//
// Dust and scratches on the stop, as a picture that multiplies what the iris lets through. Specks
// are discs whose diameters lie between half and twice the usual one, evenly over its logarithm;
// scratches straight strips with round ends. Both lie evenly over the disc of the stop's rim;
// specks keep clear of each other as long as there is room. The same numbers give the same dirt on
// any machine. Lengths are mm in the stop plane. Pure.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/vec.h"
#include "core/optics/stop_picture.h"

namespace flare {

struct StopDust {
    int count = 0;
    double size_mm = 0.1;
    double opacity = 1.0;  // 0..1: the share of light that a speck holds back
    std::uint64_t seed = 0;
};

struct StopScratches {
    int count = 0;
    double length_mm = 3.0, width_mm = 0.03;
    double opacity = 1.0;
    std::uint64_t seed = 0;
};

// All points nearer than `radius_mm` to the way from `a` to `b`.
struct StopMark {
    Vec2d a{0.0, 0.0}, b{0.0, 0.0};
    double radius_mm = 0.0;
    double opacity = 1.0;
};

std::vector<StopMark> MarksOf(const StopDust& dust, const StopScratches& scratches, double rim_mm);

// What passes between them, in units of the rim's radius, as IrisShape has a mask of the scale
// kStop. Marks narrower than two cells, of which there are at most 2048 across, keep their area but
// become grey. Takes up to a second or so where marks are fine. Null: no marks.
std::shared_ptr<const StopPicture> DirtyStop(const std::vector<StopMark>& marks, double rim_mm);

}  // namespace flare
