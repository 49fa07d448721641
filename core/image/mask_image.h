// SPDX-License-Identifier: Apache-2.0
//
// A PNG as a mask: of any bit depth and colour type, interlaced or not. White is 1, black 0; colour
// counts by its luminance, transparency as black. Numbers are taken as they stand, without gamma:
// the grey of an antialiased edge says how much of the pixel is covered. Safe from any thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace flare {

struct MaskImage {
    int width = 0, height = 0;
    std::vector<float> values;  // row by row from the top
};

// Sides above `most_side` are refused ("limit") before anything is decoded; what is no PNG, or a
// broken one, is "bad_image".
Result<MaskImage> DecodeMaskPng(std::string_view bytes, int most_side);

// A grey PNG of 16 bits that DecodeMaskPng reads back; values outside 0..1 are cut off.
std::string EncodeMaskPng(const MaskImage& mask);

}  // namespace flare
