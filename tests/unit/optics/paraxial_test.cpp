// SPDX-License-Identifier: Apache-2.0
#include "core/optics/paraxial.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::Assemble;
using testing::PlanoConvex;
using testing::SeedLens;
using testing::Sphere;
using testing::Stop;

std::shared_ptr<const Lens> BuildOrDie(const Prescription& prescription) {
    Result<std::shared_ptr<const Lens>> lens = Lens::Build(prescription);
    EXPECT_TRUE(lens.ok()) << lens.error().message;
    return *lens;
}

#define EXPECT_REL(value, expected, tolerance) \
    EXPECT_NEAR(value, expected, std::abs(expected) * (tolerance))

// Figures of the seed lens from an independent program.
TEST(SeedLensFirstOrder, MatchesIndependentFigures) {
    const auto lens = BuildOrDie(SeedLens());
    const FirstOrder& f = lens->first_order();
    EXPECT_REL(f.efl_mm, 50.3582, 2e-6);
    EXPECT_REL(f.bfl_mm, 36.1059, 2e-6);
    EXPECT_REL(f.entrance.z_mm, 19.9465, 3e-6);
    EXPECT_REL(f.entrance.diameter_mm, 24.8051, 3e-6);
    EXPECT_REL(f.exit.z_mm - lens->surfaces().back().vertex_z_mm, -17.7714, 4e-6);
    EXPECT_REL(f.exit.diameter_mm, 1.55196 * 17.1, 5e-6);
    EXPECT_REL(f.f_number, 2.0302, 3e-5);
    EXPECT_REL(f.stop_a1, 0.689374, 1e-6);
    EXPECT_REL(lens->sensor_z_mm(), 68.1459, 1e-6);
    // The sensor is at the focus, so d' = (z_sensor - z_exit) / m_p is the focal length.
    EXPECT_REL(f.projection_distance_mm, f.efl_mm, 1e-12);
    EXPECT_REL(f.projection_distance_mm,
               (lens->sensor_z_mm() - f.exit.z_mm) / f.pupil_magnification, 1e-12);
}

TEST(SeedLensFirstOrder, FocalLengthFollowsDispersion) {
    const auto lens = BuildOrDie(SeedLens());
    EXPECT_REL(-1.0 / FrontToBack(*lens, kLineF).c, 50.2994, 2e-6);
    EXPECT_REL(-1.0 / FrontToBack(*lens, kLineC).c, 50.3809, 2e-6);
}

TEST(SeedLensFirstOrder, MatricesMatchIndependentOnes) {
    const auto lens = BuildOrDie(SeedLens());
    const Abcd sensor = FrontToSensor(*lens, kLineD);
    EXPECT_NEAR(sensor.a, 0.0, 1e-13);
    EXPECT_REL(sensor.b, 50.3582, 2e-6);
    EXPECT_REL(sensor.c, -0.0198578, 5e-6);
    EXPECT_REL(sensor.d, 0.538591, 2e-6);
    EXPECT_NEAR(sensor.determinant(), 1.0, 1e-13);
    const Abcd stop = FrontToSurface(*lens, 5, kLineD);
    EXPECT_REL(stop.a, 0.689374, 1e-6);
    EXPECT_REL(stop.b, 13.750591, 1e-7);
    EXPECT_REL(stop.c, -0.00834254, 1e-6);
    EXPECT_REL(stop.d, 1.284187, 1e-6);
    const Abcd joined = Then(stop, StopToBack(*lens, kLineD));
    const Abcd back = FrontToBack(*lens, kLineD);
    EXPECT_NEAR(joined.b, back.b, 1e-12);
    EXPECT_NEAR(joined.c, back.c, 1e-15);
}

TEST(SeedLensBeam, RimsCutTheWideOpenBeam) {
    const auto lens = BuildOrDie(SeedLens());
    const AxialBeam beam = WorkingBeam(*lens, 8.55);
    EXPECT_REL(beam.entrance_diameter_mm, 24.2874, 3e-6);
    EXPECT_REL(beam.working_f_number, 2.0734, 3e-5);
}

TEST(SeedLensBeam, AStoppedDownBeamIsTheStopsAlone) {
    const auto lens = BuildOrDie(SeedLens());
    for (const double f_number : {2.8, 4.0, 22.0}) {
        const StopSetting setting = StopForFNumber(*lens, f_number);
        EXPECT_REL(WorkingBeam(*lens, setting.semi_diameter_mm).working_f_number, f_number, 1e-12);
    }
}

