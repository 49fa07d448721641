// SPDX-License-Identifier: Apache-2.0
//
// A request's lights in the renderer's terms: a canonical light (field angle and distance) and the
// azimuth about the axis that turns it into place.
#pragma once

#include "core/base/result.h"
#include "core/image/ghost_walk.h"
#include "core/render/flare_request.h"

namespace flare {

struct PlacedLight {
    Vec3d direction{0.0, 0.0, 1.0};  // camera axes, unit length, towards the light
    double field_rad = 0.0;          // from the axis, 0..pi
    double azimuth_rad = 0.0;        // of the travelling light in lens space
    double inverse_distance = 0.0;   // 1/mm from the entrance pupil's centre
    Vec3d irradiance{0.0, 0.0, 0.0};
};

// The projection that `pixel` uses for this lens and request.
Projection ProjectionOf(const FlareRequest& request);

// Light number `index` of the request. Errors: the place cannot be seen, or lies inside the lens;
// `where` is "/lights/N/...".
Result<PlacedLight> PlaceLight(const FlareRequest& request, std::size_t index);

// Millimetres a pixel on the sensor, horizontally and vertically.
Vec2d PixelPitch(const ImageSpec& image);

// Sensor (canonical) to full-frame pixels for a light at this azimuth.
PictureMap MapOf(const ImageSpec& image, double azimuth_rad);

}  // namespace flare
