// SPDX-License-Identifier: Apache-2.0
#include "core/render/photon_source.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/render/source_picture.h"

namespace flare {
namespace {

// Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square": strata stay compact.
Vec2d UnitDisc(Vec2d square) {
    const double a = 2.0 * square.x - 1.0, b = 2.0 * square.y - 1.0;
    if (a == 0.0 && b == 0.0) return {0.0, 0.0};
    const bool wide = std::abs(a) > std::abs(b);
    const double radius = wide ? a : b;
    const double angle = wide ? 0.25 * kPi * (b / a) : 0.5 * kPi - 0.25 * kPi * (a / b);
    return Vec2d(std::cos(angle), std::sin(angle)) * radius;
}

}  // namespace

PhotonSource::PhotonSource(const Lens& lens, const PlacedLight& light)
    : front_(lens.surfaces().front()),
      travel_(-light.direction.x, -light.direction.y, light.direction.z),
      pupil_(0.0, 0.0, lens.pupil_z_mm()),
      distance_mm_(light.inverse_distance > 0.0 ? 1.0 / light.inverse_distance : 0.0),
      tan_radius_(std::tan(0.5 * light.angular_diameter_rad)),
      shape_(light.shape) {
    const Vec3d helper = std::abs(travel_.z) < 0.9 ? Vec3d(0.0, 0.0, 1.0) : Vec3d(1.0, 0.0, 0.0);
    across_ = travel_.cross(helper).normalized();
    up_ = travel_.cross(across_);
    if (!shape_) return;
    const UprightAxes axes = UprightAt(light.direction);
    shape_right_ = Vec3d(-axes.right.x, -axes.right.y, axes.right.z);
    shape_up_ = Vec3d(-axes.up.x, -axes.up.y, axes.up.z);
}

Vec3d PhotonSource::LeanOf(Vec2d lamp, double& brightness) const {
    brightness = 1.0;
    if (!shape_) {
        const Vec2d off = UnitDisc(lamp) * tan_radius_;
        return across_ * -off.x - up_ * off.y;
    }
    const int side = shape_->side();
    const auto cell = [&](double a) { return std::min(static_cast<int>(a * side), side - 1); };
    brightness = shape_->At(cell(lamp.x), cell(lamp.y)) * side * side;
    const Vec2d off = (lamp * 2.0 - Vec2d(1.0, 1.0)) * tan_radius_;
    return shape_right_ * off.x + shape_up_ * off.y;
}

double PhotonSource::area_mm2() const {
    return kPi * front_.semi_diameter_mm * front_.semi_diameter_mm;
}

std::optional<PhotonRay> PhotonSource::At(Vec2d front, Vec2d lamp) const {
    const Vec2d at = UnitDisc(front) * front_.semi_diameter_mm;
    const Vec3d place(at.x, at.y, front_.shape.Sag(at.x, at.y));
    double density = 1.0;
    Vec3d towards = travel_ + LeanOf(lamp, density);
    if (!(density > 0.0)) return std::nullopt;
    if (distance_mm_ > 0.0) {
        // From a point of the lamp, a disc across the line to the pupil's centre; inverse square.
        const Vec3d run = place - (pupil_ - towards * distance_mm_);
        density *= distance_mm_ * distance_mm_ / run.dot(run);
        towards = run;
    }
    towards.normalize();
    // Area of the surface over that of the disc, times the cosine of incidence.
    const Vec2d slope = front_.shape.Slope(at.x, at.y);
    density *= towards.z - towards.x * slope.x - towards.y * slope.y;
    if (!(density > 0.0)) return std::nullopt;
    return PhotonRay{{place - towards * kPhotonRun_mm, towards}, density};
}

}  // namespace flare
