// SPDX-License-Identifier: Apache-2.0
#include "core/tracing/light_bundle.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"
#include "core/tracing/chief_ray.h"
#include "tests/support/lenses.h"
#include "tests/support/random.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::BuildLens;

TEST(LightBundle, FromInfinityIsParallelAndCrossesThePlaneAcross) {
    const auto lens = BuildLens(testing::SeedLens());
    const double field = 0.3;
    const LightBundle bundle(*lens, field, 0.0);
    const Vec3d travel(std::sin(field), 0.0, std::cos(field));
    const Vec3d pupil(0.0, 0.0, lens->pupil_z_mm());
    for (const Vec2d& at : {Vec2d(0.0, 0.0), Vec2d(3.0, 0.0), Vec2d(-2.0, 5.0)}) {
        const Ray ray = bundle.At(at.x, at.y);
        EXPECT_NEAR((ray.direction - travel).length(), 0.0, 1e-15);
        EXPECT_NEAR((ray.origin - pupil).dot(travel), 0.0, 1e-13);
        EXPECT_NEAR((ray.origin - pupil).length(), at.length(), 1e-13);
        EXPECT_EQ(bundle.FluxDensity(at.x, at.y), 1.0);
    }
    EXPECT_GT(bundle.At(1.0, 0.0).origin.x, 0.0);
    EXPECT_EQ(bundle.At(0.0, 1.0).origin.y, 1.0);
}

TEST(LightBundle, FromAPointComesFromThatPoint) {
    const auto lens = BuildLens(testing::SeedLens());
    const double field = 0.2, distance = 300.0;
    const LightBundle bundle(*lens, field, 1.0 / distance);
    const Vec3d light = Vec3d(0.0, 0.0, lens->first_order().entrance.z_mm) -
                        Vec3d(std::sin(field), 0.0, std::cos(field)) * distance;
    for (const Vec2d& at : {Vec2d(0.0, 0.0), Vec2d(30.0, -10.0), Vec2d(-200.0, 5.0)}) {
        const Ray ray = bundle.At(at.x, at.y);
        EXPECT_NEAR(ray.direction.length(), 1.0, 1e-14);
        const Vec3d to_light = light - ray.origin;
        EXPECT_NEAR(to_light.cross(ray.direction).length(), 0.0, 1e-10);
        EXPECT_LT(to_light.dot(ray.direction), 0.0);
        // Inverse square of the distance, and the cosine to the plane.
        const double r = to_light.length();
        EXPECT_NEAR(bundle.FluxDensity(at.x, at.y), std::pow(distance / r, 3), 1e-12);
    }
}

// No ray that meets the front inside its rim is left out of the square.
TEST(LightBundle, HoldsEveryRayThatMeetsTheFront) {
    testing::Random random(2);
    for (const char* name : testing::kLibraryNames) {
        const auto lens = testing::LibraryLens(name);
        const LensSurface& front = lens->surfaces().front();
        for (const double field_deg : {0.0, 20.0, 75.0, 100.0}) {
            for (const double distance : {0.0, 2000.0, 150.0}) {
                const double field = RadiansFromDegrees(field_deg);
                const LightBundle bundle(*lens, field, distance > 0.0 ? 1.0 / distance : 0.0);
                const Vec3d travel(std::sin(field), 0.0, std::cos(field));
                const Vec3d pupil(0.0, 0.0, lens->pupil_z_mm());
                for (int k = 0; k < 200; ++k) {
                    const double r = front.semi_diameter_mm * std::sqrt(random.Uniform(0.0, 1.0));
                    const double a = random.Uniform(0.0, 2.0 * kPi);
                    const double z = front.shape.Sag(r * std::cos(a), r * std::sin(a));
                    const Vec3d p(r * std::cos(a), r * std::sin(a), z);
                    Vec3d at(0.0, 0.0, 0.0);
                    if (distance > 0.0) {
                        const Vec3d light = pupil - travel * distance;
                        const Vec3d d = p - light;
                        const double depth = d.dot(travel);
                        if (depth < 0.06 * d.length()) continue;  // more than 87 degrees off
                        at = light + d * (distance / depth);
                    } else {
                        at = p - travel * (p - pupil).dot(travel);
                    }
                    const Vec3d e1(std::cos(field), 0.0, -std::sin(field));
                    EXPECT_LE(std::abs((at - pupil).dot(e1) - bundle.centre_u()),
                              bundle.half_width() * (1.0 + 1e-9))
                        << name << " " << field_deg << " " << distance;
                    EXPECT_LE(std::abs(at.y), bundle.half_width() * (1.0 + 1e-9))
                        << name << " " << field_deg << " " << distance;
                }
            }
        }
    }
}

TEST(ChiefRay, OnTheAxisIsTheAxis) {
    const auto lens = BuildLens(testing::SeedLens());
    const auto chief = FindChiefRay(*lens, LightBundle(*lens, 0.0, 0.0), kLineD);
    ASSERT_TRUE(chief.has_value());
    EXPECT_NEAR(chief->u, 0.0, 1e-12);
    EXPECT_NEAR(chief->sensor_mm.length(), 0.0, 1e-12);
}

TEST(ChiefRay, PassesTheStopsCentre) {
    for (const char* name : testing::kLibraryNames) {
        const auto lens = testing::LibraryLens(name);
        const LightBundle bundle(*lens, RadiansFromDegrees(2.0), 1.0 / 4000.0);
        const auto chief = FindChiefRay(*lens, bundle, kLineD);
        ASSERT_TRUE(chief.has_value()) << name;
        RayRecord record;
        TraceRay(WriteOut(*lens, {}, kLineD), chief->ray, {}, &record);
        ASSERT_EQ(record.stop_mm.size(), 1U);
        EXPECT_NEAR(record.stop_mm[0].length(), 0.0, 1e-10) << name;
    }
}

TEST(FieldOfImageRadius, UndoesTheChiefRay) {
    const auto lens = BuildLens(testing::SeedLens());
    for (const double radius : {0.01, 4.4, 12.0, 18.0}) {
        const auto field = FieldOfImageRadius(*lens, radius, 0.0, kLineD);
        ASSERT_TRUE(field.has_value());
        const auto chief = FindChiefRay(*lens, LightBundle(*lens, *field, 0.0), kLineD);
        ASSERT_TRUE(chief.has_value());
        EXPECT_NEAR(std::abs(chief->sensor_mm.x), radius, 1e-9);
    }
    EXPECT_FALSE(FieldOfImageRadius(*lens, 1e5, 0.0, kLineD).has_value());
}

}  // namespace
}  // namespace flare
