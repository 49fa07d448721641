// SPDX-License-Identifier: Apache-2.0
//
// Where lights are: near and far, by direction and by pixel, and where their direct image lands.
// The chief ray is found here a second time, by bisection over rays of the tests' own tracer.
#include <gtest/gtest.h>

#include <cmath>

#include "core/render/lights.h"
#include "core/tracing/chief_ray.h"
#include "core/tracing/light_bundle.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/scalar_tracer.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::Real;
using testing::RelL1;
using testing::Studio;

FlareRequest SmallRequest(std::shared_ptr<const Lens> lens) {
    FlareRequest request;
    request.lens = std::move(lens);
    request.f_number = 4.0;
    request.quality = QualityPreset::kDraft;
    request.image.width = 192;
    request.image.height = 108;
    request.lights = {LightAt(5.0, 20.0)};
    return request;
}

// The chief ray of a light in the plane y = 0: `distance` 0 is infinity, else from the pupil at
// z_pupil.
double ChiefImage(const Prescription& lens, double sensor_z, double z_pupil, double field_deg,
                  double distance) {
    const auto surfaces = testing::ScalarSurfaces(lens, 587.5618L);
    const Real field = static_cast<Real>(field_deg) * 3.14159265358979323846L / 180;
    const testing::Real3 travel{std::sin(field), 0, std::cos(field)};
    const auto trace = [&](Real offset) {
        // `offset` across the beam, at the pupil.
        const testing::Real3 at{std::cos(field) * offset, 0, z_pupil - std::sin(field) * offset};
        testing::Real3 d = travel;
        if (distance > 0) {
            const testing::Real3 light =
                testing::Real3{0, 0, z_pupil} - travel * static_cast<Real>(distance);
            d = Unit(at - light);
        }
        return ScalarTrace(surfaces, sensor_z, {}, at, d, false);
    };
    Real lo = -6, hi = 6;
    EXPECT_LT(trace(lo).stops.at(0).x * trace(hi).stops.at(0).x, 0);
    const bool rising = trace(hi).stops.at(0).x > 0;
    for (int i = 0; i < 80; ++i) {
        const Real mid = (lo + hi) / 2;
        ((trace(mid).stops.at(0).x > 0) == rising ? hi : lo) = mid;
    }
    return static_cast<double>(trace((lo + hi) / 2).x_mm);
}

TEST(DirectImage, LandsWhereTheChiefRayLands) {
    const Prescription prescription = testing::SeedLens();
    const auto lens = testing::BuildLens(prescription);
    Studio studio;
    // The entrance pupil's place, from an independent program.
    constexpr double kPupil = 13.750591 / 0.689374;
    for (const auto& [field, distance_m] :
         {std::pair{15.0, 2.5}, {15.0, 0.0}, {5.0, 0.3}, {1.0, 100.0}}) {
        FlareRequest request = SmallRequest(lens);
        request.lights = {LightAt(field)};
        if (distance_m > 0.0) request.lights[0].distance_m = distance_m;
        request.image.crop = std::array<int, 4>{0, 0, 1, 1};
        const Rendering rendering = studio.Shoot(request);
        const LightFacts& facts = rendering.report.facts.lights.at(0);
        const double x =
            ChiefImage(prescription, lens->sensor_z_mm(), kPupil, field, distance_m * 1000.0);
        ASSERT_TRUE(facts.chief_ray_arrives);
        EXPECT_NEAR(facts.field_deg, field, 1e-10);
        // The picture is upright: the light is left of the axis, and so is its image.
        EXPECT_NEAR(facts.sensor_mm.x, -x, 2e-6);
        EXPECT_NEAR(facts.sensor_mm.y, 0.0, 1e-9);
        EXPECT_NEAR(facts.pixel.x, 96.0 - x / (36.0 / 192.0), 2e-5);
        EXPECT_NEAR(facts.pixel.y, 54.0, 1e-7);
        EXPECT_LT(facts.pixel.x, 96.0);
    }
}

TEST(DirectImage, IsUprightInEveryOctant) {
    const auto lens = testing::BuildLens(testing::SeedLens());
    Studio studio;
    FlareRequest request = SmallRequest(lens);
    request.image.crop = std::array<int, 4>{0, 0, 1, 1};
    for (double azimuth = 11.0; azimuth < 360.0; azimuth += 45.0) {
        const double a = RadiansFromDegrees(azimuth);
        const Vec3d towards(0.15 * std::cos(a), 0.15 * std::sin(a), 0.9);
        request.lights[0].direction = towards;
        const LightFacts facts = studio.Shoot(request).report.facts.lights.at(0);
        EXPECT_NEAR(std::remainder(std::atan2(facts.sensor_mm.y, facts.sensor_mm.x) - a, 2.0 * kPi),
                    0.0, 1e-12);
        EXPECT_EQ(facts.pixel.x > 96.0, towards.x > 0.0);
        EXPECT_EQ(facts.pixel.y<54.0, towards.y> 0.0);
        // Near the axis the image height is EFL tan(field).
        EXPECT_NEAR(facts.sensor_mm.length(), 50.3582 * 0.15 / 0.9, 0.02);
    }
}

