// SPDX-License-Identifier: Apache-2.0
#include "core/tracing/light_bundle.h"

#include <algorithm>
#include <cmath>

namespace flare {
namespace {

// Near lights shine in at up to this angle from the line to the pupil's centre.
constexpr double kMaxTangent = 20.0;

}  // namespace

LightBundle::LightBundle(const Lens& lens, double field_rad, double inverse_distance)
    : field_rad_(field_rad),
      inverse_distance_(inverse_distance),
      pupil_(0.0, 0.0, lens.first_order().entrance.z_mm) {
    const double s = std::sin(field_rad);
    const double c = std::cos(field_rad);
    travel_ = {s, 0.0, c};
    e1_ = {c, 0.0, -s};
    e2_ = {0.0, 1.0, 0.0};
    BoundFrontCap(lens);
}

Ray LightBundle::At(double u, double v) const {
    const Vec3d across = e1_ * u + e2_ * v;
    return {pupil_ + across, (travel_ + across * inverse_distance_).normalized()};
}

double LightBundle::FluxDensity(double u, double v) const {
    const double q = (u * u + v * v) * inverse_distance_ * inverse_distance_;  // tan^2
    const double r_over_d = std::sqrt(1.0 + q);
    return 1.0 / (r_over_d * r_over_d * r_over_d);
}

// The cap of surface 0 within its rim lies in a sphere about the middle of its sag; project that
// sphere on the plane, from infinity or from the light.
void LightBundle::BoundFrontCap(const Lens& lens) {
    const LensSurface& front = lens.surfaces().front();
    const double h = front.semi_diameter_mm * 1.05;
    const double radicand = std::max(0.0, 1.0 - front.curvature * front.curvature * h * h);
    const double sag = front.curvature * h * h / (1.0 + std::sqrt(radicand));
    const Vec3d centre(0.0, 0.0, 0.5 * sag);
    const double radius = std::hypot(h, 0.5 * sag);

    const Vec3d to_centre = centre - pupil_;
    const double along = to_centre.dot(travel_);
    const double across = to_centre.dot(e1_);
    if (inverse_distance_ == 0.0) {
        centre_u_ = across;
        half_width_ = radius;
        return;
    }
    // Seen from the light the sphere fills a cone; both its edges are cut by the plane at tan * D.
    const double distance = 1.0 / inverse_distance_;
    const double depth = distance + along;
    const double range = std::hypot(depth, across);
    const double limit = kMaxTangent * distance;
    if (range <= radius) {
        centre_u_ = 0.0;
        half_width_ = limit;
        return;
    }
    const double middle = std::atan2(across, depth);
    const double half_angle = std::asin(radius / range);
    constexpr double kRightAngle = 1.5;  // just short of pi / 2
    const double lo =
        std::tan(std::clamp(middle - half_angle, -kRightAngle, kRightAngle)) * distance;
    const double hi =
        std::tan(std::clamp(middle + half_angle, -kRightAngle, kRightAngle)) * distance;
    const double u0 = std::max(lo, -limit);
    const double u1 = std::min(hi, limit);
    centre_u_ = 0.5 * (u0 + u1);
    // Across the meridional plane the cone is cut at most as wide as at its far edge.
    const double v_far = std::tan(std::min(half_angle, kRightAngle)) *
                         std::hypot(distance, std::max(std::abs(u0), std::abs(u1)));
    half_width_ = std::max(0.5 * (u1 - u0), std::min(v_far, limit));
}

}  // namespace flare
