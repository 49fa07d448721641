// SPDX-License-Identifier: Apache-2.0
#include "core/tracing/light_bundle.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/units.h"

namespace flare {
namespace {

// Near lights shine in at up to this angle from the line to the pupil's centre.
constexpr double kMaxTangent = 20.0;

}  // namespace

CanonicalPose PoseOf(const Lens& lens, double azimuth_rad) {
    CanonicalPose pose;
    const double c = std::cos(azimuth_rad);
    const double s = std::sin(azimuth_rad);
    if (lens.rotational()) {
        pose.x_axis = {c, s};
        pose.y_axis = {-s, c};
        return pose;
    }
    pose.x_axis.x = c < 0.0 ? -1.0 : 1.0;
    pose.y_axis.y = s < 0.0 ? -1.0 : 1.0;
    pose.azimuth_rad = std::atan2(std::abs(s), std::abs(c));
    // A light in the y-z plane, whatever its angle's last digit.
    constexpr double kOnAxis = 1e-12;
    if (pose.azimuth_rad < kOnAxis) pose.azimuth_rad = 0.0;
    if (pose.azimuth_rad > 0.5 * kPi - kOnAxis) pose.azimuth_rad = 0.5 * kPi;
    return pose;
}

LightBundle::LightBundle(const Lens& lens, double field_rad, double inverse_distance,
                         double azimuth_rad)
    : field_rad_(field_rad),
      inverse_distance_(inverse_distance),
      pupil_(0.0, 0.0, lens.pupil_z_mm()) {
    const double s = std::sin(field_rad);
    const double c = std::cos(field_rad);
    const bool in_y = azimuth_rad == 0.5 * kPi;
    cos_azimuth_ = in_y ? 0.0 : std::cos(azimuth_rad);
    sin_azimuth_ = in_y ? 1.0 : std::sin(azimuth_rad);
    mirror_symmetric_ = lens.rotational() || in_y || azimuth_rad == 0.0;
    travel_ = {s * cos_azimuth_, s * sin_azimuth_, c};
    e1_ = {c * cos_azimuth_, c * sin_azimuth_, -s};
    e2_ = {-sin_azimuth_, cos_azimuth_, 0.0};
    to_front_ = -pupil_.dot(travel_);
    BoundFrontCap(lens);
}

Ray LightBundle::At(double u, double v) const {
    const Vec3d across = e1_ * u + e2_ * v;
    return {pupil_ + across, (travel_ + across * inverse_distance_).normalized()};
}

Ray LightBundle::AtFront(double u, double v) const {
    const Ray ray = At(u, v);
    return {ray.origin + ray.direction * to_front_, ray.direction};
}

Vec3d LightBundle::TurnedTravel(Vec2d turn_rad) const {
    const double angle = turn_rad.length();
    if (angle == 0.0) return travel_;
    const Vec3d towards = (e1_ * turn_rad.x + e2_ * turn_rad.y) / angle;
    return travel_ * std::cos(angle) + towards * std::sin(angle);
}

Vec2d LightBundle::TurnTo(const Vec3d& travel) const {
    const Vec2d across(travel.dot(e1_), travel.dot(e2_));
    const double sine = across.length();
    if (sine == 0.0) return across;
    return across * (std::atan2(sine, travel.dot(travel_)) / sine);
}

Ray LightBundle::TurnedAtFront(double u, double v, Vec2d turn_rad) const {
    const Vec3d across = e1_ * u + e2_ * v;
    const Vec3d direction = (TurnedTravel(turn_rad) + across * inverse_distance_).normalized();
    return {pupil_ + across + direction * to_front_, direction};
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
    const std::array<double, 2> sag = front.shape.SagRange(h);
    const Vec3d centre(0.0, 0.0, 0.5 * (sag[0] + sag[1]));
    const double radius = std::hypot(h, 0.5 * (sag[1] - sag[0]));

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
