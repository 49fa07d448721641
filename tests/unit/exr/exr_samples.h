// SPDX-License-Identifier: Apache-2.0
//
// Pictures for the tests of the image formats.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "core/image/flare_image.h"

namespace flare {

// Planes of smooth, distinct values.
inline FlareImage Gradient(int width, int height, const std::vector<std::string>& names) {
    FlareImage image;
    image.full = image.data = {0, 0, width, height};
    float phase = 0.0f;
    for (const std::string& name : names) {
        ImagePlane plane{name, {}};
        phase += 1.0f;
        for (std::size_t i = 0; i < image.data.pixels(); ++i) {
            plane.values.push_back(std::exp(std::sin(phase + 1e-3f * static_cast<float>(i))));
        }
        image.planes.push_back(std::move(plane));
    }
    return image;
}

}  // namespace flare
