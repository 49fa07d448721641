// SPDX-License-Identifier: Apache-2.0
#include "server/translate/ring_steps.h"

#include <algorithm>
#include <cmath>

namespace flare {
namespace {

// A ring that says more than this says nonsense; the lens clamps it.
constexpr double kMost = 1e15;

std::int64_t Whole(double steps) {
    return std::llround(std::clamp(steps, -kMost, kMost));
}

}  // namespace

RingSteps RingSteps::For(const Lens& lens, const wire::FlareRequest& request) {
    const StateTable& states = lens.prescription().states;
    RingSteps steps;
    if (states.focal_mm.size() > 1) {
        const auto [shortest, longest] =
            std::minmax_element(states.focal_mm.begin(), states.focal_mm.end());
        steps.zoom_ = kZoomStep;
        steps.zooms_mm_ = {*shortest, *longest};
    }
    if (!states.focus_m.empty()) {
        steps.nearest_m_ = *std::min_element(states.focus_m.begin(), states.focus_m.end());
    }
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

std::int64_t RingSteps::FocusCell(double focus_m) const {
    return Whole(1.0 / focus_m / focus_per_m_);
}

std::int64_t RingSteps::ZoomCell(double zoom_mm) const {
    return Whole(std::log(zoom_mm) / zoom_);
}

RingCell RingSteps::CellOf(const LensReading& reading) const {
    RingCell cell;
    const auto& focus = reading[LensAxis::kFocus];
    const auto& zoom = reading[LensAxis::kZoom];
    if (focus && focus_per_m_ > 0.0) cell.focus = FocusCell(*focus);
    if (zoom && zoom_ > 0.0) cell.zoom = ZoomCell(*zoom);
    return cell;
}

LensReading RingSteps::Put(RingCell cell, LensReading reading) const {
    auto& focus = reading[LensAxis::kFocus];
    auto& zoom = reading[LensAxis::kZoom];
    if (focus && focus_per_m_ > 0.0) {
        focus = 1.0 / (static_cast<double>(cell.focus) * focus_per_m_);  // 1/0: infinity
        if (nearest_m_ && cell.focus == FocusCell(*nearest_m_)) focus = *nearest_m_;
    }
    if (zoom && zoom_ > 0.0) {
        zoom = std::exp(static_cast<double>(cell.zoom) * zoom_);
        for (const double end_mm : *zooms_mm_) {
            if (cell.zoom == ZoomCell(end_mm)) zoom = end_mm;
        }
    }
    return reading;
}

}  // namespace flare