TEST(FarLight, AtAMillionKilometresIsALightAtInfinity) {
    Studio studio;
    FlareRequest request = SmallRequest(testing::BuildLens(testing::SeedLens()));
    const FlareImage infinite = studio.Shoot(request).image;
    request.lights[0].distance_m = 1e9;
    const FlareImage far = studio.Shoot(request).image;
    const double largest =
        *std::max_element(infinite.planes[1].values.begin(), infinite.planes[1].values.end());
    for (std::size_t p = 0; p < far.planes.size(); ++p) {
        for (std::size_t i = 0; i < far.planes[p].values.size(); ++i) {
            ASSERT_NEAR(far.planes[p].values[i], infinite.planes[p].values[i], 1e-6 * largest);
        }
    }
    EXPECT_LT(RelL1(far, infinite), 1e-6);
    // And a near one is not.
    request.lights[0].distance_m = 1.0;
    EXPECT_GT(RelL1(studio.Shoot(request).image, infinite), 0.01);
}

TEST(PixelAndDirection, OfOneLightGiveTheSamePicture) {
    Studio studio;
    const auto lens = testing::BuildLens(testing::SeedLens());
    FlareRequest request = SmallRequest(lens);
    request.image.center_offset_mm = {1.0, -0.5};
    request.image.pixel_aspect = 1.25;
    const Vec2d pixel(30.25, 17.5);
    request.lights[0] = LightSpec{};
    request.lights[0].pixel = pixel;
    const FlareImage by_pixel = studio.Shoot(request).image;
    const double p = 36.0 / 192.0, q = p / 1.25;
    // At infinity d' is the focal length.
    request.lights[0].pixel.reset();
    request.lights[0].direction =
        Vec3d((pixel.x - 96.0) * p - 1.0, (54.0 - pixel.y) * q + 0.5, lens->first_order().efl_mm);
    const Rendering by_direction = studio.Shoot(request);
    EXPECT_LT(RelL1(by_pixel, by_direction.image), 1e-6);
    // The real lens has little distortion here: its chief ray lands within half a pixel.
    EXPECT_NEAR(by_direction.report.facts.lights[0].pixel.x, pixel.x, 0.5);
    EXPECT_NEAR(by_direction.report.facts.lights[0].pixel.y, pixel.y, 0.5);
}

TEST(PixelAndDirection, OfALensProjectionMeetAtTheChiefRay) {
    for (const auto& [name, projection] : {std::pair{testing::kFisheyeName, Projection::kAuto},
                                           {testing::kSeedName, Projection::kLens}}) {
        FlareRequest request = SmallRequest(testing::LibraryLens(name));
        request.image.sensor_width_mm = 30.0;
        request.image.projection = projection;
        for (const Vec2d& pixel : {Vec2d(96.0, 54.0), Vec2d(20.5, 70.0), Vec2d(130.0, 20.0)}) {
            request.lights[0] = LightSpec{};
            request.lights[0].pixel = pixel;
            const Result<PlacedLight> light = PlaceLight(request, 0);
            ASSERT_TRUE(light.ok());
            const LightBundle bundle(*request.lens, light->field_rad, light->inverse_distance);
            const std::optional<ChiefRay> chief = FindChiefRay(*request.lens, bundle, kLineD);
            ASSERT_TRUE(chief.has_value());
            const Vec2d landed =
                MapOf(request, light->pose).Pixel(chief->sensor_mm.x, chief->sensor_mm.y);
            EXPECT_NEAR(landed.x, pixel.x, 1e-6);
            EXPECT_NEAR(landed.y, pixel.y, 1e-6);
        }
    }
}

// The inverse square law and the bundle's obliquity: all rays of the bundle carry I dOmega.
TEST(NearLight, CarriesItsIntensityTimesTheSolidAngle) {
    const auto lens = testing::BuildLens(testing::SeedLens());
    const double distance = 60.0;
    const LightBundle bundle(*lens, 0.3, 1.0 / distance);
    // The solid angle of a disc of radius a seen from its axis is 2 pi (1 - cos).
    const double a = 25.0;
    double sum = 0.0;
    constexpr int kSide = 1000;
    const double step = 2.0 * a / kSide;
    for (int j = 0; j < kSide; ++j) {
        for (int i = 0; i < kSide; ++i) {
            const double u = -a + (i + 0.5) * step, v = -a + (j + 0.5) * step;
            if (u * u + v * v < a * a) sum += bundle.FluxDensity(u, v) * step * step;
        }
    }
    const double solid_angle = 2.0 * kPi * (1.0 - distance / std::hypot(distance, a));
    EXPECT_NEAR(sum, solid_angle * distance * distance, 1e-3 * sum);
}

}  // namespace
}  // namespace flare
