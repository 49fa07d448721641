// SPDX-License-Identifier: Apache-2.0
#include "core/render/lights.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/units.h"
#include "core/tracing/chief_ray.h"

namespace flare {
namespace {

constexpr double kWideField_rad = RadiansFromDegrees(50.0);
constexpr double kNearestToGlass_mm = 1e-3;

std::string Place(std::size_t index, const char* field) {
    return "/lights/" + std::to_string(index) + "/" + field;
}

// Full-frame pixel to upright image coordinates on the sensor, mm from the axis, right and up.
Vec2d ImagePoint(const ImageSpec& image, const Vec2d& pixel) {
    const Vec2d pitch = PixelPitch(image);
    return {(pixel.x - 0.5 * image.width) * pitch.x - image.center_offset_mm.x,
            (0.5 * image.height - pixel.y) * pitch.y - image.center_offset_mm.y};
}

Result<Vec3d> DirectionOfPixel(const FlareRequest& request, std::size_t index,
                               double inverse_distance) {
    const Vec2d point = ImagePoint(request.image, *request.lights[index].pixel);
    const FirstOrder& first_order = request.lens->first_order();
    if (ProjectionOf(request) == Projection::kRectilinear) {
        return Vec3d(point.x, point.y, first_order.projection_distance_mm).normalized();
    }
    const double radius = point.length();
    if (radius == 0.0) return Vec3d(0.0, 0.0, 1.0);
    const std::optional<double> field =
        FieldOfImageRadius(*request.lens, radius, inverse_distance, kLineD);
    if (!field) {
        return Error{"bad_value", "no chief ray of this lens lands on that pixel",
                     Place(index, "pixel")};
    }
    const double s = std::sin(*field) / radius;
    return Vec3d(point.x * s, point.y * s, std::cos(*field));
}

// Is a light at this place inside the glass, or all but touching it?
bool InsideLens(const Lens& lens, const PlacedLight& light) {
    const double distance = 1.0 / light.inverse_distance;
    const double radius = distance * std::sin(light.field_rad);
    const double z = lens.first_order().entrance.z_mm - distance * std::cos(light.field_rad);
    const LensSurface& front = lens.surfaces().front();
    if (std::abs(radius) >= front.semi_diameter_mm) return false;
    const double c = front.curvature;
    const double sag = c * radius * radius / (1.0 + std::sqrt(1.0 - c * c * radius * radius));
    return z > sag - kNearestToGlass_mm;
}

}  // namespace

Vec2d PixelPitch(const ImageSpec& image) {
    const double pitch = image.sensor_width_mm / image.width;
    return {pitch, pitch / image.pixel_aspect};
}

Projection ProjectionOf(const FlareRequest& request) {
    if (request.image.projection != Projection::kAuto) return request.image.projection;
    const Prescription& prescription = request.lens->prescription();
    if (prescription.fisheye) return Projection::kLens;
    if (prescription.design_image_circle_mm) {
        const std::optional<double> field = FieldOfImageRadius(
            *request.lens, 0.5 * *prescription.design_image_circle_mm, 0.0, kLineD);
        if (field && *field > kWideField_rad) return Projection::kLens;
    }
    return Projection::kRectilinear;
}

Result<PlacedLight> PlaceLight(const FlareRequest& request, std::size_t index) {
    const LightSpec& spec = request.lights[index];
    PlacedLight light;
    light.irradiance = spec.irradiance;
    if (spec.distance_m) light.inverse_distance = 1.0 / (*spec.distance_m * kMmPerMetre);
    if (spec.direction) {
        // Scale first: the squares of tiny or huge components would under- or overflow.
        const Vec3d d = *spec.direction;
        light.direction =
            (d / std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)})).normalized();
    } else {
        Result<Vec3d> direction = DirectionOfPixel(request, index, light.inverse_distance);
        if (!direction) return direction.error();
        light.direction = *direction;
    }
    const Vec3d& d = light.direction;
    const double across = std::hypot(d.x, d.y);
    light.field_rad = std::atan2(across, d.z);
    light.azimuth_rad = across > 0.0 ? std::atan2(-d.y, -d.x) : 0.0;
    if (spec.distance_m && InsideLens(*request.lens, light)) {
        return Error{"bad_value", "the light is inside the lens or touches its front surface",
                     Place(index, "distance_m")};
    }
    return light;
}

PictureMap MapOf(const ImageSpec& image, double azimuth_rad) {
    const Vec2d pitch = PixelPitch(image);
    PictureMap map;
    map.cos_azimuth = std::cos(azimuth_rad);
    map.sin_azimuth = std::sin(azimuth_rad);
    // Lens space on the sensor is the picture upside down: right is -x, down is +y.
    map.px_per_x = {-map.cos_azimuth / pitch.x, map.sin_azimuth / pitch.y};
    map.px_per_y = {map.sin_azimuth / pitch.x, map.cos_azimuth / pitch.y};
    map.offset_px = {0.5 * image.width + image.center_offset_mm.x / pitch.x,
                     0.5 * image.height - image.center_offset_mm.y / pitch.y};
    return map;
}

}  // namespace flare
