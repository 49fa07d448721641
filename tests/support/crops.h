// SPDX-License-Identifier: Apache-2.0
//
// A crop against the frame that it was cut from.
#pragma once

#include <gtest/gtest.h>

#include <array>

#include "core/image/flare_image.h"

namespace flare::testing {

// The crop is that window (x, y, w, h) of the frame, and plane number `plane` has the frame's bits.
inline void ExpectIsCropOf(const FlareImage& whole, const FlareImage& crop,
                           const std::array<int, 4>& window, std::size_t plane = 0) {
    const auto [x0, y0, width, height] = window;
    ASSERT_EQ(crop.data, (PixelWindow{x0, y0, width, height}));
    const auto at = [&](const FlareImage& image, int x, int y) {
        return image.planes[plane].values[static_cast<std::size_t>(
            (y - image.data.y) * image.data.width + x - image.data.x)];
    };
    for (int y = y0; y < y0 + height; ++y) {
        for (int x = x0; x < x0 + width; ++x)
            ASSERT_EQ(at(crop, x, y), at(whole, x, y)) << plane << ": " << x << " " << y;
    }
}

}  // namespace flare::testing
