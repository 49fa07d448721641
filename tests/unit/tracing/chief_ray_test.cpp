// SPDX-License-Identifier: Apache-2.0
//
// The chief rays of a lens without symmetry about its axis.
#include "core/tracing/chief_ray.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"
#include "tests/support/lenses.h"

namespace flare {
namespace {

constexpr const char* kAnamorphic = "schneider-anamorphic-31mm-f2";

// How far from the stop's centre the ray passes, traced anew.
double MissOfStop(const Lens& lens, const Ray& ray) {
    RayRecord record;
    TraceRay(WriteOut(lens, {}, kLineD), ray, {false, nullptr, false}, &record);
    return record.stop_mm.at(0).length();
}

TEST(ChiefRay, OfAnAnamorphicLensPassesTheStopsCentreAtAnyAzimuth) {
    const auto lens = testing::LibraryLens(kAnamorphic);
    ASSERT_FALSE(lens->rotational());
    for (const double inverse_distance : {0.0, 1.0 / 3000.0}) {
        for (const double field_deg : {0.5, 4.0, 10.0}) {
            for (const double azimuth_deg : {0.0, 1e-6, 1.0, 30.0, 60.0, 89.0, 90.0}) {
                const LightBundle bundle(*lens, RadiansFromDegrees(field_deg), inverse_distance,
                                         RadiansFromDegrees(azimuth_deg));
                const auto chief = FindChiefRay(*lens, bundle, kLineD);
                ASSERT_TRUE(chief.has_value()) << field_deg << " at " << azimuth_deg;
                EXPECT_LT(MissOfStop(*lens, chief->ray), 1e-9) << field_deg << " " << azimuth_deg;
                const TraceResult traced = TraceRay(WriteOut(*lens, {}, kLineD), chief->ray,
                                                    {false, nullptr, false}, nullptr);
                EXPECT_EQ(traced.sensor_mm, chief->sensor_mm);
                // Squeezed in x: the image lies nearer to the y axis than the light.
                if (azimuth_deg > 0.5 && azimuth_deg < 89.5) {
                    EXPECT_GT(std::atan2(chief->sensor_mm.y, chief->sensor_mm.x),
                              RadiansFromDegrees(azimuth_deg));
                }
            }
        }
    }
}

// A hair off a plane of symmetry the search over the plane takes the place of that along a line.
TEST(ChiefRay, IsTheSameOnAndBesideAPlaneOfSymmetry) {
    const auto lens = testing::LibraryLens(kAnamorphic);
    constexpr double kHair = 1e-9;
    for (const double field_deg : {1.0, 8.0}) {
        const double field = RadiansFromDegrees(field_deg);
        for (const auto& [on, beside] :
             {std::pair(0.0, kHair), std::pair(0.5 * kPi, 0.5 * kPi - kHair)}) {
            const LightBundle symmetric(*lens, field, 0.0, on);
            const LightBundle skew(*lens, field, 0.0, beside);
            ASSERT_TRUE(symmetric.mirror_symmetric());
            ASSERT_FALSE(skew.mirror_symmetric());
            const auto a = FindChiefRay(*lens, symmetric, kLineD);
            const auto b = FindChiefRay(*lens, skew, kLineD);
            ASSERT_TRUE(a.has_value() && b.has_value());
            EXPECT_EQ(a->v, 0.0);
            EXPECT_NEAR(a->u, b->u, 1e-7);
            EXPECT_NEAR(b->v, 0.0, 1e-7);
            EXPECT_NEAR((a->sensor_mm - b->sensor_mm).length(), 0.0, 1e-7);
            // In its plane: the other coordinate is nothing.
            EXPECT_NEAR(on == 0.0 ? a->sensor_mm.y : a->sensor_mm.x, 0.0, 1e-12);
        }
    }
}

// In each plane an anamorphic lens is a rotational one: near the axis the image is EFL tan(field).
TEST(ChiefRay, OfAnAnamorphicLensFollowsEachSectionsFocalLength) {
    const auto lens = testing::LibraryLens(kAnamorphic);
    const double field = 1e-4;
    for (const Section section : {Section::kX, Section::kY}) {
        const double azimuth = section == Section::kX ? 0.0 : 0.5 * kPi;
        const auto chief = FindChiefRay(*lens, LightBundle(*lens, field, 0.0, azimuth), kLineD);
        ASSERT_TRUE(chief.has_value());
        const double image = section == Section::kX ? chief->sensor_mm.x : chief->sensor_mm.y;
        const double expected = lens->first_order(section).projection_distance_mm;
        EXPECT_NEAR(image / std::tan(field) / expected, 1.0, 1e-6);
        // The sensor lies midway between the two foci, 0.012 mm from each.
        EXPECT_NEAR(image / std::tan(field) / lens->first_order(section).efl_mm, 1.0, 1e-3);
    }
    EXPECT_NEAR(lens->squeeze(), 1.923, 1e-3);
}

TEST(TravelToSensor, UndoesTheChiefRay) {
    for (const char* name : {kAnamorphic, testing::kSeedName}) {
        const auto lens = testing::LibraryLens(name);
        for (const double inverse_distance : {0.0, 1.0 / 3000.0}) {
            for (const Vec2d& place : {Vec2d(0.0, 0.0), Vec2d(4.0, 0.0), Vec2d(0.0, -6.0),
                                       Vec2d(3.0, 5.0), Vec2d(-7.0, 2.0), Vec2d(-0.01, -8.0)}) {
                const auto travel = TravelToSensor(*lens, place, inverse_distance, kLineD);
                ASSERT_TRUE(travel.has_value()) << name << " " << place.x << " " << place.y;
                EXPECT_NEAR(travel->length(), 1.0, 1e-14);
                const CanonicalPose pose = PoseOf(*lens, std::atan2(travel->y, travel->x));
                const double field = std::atan2(std::hypot(travel->x, travel->y), travel->z);
                const auto chief = FindChiefRay(
                    *lens, LightBundle(*lens, field, inverse_distance, pose.azimuth_rad), kLineD);
                ASSERT_TRUE(chief.has_value());
                const Vec2d image = pose.LensSpace(chief->sensor_mm);
                EXPECT_NEAR((image - place).length(), 0.0, 2e-9)
                    << name << " " << place.x << " " << place.y;
            }
        }
        EXPECT_FALSE(TravelToSensor(*lens, Vec2d(1e5, 0.0), 0.0, kLineD).has_value()) << name;
    }
}

}  // namespace
}  // namespace flare
