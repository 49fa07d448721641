// SPDX-License-Identifier: Apache-2.0
#include "core/drawing/beam_rays.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"
#include "core/tracing/light_bundle.h"
#include "tests/support/lenses.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::BuildLens;
using testing::LibraryLens;

constexpr double kLead_mm = 10.0;

Iris Opening(const Lens& lens, double semi_diameter_mm) {
    const auto stop = static_cast<std::size_t>(lens.stop_index());
    return Iris(IrisShape{}, semi_diameter_mm, lens.surfaces()[stop].semi_diameter_mm);
}

// The height at the stop: point k + 1 is that at surface k on the direct path.
double AtStop(const Lens& lens, const DrawnRay& ray) {
    return ray.points[static_cast<std::size_t>(lens.stop_index()) + 1].y;
}

TEST(TraceDirectBeam, MarginalRaysPassTheEdgeOfTheIris) {
    const auto lens = BuildLens(testing::SeedLens());
    const Iris iris = Opening(*lens, 3.0);
    const DirectBeam beam = TraceDirectBeam({*lens, Section::kY, iris, kLead_mm}, 0.0, kLineD);
    ASSERT_TRUE(beam.upper && beam.lower && beam.chief);
    EXPECT_NEAR(AtStop(*lens, *beam.upper), 3.0, 1e-9);
    EXPECT_NEAR(AtStop(*lens, *beam.lower), -3.0, 1e-9);
    EXPECT_NEAR(AtStop(*lens, *beam.chief), 0.0, 1e-9);
    ASSERT_EQ(beam.upper->points.size(), lens->surfaces().size() + 2);
    EXPECT_EQ(beam.upper->points.back().x, lens->sensor_z_mm());
    EXPECT_TRUE(beam.upper->turns.empty());
    // It enters parallel to the axis, at the height that first-order optics says but for
    // aberration.
    EXPECT_EQ(beam.upper->points[0].y, beam.upper->points[1].y);
    EXPECT_NEAR(beam.upper->points[0].y, 3.0 / lens->first_order().stop_a1, 0.05);
}

TEST(TraceDirectBeam, RimsBoundItBeforeTheIrisDoes) {
    const auto lens = BuildLens(testing::SeedLens());
    const auto stop = static_cast<std::size_t>(lens->stop_index());
    const Iris iris = Opening(*lens, lens->surfaces()[stop].semi_diameter_mm);
    const DirectBeam beam =
        TraceDirectBeam({*lens, Section::kY, iris, kLead_mm}, RadiansFromDegrees(14.0), kLineD);
    ASSERT_TRUE(beam.upper && beam.lower && beam.chief);
    EXPECT_TRUE(beam.chief->passes);
    // Each outermost ray touches some rim or the iris, and none is beyond one.
    for (const DrawnRay* ray : {&*beam.upper, &*beam.lower}) {
        double closest = 0.0;
        for (std::size_t i = 0; i < lens->surfaces().size(); ++i) {
            const double share =
                std::abs(ray->points[i + 1].y) / lens->surfaces()[i].semi_diameter_mm;
            closest = std::max(closest, share);
        }
        EXPECT_NEAR(closest, 1.0, 1e-9);
    }
    EXPECT_NEAR(AtStop(*lens, *beam.chief), 0.0, 1e-9);
    EXPECT_GT(std::abs(AtStop(*lens, *beam.upper)), 1.0);
}

TEST(TraceDirectBeam, LightFromAboveComesDownAndEndsBelow) {
    const auto lens = BuildLens(testing::SeedLens());
    const Iris iris = Opening(*lens, 2.0);
    const BeamView view{*lens, Section::kY, iris, kLead_mm};
    const double field = RadiansFromDegrees(10.0);
    const DirectBeam above = TraceDirectBeam(view, field, kLineD);
    const DirectBeam below = TraceDirectBeam(view, -field, kLineD);
    ASSERT_TRUE(above.chief && below.chief);
    const Vec2d travel = above.chief->points[1] - above.chief->points[0];
    EXPECT_NEAR(std::atan2(travel.y, travel.x), -field, 1e-12);
    const double image = -lens->first_order().efl_mm * std::tan(field);
    EXPECT_NEAR(above.chief->points.back().y, image, 0.02 * std::abs(image));
    EXPECT_EQ(below.chief->points.back().y, -above.chief->points.back().y);
    // The rays of a beam start on one plane across it, at least the lead in front of the lens.
    const Vec2d wave = travel.normalized();
    for (const DrawnRay* ray : {&*above.upper, &*above.lower}) {
        EXPECT_NEAR(ray->points[0].dot(wave), above.chief->points[0].dot(wave), 1e-9);
        EXPECT_GE((ray->points[1] - ray->points[0]).length(), kLead_mm - 1e-9);
    }
}

TEST(TraceDirectBeam, SeesBehindTheFrontOfAFisheye) {
    const auto lens = LibraryLens(testing::kFisheyeName);
    const auto stop = static_cast<std::size_t>(lens->stop_index());
    const Iris iris = Opening(*lens, lens->surfaces()[stop].semi_diameter_mm);
    const DirectBeam beam =
        TraceDirectBeam({*lens, Section::kY, iris, kLead_mm}, RadiansFromDegrees(105.0), kLineD);
    ASSERT_TRUE(beam.upper && beam.lower && beam.chief);
    EXPECT_GT(beam.chief->points[0].x, beam.chief->points[1].x);  // from behind
    // Between 9.8 and 11.5 mm for 92 .. 109 degrees.
    EXPECT_GT(-beam.chief->points.back().y, 9.8);
    EXPECT_LT(-beam.chief->points.back().y, 11.5);
}

TEST(TraceDirectBeam, SaysThatNothingPasses) {
    const auto lens = BuildLens(testing::SeedLens());
    const Iris iris = Opening(*lens, 3.0);
    const DirectBeam beam =
        TraceDirectBeam({*lens, Section::kY, iris, kLead_mm}, RadiansFromDegrees(80.0), kLineD);
    EXPECT_FALSE(beam.upper || beam.lower);
}

TEST(TraceGhostFan, FindsTheStretchOfEveryGhostThatABruteForceScanFinds) {
    const auto lens = LibraryLens(testing::kFisheyeName);
    const auto stop = static_cast<std::size_t>(lens->stop_index());
    const Iris iris = Opening(*lens, lens->surfaces()[stop].semi_diameter_mm);
    const double field = RadiansFromDegrees(30.0);
    const LightBundle bundle(*lens, field, 0.0, 0.5 * kPi);
    int with_light = 0, missed = 0;
    for (const BounceSequence& sequence : TwoReflectionSequences(*lens)) {
        if (sequence[0] > 12) continue;
        const InteractionList list = WriteOut(*lens, sequence, kLineD);
        bool passes = false;
        for (int i = -20000; i <= 20000 && !passes; ++i) {
            const double u = bundle.centre_u() + bundle.half_width() * i / 20000.0;
            passes = TraceRay(list, bundle.At(u, 0.0), {true, &iris, false}, nullptr).fate ==
                     RayFate::kArrived;
        }
        const auto fan =
            TraceGhostFan({*lens, Section::kY, iris, kLead_mm}, sequence, field, kLineD);
        with_light += passes ? 1 : 0;
        missed += passes && fan.empty() ? 1 : 0;
        for (const DrawnRay& ray : fan) EXPECT_EQ(ray.turns.size(), 2U);
    }
    EXPECT_GT(with_light, 10);
    EXPECT_EQ(missed, 0);
}

}  // namespace
}  // namespace flare
