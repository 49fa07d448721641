// SPDX-License-Identifier: Apache-2.0
//
// The body of POST /v1/warm as plain values: whose ghost meshes to have ready, for which lights.
#pragma once

#include <optional>
#include <vector>

#include "protocol/wire/flare_request.h"
#include "protocol/wire/lens_choice.h"

namespace flare::wire {

// Distant lights at the angles from, from + step, ... up to `to`.
struct FieldAngles {
    double from_deg = 0.0, to_deg = 0.0, step_deg = 0.0;
    int count = 0;  // at least 1, at most limits::kWarmLights
};

// Exactly one of lights and field is there; lights placed by pixel come with an image.
struct WarmRequest {
    LensChoice lens;
    Quality quality;  // a preset or a tolerance
    Model model;
    std::optional<Image> image;
    std::vector<Light> lights;
    std::optional<FieldAngles> field;
    double azimuth_deg = 0.0;  // of the field angles
};

}  // namespace flare::wire
