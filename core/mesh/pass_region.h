// SPDX-License-Identifier: Apache-2.0
//
// Where in a light's bundle the rays of one ghost pass: the rectangle of the (u, v) plane that
// holds every ray within all rims and the stop's own rim. Each ghost has its own, often small,
// region.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/tracing/light_bundle.h"

namespace flare {

struct Rect {
    double u0 = 0.0, u1 = 0.0, v0 = 0.0, v1 = 0.0;

    friend bool operator==(const Rect&, const Rect&) = default;
};

struct PassRegion {
    // Empty: no ray passes. Symmetric in v if the bundle is.
    std::optional<Rect> rect;
    std::uint64_t rays = 0;  // traced to find it
    std::uint64_t ray_surfaces = 0;
};

// Searched at the middle one of `lists` (one bounce sequence written out for several wavelengths)
// and widened for the others. A region narrower than about 1/2000 of the front element may be
// missed; such a ghost carries less than 1e-6 of the light on the front.
PassRegion FindPassRegion(const std::vector<InteractionList>& lists, const LightBundle& bundle);

}  // namespace flare
