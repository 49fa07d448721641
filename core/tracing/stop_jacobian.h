// SPDX-License-Identifier: Apache-2.0
//
// How a ghost maps its surroundings at one passage through the stop, from exact rays: where one ray
// of a bundle meets the stop, how the place on the sensor changes with the place in the stop for
// this light (m) and with the direction at the stop at a fixed place there (B).
//
// To a wave they say how far it has run: along a direction n across an edge the ghost is the
// Fresnel pattern of the stop after z_n = n . m^-1 B n (the inverse second derivative of the
// optical path over the stop, its other direction at rest), magnified by m. In first order that is
// z_eff = B2 A1 / A (ghost_ringing.h); with aberration it differs from place to place.
//
// All in canonical lens space (LightBundle); mm, directions as optical direction cosines.
#pragma once

#include <optional>

#include "core/tracing/light_bundle.h"

namespace flare {

// Columns: what a step along x and along y gives.
struct Matrix2 {
    Vec2d x{0.0, 0.0}, y{0.0, 0.0};

    Vec2d operator*(Vec2d v) const { return x * v.x + y * v.y; }
    double determinant() const { return x.cross(y); }
    // Of a matrix that has one.
    Matrix2 Inverse() const;
};

struct StopJacobian {
    Vec2d stop_mm{0.0, 0.0};
    Vec2d sensor_mm{0.0, 0.0};
    Matrix2 sensor_per_stop;   // m
    Matrix2 sensor_per_angle;  // B, mm

    // z_n of a unit vector; nothing where m has no inverse (a fold).
    std::optional<double> Distance(Vec2d n) const;
};

// One ghost's passage number `crossing` through the stop.
class StopPassage {
  public:
    StopPassage(const InteractionList& list, std::size_t crossing);

    // At the ray (u, v) of the bundle. Nothing if it crosses the stop more than `most_mm` from the
    // axis, or if it or one of the six rays around it, or their
    // continuations, do not arrive; rims and iris do not stop them.
    std::optional<StopJacobian> At(const LightBundle& bundle, double u, double v,
                                   double most_mm = 1e300) const;

    // A ray through the stop's plane: place and optical direction cosines there, and from there to
    // the sensor.
    struct State {
        Vec2d stop_mm{0.0, 0.0}, angle{0.0, 0.0}, sensor_mm{0.0, 0.0};
        double path_to_stop_mm = 0.0;  // optical length from the bundle's plane
        double path_mm = 0.0;          // and from the stop on to the sensor
    };
    std::optional<State> Trace(const Ray& ray) const;
    // From a place in the stop's plane in a direction, as State has them.
    std::optional<State> FromStop(Vec2d stop_mm, Vec2d angle) const;

  private:
    InteractionList list_;  // the whole ghost
    InteractionList rest_;  // behind the passage
    std::size_t step_ = 0;  // of the stop in list_
    double index_ = 1.0;    // behind it
    bool forward_ = true;
};

}  // namespace flare