TEST(SeedLensStop, OpensAsTheFNumberAsks) {
    const auto lens = BuildOrDie(SeedLens());
    const std::pair<double, double> diameters[] = {{2.8, 12.398}, {4.0, 8.679},  {5.6, 6.199},
                                                   {8.0, 4.339},  {11.0, 3.156}, {16.0, 2.170},
                                                   {22.0, 1.578}};
    for (const auto& [f_number, diameter] : diameters) {
        const StopSetting setting = StopForFNumber(*lens, f_number);
        EXPECT_NEAR(2.0 * setting.semi_diameter_mm, diameter, 5.1e-4) << "f/" << f_number;
        EXPECT_EQ(setting.f_number, f_number);
        EXPECT_FALSE(setting.clamped);
    }
}

TEST(SeedLensStop, ClampsToTheStopAndSaysSo) {
    const auto lens = BuildOrDie(SeedLens());
    for (const double f_number : {0.7, 2.0, 2.03}) {
        const StopSetting setting = StopForFNumber(*lens, f_number);
        EXPECT_EQ(setting.semi_diameter_mm, 8.55);
        EXPECT_TRUE(setting.clamped);
        EXPECT_REL(setting.f_number, 2.0302, 3e-5);
    }
    // Its own f-number is not less than it can do.
    EXPECT_FALSE(StopForFNumber(*lens, lens->first_order().f_number).clamped);
}

TEST(SeedLensTransmittance, MatchesIndependentFigures) {
    const auto lens = BuildOrDie(SeedLens());
    EXPECT_NEAR(AxialTransmittance(*lens, 450.0), 0.912339, 1e-6);
    EXPECT_NEAR(AxialTransmittance(*lens, 550.0), 0.967423, 1e-6);
    EXPECT_NEAR(AxialTransmittance(*lens, 650.0), 0.937865, 1e-6);
    EXPECT_NEAR(AxialTransmittance(*lens->WithBareGlass(), kLineD), 0.589977, 1e-6);
}

// Closed forms: EFL R/(n-1); BFL of convex-first, EFL - d/n; the stop in front is its own image.
TEST(PlanoConvexFirstOrder, MatchesClosedForms) {
    const auto lens = BuildOrDie(PlanoConvex());
    const FirstOrder& f = lens->first_order();
    EXPECT_REL(f.efl_mm, 100.0, 1e-14);
    EXPECT_REL(f.bfl_mm, 100.0 - 6.0 / 1.5, 1e-14);
    EXPECT_EQ(f.stop_a1, 1.0);
    EXPECT_EQ(f.entrance.z_mm, 0.0);
    EXPECT_EQ(f.entrance.diameter_mm, 10.0);
    EXPECT_REL(f.f_number, 10.0, 1e-14);
    // The stop, 2 mm in front of a thin lens of 100 mm seen through 6 mm of glass:
    // 1/s' = 1/100 - 1/2 at the front vertex, then 4 mm of reduced thickness.
    const double image_from_front = 1.0 / (1.0 / 100.0 - 1.0 / 2.0);
    EXPECT_REL(f.exit.z_mm, 2.0 + 6.0 + (image_from_front - 4.0), 1e-13);
    EXPECT_REL(f.exit.diameter_mm, 10.0 * (-image_from_front) / 2.0, 1e-13);
    EXPECT_REL(f.projection_distance_mm, 100.0, 1e-13);
}

// Two plano-convex lenses of 100 mm with the stop at the front focus of the second one.
TEST(Telecentric, ExitPupilAtInfinityLeavesFiniteFNumberAndProjection) {
    Prescription prescription = Assemble("telecentric", {
                                                            Sphere(0.0, 3.0, 1.5, 0.0, 20.0),
                                                            Sphere(-200.0, 20.0, 1.0, 0.0, 20.0),
                                                            Stop(100.0, 5.0),
                                                            Sphere(50.0, 6.0, 1.5, 0.0, 20.0),
                                                            Sphere(0.0, 0.0, 1.0, 0.0, 20.0),
                                                        });
    const auto lens = BuildOrDie(prescription);
    const FirstOrder& f = lens->first_order();
    EXPECT_TRUE(std::isinf(f.exit.z_mm));
    EXPECT_TRUE(std::isinf(f.exit.diameter_mm));
    EXPECT_REL(f.projection_distance_mm, f.efl_mm, 1e-12);
    EXPECT_REL(WorkingBeam(*lens, 5.0).working_f_number, f.f_number, 1e-12);
}

TEST(Matrices, MultiplyInTheOrderOfTravel) {
    const Abcd m = Then(Drift(3.0), Refraction(0.1, 1.0, 1.5));
    // y' = y + 3 u; u' = (u - 0.1 * 0.5 y') / 1.5.
    EXPECT_DOUBLE_EQ(m.a, 1.0);
    EXPECT_DOUBLE_EQ(m.b, 3.0);
    EXPECT_DOUBLE_EQ(m.c, -0.05 / 1.5);
    EXPECT_DOUBLE_EQ(m.d, (1.0 - 0.15) / 1.5);
    EXPECT_DOUBLE_EQ(m.determinant(), 1.0 / 1.5);
}

}  // namespace
}  // namespace flare
