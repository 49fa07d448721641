// SPDX-License-Identifier: Apache-2.0
//
// The exact tracer against a second one, written for the tests in another form and in long double
// (tests/support/scalar_tracer.h): same fates, same places, same angles, for random rays along
// random bounce sequences through every lens of the library.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"
#include "core/tracing/chief_ray.h"
#include "core/tracing/light_bundle.h"
#include "core/tracing/trace_reference.h"
#include "tests/support/lenses.h"
#include "tests/support/random.h"
#include "tests/support/scalar_tracer.h"

namespace flare {
namespace {

using testing::Random;
using testing::Real;
using testing::Real3;
using testing::ScalarFate;
using testing::ScalarResult;

RayFate FateOf(ScalarFate fate) {
    switch (fate) {
        case ScalarFate::kArrived:
            return RayFate::kArrived;
        case ScalarFate::kVignetted:
            return RayFate::kVignetted;
        case ScalarFate::kStopped:
            return RayFate::kStopped;
        case ScalarFate::kMissed:
            return RayFate::kMissed;
        case ScalarFate::kTir:
            return RayFate::kTir;
    }
    return RayFate::kMissed;
}

Real3 ToReal(const Vec3d& v) {
    return {v.x, v.y, v.z};
}

class SecondTracer : public ::testing::TestWithParam<const char*> {};

TEST_P(SecondTracer, AgreesOnFateAndPlaceOfEveryRay) {
    const auto lens = testing::LibraryLens(GetParam());
    Random random(17);
    std::vector<BounceSequence> sequences = TwoReflectionSequences(*lens);
    const int ghosts = static_cast<int>(sequences.size());
    const bool fisheye = lens->prescription().fisheye;
    int fates[5] = {};
    double worst = 0.0;
    for (int round = 0; round < 120; ++round) {
        const BounceSequence sequence =
            round % 6 == 0 ? BounceSequence{}
                           : sequences[static_cast<std::size_t>(random.Below(ghosts))];
        const double field = random.Uniform(0.0, RadiansFromDegrees(fisheye ? 100.0 : 20.0));
        const double inverse_distance = round % 3 == 0 ? 1.0 / random.Uniform(800.0, 5000.0) : 0.0;
        const double wavelength = random.Uniform(400.0, 700.0);
        const LightBundle bundle(*lens, field, inverse_distance);
        const InteractionList list = WriteOut(*lens, sequence, wavelength);
        const auto surfaces = testing::ScalarSurfaces(lens->prescription(), wavelength);
        const auto chief = FindChiefRay(*lens, bundle, wavelength);
        RayRecord record;
        for (int k = 0; k < 60; ++k) {
            // Half of them where the entrance pupil is, so that many get through.
            const bool anywhere = k % 2 == 0 || !chief;
            const double reach =
                anywhere ? bundle.half_width() : 0.6 * lens->first_order().entrance.diameter_mm;
            const double u =
                (anywhere ? bundle.centre_u() : chief->u) + random.Uniform(-reach, reach);
            const double v = random.Uniform(-reach, reach);
            const Ray ray = bundle.At(u, v);
            for (const bool clip : {true, false}) {
                const TraceResult got = TraceRay(list, ray, {clip, nullptr, false}, &record);
                const ScalarResult want =
                    ScalarTrace(surfaces, lens->sensor_z_mm(), sequence, ToReal(ray.origin),
                                ToReal(ray.direction), clip);
                ASSERT_EQ(got.fate, FateOf(want.fate)) << "round " << round << " ray " << k;
                ASSERT_EQ(record.cos_in.size(), want.cos_in.size());
                if (clip) ++fates[static_cast<int>(got.fate)];
                if (got.fate != RayFate::kArrived) continue;
                // Beyond the rims rays may fly far: there the error is relative.
                const double size = clip ? 1.0 : 1.0 + got.sensor_mm.length();
                const double error = std::hypot(got.sensor_mm.x - static_cast<double>(want.x_mm),
                                                got.sensor_mm.y - static_cast<double>(want.y_mm));
                if (clip) worst = std::max(worst, error);
                EXPECT_LT(error, 1e-9 * size);
                if (!clip) continue;
                EXPECT_NEAR(got.path_mm, static_cast<double>(want.path_mm), 1e-9);
                for (std::size_t i = 0; i < want.cos_in.size(); ++i) {
                    // The stop's cosine is not used.
                    if (list.steps[i].kind == InteractionKind::kStop) continue;
                    EXPECT_NEAR(record.cos_in[i], static_cast<double>(want.cos_in[i]), 1e-11);
                }
                for (std::size_t i = 0; i < want.stops.size(); ++i) {
                    EXPECT_NEAR(record.stop_mm[i].x, static_cast<double>(want.stops[i].x), 1e-9);
                    EXPECT_NEAR(record.stop_mm[i].y, static_cast<double>(want.stops[i].y), 1e-9);
                }
            }
        }
    }
    // The comparison must have seen rays of every common sort.
    EXPECT_GT(fates[static_cast<int>(RayFate::kArrived)], 100);
    EXPECT_GT(fates[static_cast<int>(RayFate::kVignetted)], 100);
    EXPECT_GT(fates[static_cast<int>(RayFate::kMissed)] + fates[static_cast<int>(RayFate::kTir)],
              0);
    RecordProperty("worst_mm", std::to_string(worst));
}

INSTANTIATE_TEST_SUITE_P(Library, SecondTracer, ::testing::ValuesIn(testing::kLibraryNames),
                         [](const auto& test) {
                             std::string name = test.param;
                             for (char& c : name) {
                                 if (c == '-') c = '_';
                             }
                             return name;
                         });

// The light of a point on the axis through a plano-convex lens, by plain trigonometry: a ray
// parallel to the axis that goes through the plane first bends only at the sphere.
TEST(OneRefraction, FollowsTheClosedFormOfAPlanoConvexLens) {
    Prescription prescription;
    prescription.name = "plano";
    SurfacePrescription stop, plane, sphere;
    stop.kind = SurfaceKind::kStop;
    stop.gap_mm = 1.0;
    stop.semi_diameter_mm = 9.0;
    plane.kind = SurfaceKind::kPlane;
    plane.gap_mm = 5.0;
    plane.nd = 1.5;
    plane.semi_diameter_mm = 9.0;
    sphere.radius_mm = -30.0;
    sphere.semi_diameter_mm = 9.0;
    prescription.surfaces = {stop, plane, sphere};
    const auto lens = testing::BuildLens(prescription);
    const InteractionList list = WriteOut(*lens, {}, kLineD);
    for (const double h : {0.5, 3.0, 8.5}) {
        const TraceResult ray =
            TraceRay(list, {Vec3d(0.0, h, -10.0), Vec3d(0.0, 0.0, 1.0)}, {}, nullptr);
        ASSERT_EQ(ray.fate, RayFate::kArrived);
        const double in = std::asin(h / 30.0);
        const double out = std::asin(1.5 * h / 30.0);
        const double z = 6.0 - 30.0 * (1.0 - std::cos(in));
        const double y = h - (lens->sensor_z_mm() - z) * std::tan(out - in);
        EXPECT_NEAR(ray.sensor_mm.y, y, 1e-12);
        EXPECT_EQ(ray.sensor_mm.x, 0.0);
    }
}

}  // namespace
}  // namespace flare
