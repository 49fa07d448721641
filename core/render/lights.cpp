// SPDX-License-Identifier: Apache-2.0
#include "core/render/lights.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/units.h"
#include "core/spectrum/light_spectrum.h"
#include "core/tracing/chief_ray.h"

namespace flare {
namespace {

constexpr double kWideField_rad = RadiansFromDegrees(50.0);
constexpr double kNearestToGlass_mm = 1e-3;

std::string Place(std::size_t index, const char* field) {
    return "/lights/" + std::to_string(index) + "/" + field;
}

// Full-frame pixel to upright image coordinates on the sensor, mm from the axis, right and up.
Vec2d ImagePoint(const FlareRequest& request, const Vec2d& pixel) {
    const ImageSpec& image = request.image;
    const Vec2d pitch = PixelPitch(request);
    return {(pixel.x - 0.5 * image.width) * pitch.x - image.center_offset_mm.x,
            (0.5 * image.height - pixel.y) * pitch.y - image.center_offset_mm.y};
}

Result<Vec3d> DirectionOfPixel(const FlareRequest& request, std::size_t index,
                               double inverse_distance) {
    const Vec2d point = ImagePoint(request, *request.lights[index].pixel);
    const Lens& lens = *request.lens;
    if (ProjectionOf(request) == Projection::kRectilinear) {
        // Each section has its own distance; only the squeeze shows in the direction.
        const double x = lens.first_order(Section::kX).projection_distance_mm;
        const double y = lens.first_order(Section::kY).projection_distance_mm;
        const double squeezed = lens.rotational() ? 1.0 : y / x;
        return Vec3d(point.x * squeezed, point.y, y).normalized();
    }
    const double radius = point.length();
    if (radius == 0.0) return Vec3d(0.0, 0.0, 1.0);
    if (!lens.rotational()) {
        // The picture stands upside down on the sensor.
        const std::optional<Vec3d> travel =
            TravelToSensor(lens, {-point.x, -point.y}, inverse_distance, kLineD);
        if (travel) return Vec3d(-travel->x, -travel->y, travel->z);
        return Error{"bad_value", "no chief ray of this lens lands on that pixel",
                     Place(index, "pixel")};
    }
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
    const double z = lens.pupil_z_mm() - distance * std::cos(light.field_rad);
    const LensSurface& front = lens.surfaces().front();
    if (std::abs(radius) >= front.semi_diameter_mm) return false;
    const Vec2d at = light.pose.LensSpace(
        {-radius * std::cos(light.pose.azimuth_rad), -radius * std::sin(light.pose.azimuth_rad)});
    return z > front.shape.Sag(at.x, at.y) - kNearestToGlass_mm;
}

// A light so faint that no float can hold what it adds anywhere is none: shares of it would be
// denormal, and their ratios no numbers.
constexpr double kFaintest = 1e-200;

// In linear Rec.709, and its spectrum where that is no plain mix of primaries.
void SetColor(const FlareRequest& request, const LightSpec& spec, PlacedLight& light) {
    light.irradiance = Vec3d(0.0, 0.0, 0.0);
    if (std::max({spec.irradiance.x, spec.irradiance.y, spec.irradiance.z}) < kFaintest) return;
    light.irradiance = spec.irradiance;
    if (request.color == ColorMode::kSpectral) return;
    const ColorSpace space = SpaceOf(request.color);
    const Vec3d& e = spec.irradiance;
    const bool based = spec.temperature_k || spec.spectrum != nullptr;
    if (!based) {
        light.irradiance = Rec709FromSpace(space, e);
        const Vec3d& rgb = light.irradiance;
        // Rounding on the way from one space to the other makes nothing saturated.
        const double least = -1e-12 * std::max({rgb.x, rgb.y, rgb.z});
        if (rgb.x >= least && rgb.y >= least && rgb.z >= least) return;
        light.power =
            std::make_shared<const Spectrum>(SpectrumOfColor(WhiteSpectrum(), light.irradiance));
        return;
    }
    Spectrum base = spec.spectrum ? *spec.spectrum : BlackbodySpectrum(*spec.temperature_k);
    const Vec3d own = ColorOf(ResponseOf(space), base);
    light.irradiance = Rec709FromSpace(space, {own.x * e.x, own.y * e.y, own.z * e.z});
    if (e.x == e.y && e.y == e.z) {
        for (double& value : base) value *= e.x;
        light.power = std::make_shared<const Spectrum>(base);
        return;
    }
    light.power = std::make_shared<const Spectrum>(SpectrumOfColor(base, light.irradiance));
}

// Angles that name meshes, without the last digits that a turn of the picture changes: 1e-12 rad is
// nothing on any sensor.
double Settled(double angle_rad) {
    constexpr double kGrain = 1e12;
    if (angle_rad == 0.5 * kPi) return angle_rad;  // the y-z plane, exactly
    return std::round(angle_rad * kGrain) / kGrain;
}

}  // namespace

Vec2d PixelPitch(const FlareRequest& request) {
    const ImageSpec& image = request.image;
    const double pitch = image.sensor_width_mm / image.width;
    const double squeeze = image.desqueeze ? request.lens->squeeze() : 1.0;
    return {pitch, pitch / image.pixel_aspect * squeeze};
}

double ShownPixelAspect(const FlareRequest& request) {
    return request.image.pixel_aspect * (request.image.desqueeze ? 1.0 : request.lens->squeeze());
}

LightBundle BundleOf(const Lens& lens, const PlacedLight& light) {
    return {lens, light.field_rad, light.inverse_distance, light.pose.azimuth_rad};
}

MeshSpec MeshSpecOf(const BounceSequence& sequence, const PlacedLight& light) {
    MeshSpec spec;
    spec.sequence = sequence;
    spec.field_rad = light.field_rad;
    spec.azimuth_rad = light.pose.azimuth_rad;
    spec.inverse_distance = light.inverse_distance;
    return spec;
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

PlacedLight FacedTo(const Lens& lens, PlacedLight light, const Vec3d& direction) {
    const Vec3d d = direction;
    light.direction = d;
    const double across = std::hypot(d.x, d.y);
    light.field_rad = Settled(std::atan2(across, d.z));
    light.pose = PoseOf(lens, across > 0.0 ? std::atan2(-d.y, -d.x) : 0.0);
    light.pose.azimuth_rad = Settled(light.pose.azimuth_rad);
    return light;
}

Result<PlacedLight> PlaceLight(const FlareRequest& request, std::size_t index) {
    const LightSpec& spec = request.lights[index];
    PlacedLight light;
    SetColor(request, spec, light);
    light.angular_diameter_rad = RadiansFromDegrees(spec.angular_diameter_deg);
    light.shape = spec.shape;
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
    light = FacedTo(*request.lens, light, light.direction);
    if (spec.distance_m && InsideLens(*request.lens, light)) {
        return Error{"bad_value", "the light is inside the lens or touches its front surface",
                     Place(index, "distance_m")};
    }
    return light;
}

Spectrum PowerOf(const PlacedLight& light, double weight) {
    if (!light.power) return LightSpectrum(light.irradiance * weight);
    Spectrum power = *light.power;
    for (double& value : power) value *= weight * light.share;
    return power;
}

PictureMap MapOf(const FlareRequest& request, const CanonicalPose& pose) {
    const ImageSpec& image = request.image;
    const Vec2d pitch = PixelPitch(request);
    PictureMap map;
    map.stop_per_x = pose.x_axis;
    map.stop_per_y = pose.y_axis;
    // Lens space on the sensor is the picture upside down: right is -x, down is +y.
    map.px_per_x = {-pose.x_axis.x / pitch.x, pose.x_axis.y / pitch.y};
    map.px_per_y = {-pose.y_axis.x / pitch.x, pose.y_axis.y / pitch.y};
    map.offset_px = {0.5 * image.width + image.center_offset_mm.x / pitch.x,
                     0.5 * image.height - image.center_offset_mm.y / pitch.y};
    return map;
}

}  // namespace flare
