// SPDX-License-Identifier: Apache-2.0
//
// Lights where nobody puts them: beside and behind the camera, against the glass, inside it, at the
// end of the world.
#include <gtest/gtest.h>

#include <cmath>

#include "core/render/lights.h"
#include "core/tracing/chief_ray.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::Studio;

FlareRequest SeedRequest() {
    FlareRequest request =
        testing::SpectralRequest(testing::BuildLens(testing::SeedLens()), 4.0, 64, 36);
    request.lights = {LightAt(5.0)};
    return request;
}

// Sum of the picture, after looking at every pixel.
double SoundSum(const Rendering& rendering) {
    for (const ImagePlane& plane : rendering.image.planes) {
        for (const float value : plane.values) {
            EXPECT_TRUE(std::isfinite(value));
            EXPECT_GE(value, 0.0F);
        }
    }
    return testing::Sum(rendering.image.planes[0]);
}

// "Quick" is counted in rays, not seconds: a light in the field needs some 1e5.
TEST(ALightBesideOrBehindTheCamera, GivesBlackOrNextToNothing) {
    Studio studio;
    FlareRequest request = SeedRequest();
    const double in_field = SoundSum(studio.Shoot(request));
    ASSERT_GT(in_field, 0.0);
    for (const double field : {60.0, 89.9, 90.0, 120.0, 180.0}) {
        request.lights = {LightAt(field, 30.0)};
        const Rendering rendering = studio.Shoot(request);
        EXPECT_LT(SoundSum(rendering), (field < 89.0 ? 0.2 : 1e-4) * in_field) << field;
        EXPECT_LT(rendering.report.work.rays_traced, 20'000'000U) << field;
        EXPECT_NEAR(rendering.report.facts.lights.at(0).field_deg, field, 1e-6);
        if (field > 100.0) {
            EXPECT_EQ(SoundSum(rendering), 0.0);
        }
    }
}

TEST(ALightExactlyBehind, HasNoPreferredAzimuth) {
    Studio studio;
    FlareRequest request = SeedRequest();
    request.lights = {LightSpec{}};
    for (const Vec3d& d : {Vec3d(0.0, 0.0, -1.0), Vec3d(-0.0, 0.0, -1.0), Vec3d(1e-300, 0.0, -1.0),
                           Vec3d(0.0, -1e-300, 1.0), Vec3d(1e300, 1e300, -1e300)}) {
        request.lights[0].direction = d;
        SoundSum(studio.Shoot(request));
    }
}

// A 220-degree fisheye sees light from behind.
TEST(LightFromBehindTheCamera, ReachesTheSensorOfA220DegreeFisheye) {
    const auto lens = testing::LibraryLens(testing::kFisheyeName);
    double last = 0.0;
    for (const double field :
         {10.0, 50.0, 80.0, 89.9, 90.0, 90.1, 92.0, 95.0, 100.0, 105.0, 109.0}) {
        const auto chief =
            FindChiefRay(*lens, LightBundle(*lens, RadiansFromDegrees(field), 0.0), kLineD);
        ASSERT_TRUE(chief.has_value()) << field;
        const double radius = std::abs(chief->sensor_mm.x);
        EXPECT_GT(radius, last) << field;
        if (field >= 92.0) {
            // 9.8 to 11.5 mm, to the tenth; f theta would give 10.1 to 12.0.
            EXPECT_GE(radius, 9.75) << field;
            EXPECT_LT(radius, 11.55) << field;
        }
        // Equidistant by design: 6 to 6.4 mm a radian.
        EXPECT_NEAR(radius / RadiansFromDegrees(field), 6.2, 0.4) << field;
        // The clipped trace of that ray arrives too: it is light, not geometry.
        EXPECT_EQ(TraceRay(WriteOut(*lens, {}, kLineD), chief->ray, {}, nullptr).fate,
                  RayFate::kArrived)
            << field;
        last = radius;
    }
    EXPECT_FALSE(FindChiefRay(*lens, LightBundle(*lens, RadiansFromDegrees(179.0), 0.0), kLineD)
                     .has_value());
}

TEST(LightFromBehindTheCamera, FlaresInA220DegreeFisheye) {
    const auto lens = testing::LibraryLens(testing::kFisheyeName);
    Studio studio;
    FlareRequest request = testing::SpectralRequest(lens, 2.8, 64, 64);
    request.image.sensor_width_mm = 24.0;
    request.quality = QualityPreset::kDraft;
    request.lights = {LightAt(97.0, 40.0)};
    const Rendering rendering = studio.Shoot(request);
    EXPECT_GT(SoundSum(rendering), 0.0);
    const LightFacts& facts = rendering.report.facts.lights.at(0);
    EXPECT_TRUE(facts.chief_ray_arrives);
    EXPECT_NEAR(facts.sensor_mm.length(), 10.3, 0.6);
    EXPECT_LT(facts.sensor_mm.x, 0.0);  // upright: the light is left and below
    EXPECT_LT(facts.sensor_mm.y, 0.0);
}

