// SPDX-License-Identifier: Apache-2.0
//
// A rendered picture as named float planes over a pixel window, before it is written to a format.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/chromaticities.h"
#include "core/image/plane_values.h"

namespace flare {

struct PixelWindow {
    int x = 0, y = 0;  // first pixel, in the full frame's coordinates; y grows downwards
    int width = 0, height = 0;

    std::size_t pixels() const {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    }
    friend bool operator==(const PixelWindow&, const PixelWindow&) = default;
};

// One channel: width x height floats of the data window, row by row from the top.
struct ImagePlane {
    std::string name;    // "R", "ghosts.R", "S0.587,5618nm", ...
    PlaneValues values;  // planes may share them
};

struct FlareImage {
    PixelWindow full;  // the frame that was asked for: x = y = 0
    PixelWindow data;  // what the planes hold (crop or overscan)
    double pixel_aspect = 1.0;
    std::vector<ImagePlane> planes;
    // Header attributes: text and numbers, in this order.
    std::vector<std::pair<std::string, std::string>> text_attributes;
    std::vector<std::pair<std::string, double>> number_attributes;
    // The header's chromaticities: those of linear Rec.709 with D65 white, or else these, or none.
    bool rec709 = true;
    std::optional<Chromaticities> chromaticities;
};

}  // namespace flare
