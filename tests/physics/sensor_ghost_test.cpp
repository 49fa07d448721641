// SPDX-License-Identifier: Apache-2.0
//
// Ghosts that the sensor reflects, against closed forms of a plano-convex lens.
#include <gtest/gtest.h>

#include <cmath>

#include "core/render/ghost_list.h"
#include "tests/support/brute_force.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::Studio;

constexpr double kSensorReflectance = 0.08;

// Surfaces: stop, convex, plane, sensor (3). Focal length 100 mm, the focus 96 mm behind the plane.
std::shared_ptr<const Lens> WithSensor(double semi_diameter_mm = 21.6) {
    Prescription prescription = testing::PlanoConvex();
    SurfacePrescription sensor;
    sensor.kind = SurfaceKind::kSensor;
    sensor.reflectance = kSensorReflectance;
    sensor.semi_diameter_mm = semi_diameter_mm;
    prescription.surfaces.push_back(sensor);
    return testing::BuildLens(prescription);
}

const GhostEntry& EntryOf(const GhostList& list, const BounceSequence& sequence) {
    for (const GhostEntry& ghost : list.ghosts) {
        if (ghost.sequence == sequence) return ghost;
    }
    CheckFailed("no such ghost", __FILE__, __LINE__);
}

GhostList Ranked(const std::shared_ptr<const Lens>& lens, double f_number, double field_deg) {
    Studio studio;
    GhostListOptions options;
    options.f_number = f_number;
    options.field_deg = field_deg;
    options.model.sensor_reflection = true;
    options.with_peaks = false;
    const auto list = RankGhosts(lens, options, studio.Context());
    FLARE_CHECK(list.ok());
    return *list;
}

TEST(SensorGhosts, OfAPlanoConvexLensAreThree) {
    const GhostList list = Ranked(WithSensor(), 40.0, 0.0);
    ASSERT_EQ(list.ghosts.size(), 3U);
    double sum = 0.0;
    for (const GhostEntry& ghost : list.ghosts) sum += ghost.flux_mm2;
    EXPECT_NEAR(sum, list.total_flux_mm2, 1e-12);
}

// Light that is focused on the sensor, goes back to the plane side and comes again: a disc as wide
// as the beam is 2 x 96 mm from its focus, and the flux of two reflections.
TEST(SensorGhosts, BetweenSensorAndPlaneSideHaveTheClosedFormsFluxAndPlace) {
    const auto lens = WithSensor();
    const double n = 1.5, gap = lens->sensor_gap_mm(), radius = 100.0 / 40.0 / 2.0;
    EXPECT_NEAR(gap, 96.0, 1e-9);
    const double r = (n - 1.0) * (n - 1.0) / ((n + 1.0) * (n + 1.0));
    const double flux = (1.0 - r) * (1.0 - r) * kSensorReflectance * r * kPi * radius * radius;
    const GhostEntry axis = EntryOf(Ranked(lens, 40.0, 0.0), {3, 2});
    EXPECT_NEAR(axis.flux_mm2, flux, 1e-3 * flux);
    EXPECT_NEAR(axis.x.abcd.a, -2.0 * gap / 100.0, 1e-9);
    EXPECT_NEAR(axis.centroid_mm.length(), 0.0, 1e-6);

    // Off the axis: the ray through the stop's middle (2 mm before the convex vertex), first order.
    const double u = std::tan(RadiansFromDegrees(1.0));
    double y = 2.0 * u;
    double slope = u / n - y * (n - 1.0) / (n * 50.0);
    y += 6.0 * slope;
    slope *= n;
    y += gap * slope;
    const double again = y + 2.0 * gap * slope;
    const GhostEntry off = EntryOf(Ranked(lens, 40.0, 1.0), {3, 2});
    EXPECT_NEAR(off.centroid_mm.x, again, 2e-3 * again);
    EXPECT_NEAR(off.centroid_mm.y, 0.0, 1e-6);
    EXPECT_NEAR(off.flux_mm2, flux, 2e-3 * flux);
}

TEST(SensorGhosts, HaveTheFluxOfCountedRays) {
    const auto lens = WithSensor();
    const GhostList list = Ranked(lens, 12.0, 4.0);
    const Iris iris({}, StopForFNumber(*lens, 12.0).semi_diameter_mm, 5.0);
    const LightBundle bundle(*lens, RadiansFromDegrees(4.0), 0.0);
    for (const GhostEntry& ghost : list.ghosts) {
        const auto counted = testing::CountFlux(*lens, bundle, ghost.sequence, kLineD, iris, 320,
                                                [](const Vec2d&, double) {});
        ASSERT_GT(counted.arrived, 3000);
        EXPECT_NEAR(ghost.flux_mm2, counted.flux_mm2, 0.004 * counted.flux_mm2);
        EXPECT_NEAR(ghost.centroid_mm.x, counted.centroid_mm.x,
                    0.02 + 0.004 * std::abs(counted.centroid_mm.x));
    }
}

// Light that misses the sensor is not reflected by it: 1 degree lands 1.75 mm off the axis.
TEST(SensorGhosts, EndWhereTheSensorDoes) {
    EXPECT_GT(EntryOf(Ranked(WithSensor(2.0), 40.0, 1.0), {3, 2}).flux_mm2, 0.0);
    EXPECT_EQ(EntryOf(Ranked(WithSensor(1.5), 40.0, 1.0), {3, 2}).flux_mm2, 0.0);
    EXPECT_GT(EntryOf(Ranked(WithSensor(1.5), 40.0, 1.0), {2, 1}).flux_mm2, 0.0);
}

// The frame holds all the light of the widest of them.
TEST(SensorGhosts, AreDrawnWhenAskedForAndOnlyThen) {
    Studio studio;
    const auto lens = WithSensor();
    FlareRequest request = testing::SpectralRequest(lens, 40.0, 160, 160);
    request.image.sensor_width_mm = 120.0;
    request.lights = {LightAt(1.0)};
    const auto light = [&](const FlareRequest& wanted) {
        const double pitch = 120.0 / 160.0;
        return testing::Sum(studio.Shoot(wanted).image.planes[0]) * pitch * pitch;
    };
    const GhostList list = Ranked(lens, 40.0, 1.0);
    const double without = light(request);
    EXPECT_NEAR(without, EntryOf(list, {2, 1}).flux_mm2, 0.004 * without);
    request.model.sensor_reflection = true;
    EXPECT_NEAR(light(request), list.total_flux_mm2, 0.004 * list.total_flux_mm2);
    EXPECT_EQ(studio.Shoot(request).report.facts.ghosts.size(), 3U);
}

TEST(SensorGhosts, AreRefusedWhereTheLensHasNoSensor) {
    Studio studio;
    FlareRequest request =
        testing::SpectralRequest(testing::BuildLens(testing::PlanoConvex()), 12.0, 16, 16);
    request.model.sensor_reflection = true;
    const auto rendering = Render(request, studio.Context());
    ASSERT_FALSE(rendering.ok());
    EXPECT_EQ(rendering.error().where, "/model/sensor_reflection");
    EXPECT_NE(rendering.error().message.find("no reflecting sensor"), std::string::npos);
    GhostListOptions options;
    options.model.sensor_reflection = true;
    const auto list = RankGhosts(request.lens, options, studio.Context());
    ASSERT_FALSE(list.ok());
    EXPECT_EQ(list.error().where, "sensor_reflection");
}

}  // namespace
}  // namespace flare
