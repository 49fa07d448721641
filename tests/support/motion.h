// SPDX-License-Identifier: Apache-2.0
//
// A request whose light, iris, zoom, focus or distance moves in small equal steps, and how much the
// picture changes from one step to the next: where that is far above the median, something popped.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/check.h"
#include "core/base/units.h"
#include "core/image/flare_image.h"
#include "core/optics/lens_state.h"
#include "core/render/flare_request.h"

namespace flare::testing {

enum class Moving { kLight, kIris, kZoom, kFocus, kDistance };

// What stands still, and where the sweep begins.
struct Motion {
    Moving moving = Moving::kLight;
    std::shared_ptr<const Lens> lens;  // as Lens::Build made it
    double from = 2.0;   // degrees; f-number; mm; m; m. Focus and distance go in equal steps of 1/m
    double step = 0.01;  // degrees; the others are factors: 0.01 is one per cent, 1/m are added
    double field_deg = 5.0, azimuth_deg = 20.0, f_number = 4.0;
    int width = 480, height = 270;
    QualityPreset quality = QualityPreset::kPreview;
};

inline double MovedValue(const Motion& motion, int frame) {
    switch (motion.moving) {
        case Moving::kLight:
            return motion.from + motion.step * frame;
        case Moving::kIris:
        case Moving::kZoom:
            return motion.from * std::pow(1.0 + motion.step, frame);
        case Moving::kFocus:
        case Moving::kDistance:
            break;
    }
    return 1.0 / (1.0 / motion.from + motion.step * frame);
}

inline FlareRequest FrameOf(const Motion& motion, int frame) {
    const double value = MovedValue(motion, frame);
    FlareRequest request;
    LensState state;
    if (motion.moving == Moving::kZoom) state.zoom_mm = value;
    if (motion.moving == Moving::kFocus) state.focus_m = value;
    const Result<LensInState> set = SetState(motion.lens, state);
    FLARE_CHECK(set.ok());
    request.lens = set->lens;
    request.state = set->state;
    request.f_number = motion.moving == Moving::kIris ? value : motion.f_number;
    request.image.width = motion.width;
    request.image.height = motion.height;
    request.quality = motion.quality;
    const double field =
        RadiansFromDegrees(motion.moving == Moving::kLight ? value : motion.field_deg);
    const double azimuth = RadiansFromDegrees(motion.azimuth_deg);
    LightSpec light;
    light.direction = Vec3d(-std::sin(field) * std::cos(azimuth),
                            std::sin(field) * std::sin(azimuth), std::cos(field));
    if (motion.moving == Moving::kDistance) light.distance_m = value;
    request.lights = {light};
    return request;
}

// sum |E - Eb| / sum |Eb| over the first three planes, the picture of the frame before being b.
inline double ChangeFrom(const FlareImage& before, const FlareImage& image) {
    double change = 0.0, all = 0.0;
    for (std::size_t p = 0; p < 3; ++p) {
        const std::vector<float>& a = before.planes[p].values;
        const std::vector<float>& b = image.planes[p].values;
        for (std::size_t k = 0; k < a.size(); ++k) {
            change += std::abs(static_cast<double>(b[k]) - static_cast<double>(a[k]));
            all += std::abs(static_cast<double>(a[k]));
        }
    }
    return all > 0.0 ? change / all : 0.0;
}

inline double Median(std::vector<double> values) {
    FLARE_CHECK(!values.empty());
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace flare::testing
