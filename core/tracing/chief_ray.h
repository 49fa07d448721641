// SPDX-License-Identifier: Apache-2.0
//
// The chief ray: the ray of a light that passes the centre of the stop on the direct path, traced
// exactly (not clipped by rims, which may stop it). Where it lands is where the light's image is.
#pragma once

#include <optional>

#include "core/tracing/light_bundle.h"

namespace flare {

struct ChiefRay {
    Ray ray;
    double u = 0.0, v = 0.0;    // its place in the bundle's plane; v = 0 in a plane of symmetry
    Vec2d sensor_mm{0.0, 0.0};  // lens space, of the canonical light
    double max_rim_ratio2 = 0.0;
};

// Empty if no ray of the bundle reaches the sensor through the stop's centre.
std::optional<ChiefRay> FindChiefRay(const Lens& lens, const LightBundle& bundle,
                                     double wavelength_nm);

// The field angle (radians) whose chief ray, from `inverse_distance`, lands `radius_mm` from the
// axis; empty beyond the image circle. The image side is that of interface convention: positive
// radius.
std::optional<double> FieldOfImageRadius(const Lens& lens, double radius_mm,
                                         double inverse_distance, double wavelength_nm);

// The unit vector in lens space along which a light, distant or near, must travel at the entrance
// pupil for its chief ray to land on `sensor_mm` (lens space, within 1e-9 mm). For lenses of any
// symmetry, fields below 90 degrees; empty where none is found.
std::optional<Vec3d> TravelToSensor(const Lens& lens, Vec2d sensor_mm, double inverse_distance,
                                    double wavelength_nm);

}  // namespace flare