TEST(TheAzimuthsWrap, LeavesNoMark) {
    Studio studio;
    FlareRequest request = SeedRequest();
    request.lights = {LightAt(8.0, 180.0)};
    const FlareImage at = studio.Shoot(request).image;
    for (const double azimuth : {180.0 - 1e-9, 180.0 + 1e-9, -180.0, 540.0}) {
        request.lights = {LightAt(8.0, azimuth)};
        EXPECT_LT(testing::RelL1(studio.Shoot(request).image, at), 1e-5) << azimuth;
    }
    // -0 and +0 differ in sign to atan2, not to a light.
    request.lights[0].direction = Vec3d(0.1, 0.0, 1.0);
    const FlareImage plus = studio.Shoot(request).image;
    request.lights[0].direction = Vec3d(0.1, -0.0, 1.0);
    EXPECT_LT(testing::RelL1(studio.Shoot(request).image, plus), 1e-5);
}

// The front vertex lies 19.9465 mm before the entrance pupil's centre, where distances
// start.
TEST(ALightCloseToTheFrontGlass, IsRendered) {
    Studio studio;
    FlareRequest request = SeedRequest();
    const double to_vertex = request.lens->first_order().entrance.z_mm;
    for (const double before_mm : {5.0, 1.0, 0.1}) {
        request.lights = {LightAt(0.0)};
        request.lights[0].distance_m = (to_vertex + before_mm) / 1000.0;
        EXPECT_GT(SoundSum(studio.Shoot(request)), 0.0) << before_mm;
        // Off the axis the front curves back: at 4 mm it lies 0.3 mm behind its vertex.
        request.lights = {LightAt(before_mm < 1.0 ? 2.0 : 12.0, 77.0)};
        request.lights[0].distance_m = (to_vertex + before_mm) / 1000.0;
        EXPECT_GE(SoundSum(studio.Shoot(request)), 0.0) << before_mm;
    }
}

TEST(ALightOnOrInsideTheGlass, IsATypedError) {
    Studio studio;
    FlareRequest request = SeedRequest();
    const double to_vertex = request.lens->first_order().entrance.z_mm;
    for (const double distance_mm :
         {to_vertex, to_vertex + 1e-6, to_vertex - 1.0, 5.0, 1.0, 1e-9}) {
        request.lights = {LightAt(0.0)};
        request.lights[0].distance_m = distance_mm / 1000.0;
        const Result<Rendering> rendering = Render(request, studio.Context());
        ASSERT_FALSE(rendering.ok()) << distance_mm;
        EXPECT_EQ(rendering.error().where, "/lights/0/distance_m");
        EXPECT_EQ(rendering.error().code, "bad_value");
    }
    // The second of two lights is named as such.
    request.lights.insert(request.lights.begin(), LightAt(5.0));
    EXPECT_EQ(Render(request, studio.Context()).error().where, "/lights/1/distance_m");
}

TEST(ALightAtTheEndOfTheWorld, IsALightAtInfinity) {
    Studio studio;
    FlareRequest request = SeedRequest();
    const FlareImage infinite = studio.Shoot(request).image;
    for (const double distance_m : {1e9, 1e15, 1e300}) {
        request.lights[0].distance_m = distance_m;
        EXPECT_LT(testing::RelL1(studio.Shoot(request).image, infinite), 1e-6) << distance_m;
    }
}

// The focused ghost (9,1) puts its light into few pixels.
TEST(AFocusedGhost, StaysFiniteAtAnyFNumber) {
    Studio studio;
    FlareRequest request = SeedRequest();
    request.image.width = 4096;
    request.image.height = 2304;
    request.image.crop = std::array<int, 4>{0, 1100, 4096, 104};
    for (const double f_number : {22.0, 128.0}) {
        request.f_number = f_number;
        const Rendering rendering = studio.Shoot(request);
        EXPECT_GT(SoundSum(rendering), 0.0) << f_number;
        for (const GhostFacts& ghost : rendering.report.facts.ghosts) {
            EXPECT_TRUE(std::isfinite(ghost.flux_mm2));
            EXPECT_GE(ghost.flux_mm2, 0.0);
        }
    }
}

}  // namespace
}  // namespace flare
