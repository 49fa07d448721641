// SPDX-License-Identifier: Apache-2.0
#include "server/translate/ring_steps.h"

#include <algorithm>
#include <cmath>

namespace flare {
namespace {

// A ring that says more than this says nonsense; the lens clamps it.
constexpr double kMost = 1e15;

}  // namespace

RingSteps RingSteps::For(const Lens& lens, const wire::FlareRequest& request) {
    const StateTable& states = lens.prescription().states;
    RingSteps steps;
    if (states.focal_mm.size() > 1) steps.zoom_ = kZoomStep;
    const double f_mm = states.focal_mm.empty()
                            ? std::max(std::abs(lens.first_order(Section::kX).efl_mm),
                                       std::abs(lens.first_order(Section::kY).efl_mm))
                            : states.focal_mm.back();
    const bool lights_by_pixel =
        std::any_of(request.lights.begin(), request.lights.end(),
                    [](const wire::Light& light) { return light.pixel.has_value(); });
    if ((!states.focus_m.empty() || lights_by_pixel) && std::isfinite(f_mm)) {
        constexpr double kMillimetresInMetre = 1e3;
        steps.focus_per_m_ = kMillimetresInMetre * kImageStep_mm / (f_mm * f_mm);
    }
    return steps;
}

RingCell RingSteps::CellOf(const LensReading& reading) const {
    const auto whole = [](double steps) {
        return static_cast<std::int64_t>(std::llround(std::clamp(steps, -kMost, kMost)));
    };
    RingCell cell;
    const auto& focus = reading[LensAxis::kFocus];
    const auto& zoom = reading[LensAxis::kZoom];
    if (focus && focus_per_m_ > 0.0) cell.focus = whole(1.0 / *focus / focus_per_m_);
    if (zoom && zoom_ > 0.0) cell.zoom = whole(std::log(*zoom) / zoom_);
    return cell;
}

LensReading RingSteps::Put(RingCell cell, LensReading reading) const {
    auto& focus = reading[LensAxis::kFocus];
    auto& zoom = reading[LensAxis::kZoom];
    if (focus && focus_per_m_ > 0.0) {
        focus = 1.0 / (static_cast<double>(cell.focus) * focus_per_m_);  // 1/0: infinity
    }
    if (zoom && zoom_ > 0.0) zoom = std::exp(static_cast<double>(cell.zoom) * zoom_);
    return reading;
}

}  // namespace flare
