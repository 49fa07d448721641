// SPDX-License-Identifier: Apache-2.0
//
// Rays at the edge of what geometry allows. Each ends in one fate and never in a NaN.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/units.h"
#include "core/tracing/paraxial_ghost.h"
#include "core/tracing/trace_reference.h"
#include "tests/support/all_kinds_lens.h"
#include "tests/support/interaction_list.h"
#include "tests/support/lenses.h"
#include "tests/support/random.h"
#include "tests/support/scalar_tracer.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::ListOf;

using testing::Assemble;
using testing::BuildLens;
using testing::Sphere;
using testing::Stop;

Interaction Surface(double radius_mm, double n_in, double n_out, bool forward = true) {
    Interaction step;
    step.shape = SurfaceShape::Sphere(radius_mm == 0.0 ? 0.0 : 1.0 / radius_mm);
    step.semi_diameter_mm = 1e6;
    step.n_in = n_in;
    step.n_out = n_out;
    step.forward = forward;
    return step;
}

const Vec3d kAlong(0.0, 0.0, 1.0);

void ExpectFinite(const TraceResult& ray) {
    EXPECT_TRUE(std::isfinite(ray.sensor_mm.x) && std::isfinite(ray.sensor_mm.y));
    EXPECT_TRUE(std::isfinite(ray.exit_direction.x + ray.exit_direction.y + ray.exit_direction.z));
    EXPECT_TRUE(std::isfinite(ray.path_mm));
    EXPECT_TRUE(std::isfinite(ray.max_rim_ratio2));
}

TEST(ARayThatMissesASphere, IsMissedAndNotClampedToItsEdge) {
    const InteractionList list = ListOf({Surface(10.0, 1.0, 1.5)}, 100.0);
    for (const double h : {10.0 + 1e-9, 10.5, 100.0, 1e8}) {
        for (const bool clip : {true, false}) {
            const TraceResult ray =
                TraceRay(list, {Vec3d(h, 0.0, -20.0), kAlong}, {clip, nullptr, false}, nullptr);
            EXPECT_EQ(ray.fate, RayFate::kMissed) << h;
            EXPECT_EQ(ray.ended_at, 0);
            ExpectFinite(ray);
        }
    }
}

TEST(AGrazingRay, LosesItsTransmittanceSmoothlyToNothing) {
    const InteractionList list = ListOf({Surface(10.0, 1.0, 1.5)}, 100.0);
    RayRecord record;
    double last = 1.0;
    for (double grazing = 0.5; grazing > 1e-7; grazing *= 0.5) {
        // cos of incidence = grazing.
        const double h = 10.0 * std::sqrt((1.0 - grazing) * (1.0 + grazing));
        const TraceResult ray = TraceRay(list, {Vec3d(h, 0.0, -20.0), kAlong}, {}, &record);
        ASSERT_EQ(ray.fate, RayFate::kArrived) << grazing;
        ExpectFinite(ray);
        ASSERT_NEAR(record.cos_in.at(0), grazing, 1e-7 + 1e-15 / grazing);
        const Reflection share = ReflectionOf({}, false, 1.0, 1.5, record.cos_in[0], kLineD);
        EXPECT_NEAR(share.reflectance + share.transmittance, 1.0, 1e-12);
        EXPECT_LT(share.transmittance, last);
        // Near grazing T falls in proportion to the cosine.
        if (grazing < 1e-3) {
            EXPECT_LT(share.transmittance, 10.0 * grazing);
        }
        last = share.transmittance;
    }
    EXPECT_LT(last, 1e-5);
    // The very equator: no square root of a negative number, either fate.
    const TraceResult edge = TraceRay(list, {Vec3d(10.0, 0.0, -20.0), kAlong}, {}, &record);
    ExpectFinite(edge);
}

TEST(IncidenceNear90Degrees, ReflectsAllAndLosesNothing) {
    const Coating coating = BuiltInCoating("mgf2-550")->For(Glass::Air(), Glass::FromNdVd(1.5, {}));
    for (const Coating& c : {Coating{}, coating}) {
        for (double angle = 89.9; angle < 90.0; angle += 0.01) {
            const double cosine = std::cos(RadiansFromDegrees(angle));
            const Reflection r = ReflectionOf(c, false, 1.0, 1.6, cosine, 550.0);
            EXPECT_NEAR(r.reflectance + r.transmittance, 1.0, 1e-12);
            EXPECT_GT(r.reflectance, 0.95);
            EXPECT_GE(r.transmittance, 0.0);
        }
        for (const double cosine : {1e-6, 1e-12, 1e-100, 0.0}) {
            const Reflection r = ReflectionOf(c, false, 1.0, 1.6, cosine, 550.0);
            EXPECT_NEAR(r.reflectance, 1.0, 1e-4);
            EXPECT_NEAR(r.reflectance + r.transmittance, 1.0, 1e-12);
            EXPECT_GE(r.transmittance, 0.0);
        }
        EXPECT_EQ(ReflectionOf(c, false, 1.0, 1.6, 0.0, 550.0).transmittance, 0.0);
    }
}

TEST(ExactlyNormalIncidence, HasTheClosedFormAndGoesStraight) {
    const double r = std::pow((1.0 - 1.5) / (1.0 + 1.5), 2);
    EXPECT_DOUBLE_EQ(ReflectionOf({}, false, 1.0, 1.5, 1.0, 550.0).reflectance, r);
    EXPECT_DOUBLE_EQ(ReflectionOf({}, true, 1.5, 1.0, 1.0, 550.0).reflectance, r);
    // Rounding may give a cosine a hair above 1.
    EXPECT_DOUBLE_EQ(ReflectionOf({}, false, 1.0, 1.5, 1.0 + 1e-15, 550.0).reflectance, r);
    const InteractionList list = ListOf({Surface(10.0, 1.0, 1.5), Surface(0.0, 1.5, 1.0)}, 100.0);
    const TraceResult ray = TraceRay(list, {Vec3d(0.0, 0.0, -5.0), kAlong}, {}, nullptr);
    EXPECT_EQ(ray.fate, RayFate::kArrived);
    EXPECT_EQ(ray.sensor_mm, Vec2d(0.0, 0.0));
    EXPECT_EQ(ray.exit_direction, kAlong);
}

TEST(TotalReflection, EndsATransmittedRayAndKeepsAReflectedOneWhole) {
    const double angle = RadiansFromDegrees(45.0);  // critical: 41.8 degrees for 1.5
    const Ray ray{Vec3d(0.0, 0.0, -1.0), Vec3d(std::sin(angle), 0.0, std::cos(angle))};
    RayRecord record;
    const TraceResult lost = TraceRay(ListOf({Surface(0.0, 1.5, 1.0)}, 10.0), ray, {}, &record);
    EXPECT_EQ(lost.fate, RayFate::kTir);
    EXPECT_EQ(lost.ended_at, 0);
    ExpectFinite(lost);

    Interaction mirror = Surface(0.0, 1.5, 1.0);
    mirror.kind = InteractionKind::kReflect;
    Interaction back = Surface(0.0, 1.5, 1.5, false);
    back.kind = InteractionKind::kReflect;
    back.vertex_z_mm = -2.0;
    const TraceResult kept = TraceRay(ListOf({mirror, back}, 10.0), ray, {}, &record);
    EXPECT_EQ(kept.fate, RayFate::kArrived);
    const Coating quarter = BuiltInCoating("mgf2-550")->For(Glass::Air(), Glass::FromNdVd(1.5, {}));
    for (const Coating& coating : {Coating{}, quarter}) {
        const Reflection r = ReflectionOf(coating, true, 1.5, 1.0, record.cos_in.at(0), 550.0);
        EXPECT_NEAR(r.reflectance, 1.0, 1e-14);
        EXPECT_EQ(r.transmittance, 0.0);
    }
}

TEST(APlane, IsOneHoweverItsRadiusIsWritten) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    std::vector<TraceResult> results;
    for (const double radius : {0.0, kInfinity, -kInfinity, 1e30, -1e30}) {
        Prescription prescription = testing::PlanoConvex();
        prescription.surfaces[2].kind = SurfaceKind::kSphere;
        prescription.surfaces[2].radius_mm = radius;
        const auto lens = BuildLens(prescription);
        results.push_back(TraceRay(WriteOut(*lens, {2, 1}, kLineD), {Vec3d(0.5, 0.7, 0.0), kAlong},
                                   {false, nullptr, false}, nullptr));
        ASSERT_EQ(results.back().fate, RayFate::kArrived) << radius;
        EXPECT_NEAR(results.back().sensor_mm.x, results.front().sensor_mm.x, 1e-12) << radius;
        EXPECT_NEAR(results.back().path_mm, results.front().path_mm, 1e-12) << radius;
    }
}

// In doubles: the digits that a centre of curvature 10 km away would cost.
TEST(AVeryWeakSurface, KeepsItsDigits) {
    for (const double radius : {1e7, -1e7, 1e12}) {
        const InteractionList list = ListOf({Surface(radius, 1.0, 1.5)}, 50.0);
        for (const double h : {1.0, 20.0, 40.0}) {
            RayRecord record;
            const Vec3d direction = Vec3d(0.3, 0.1, 1.0).normalized();
            const TraceResult ray = TraceRay(list, {Vec3d(h, 0.5 * h, -30.0), direction},
                                             {true, nullptr, true}, &record);
            ASSERT_EQ(ray.fate, RayFate::kArrived);
            // The sag is r^2 / 2R to twelve digits beyond what is asked for here.
            const Vec3d& p = record.points.at(0);
            EXPECT_NEAR(p.z, (p.x * p.x + p.y * p.y) / (2.0 * radius), 1e-12);
            EXPECT_NEAR(p.x, h + 0.3 * (p.z + 30.0), 1e-12);
        }
    }
}

TEST(NearlyConcentricSurfaces, NeedNoSpecialCase) {
    testing::Random random(1);
    for (const double off : {0.0, 1e-12, 1e-6, -1e-6, 1e-3}) {
        // A meniscus of two spheres about one centre, in front of a lens that makes an image.
        const Prescription prescription = Assemble(
            "shell", {Sphere(50.0, 10.0, 1.6, 0.0, 15.0), Sphere(40.0 + off, 5.0, 1.0, 0.0, 14.0),
                      Stop(3.0, 8.0), Sphere(60.0, 6.0, 1.6, 0.0, 15.0),
                      Sphere(-60.0, 0.0, 1.0, 0.0, 15.0)});
        const auto lens = BuildLens(prescription);
        const auto surfaces = testing::ScalarSurfaces(prescription, 587.5618L);
        for (const BounceSequence& sequence : TwoReflectionSequences(*lens)) {
            const InteractionList list = WriteOut(*lens, sequence, kLineD);
            const ParaxialPath path = ParaxialPathOf(list);
            ASSERT_TRUE(std::isfinite(path.front_to_sensor.a / path.front_to_stop.at(0).a));
            for (int k = 0; k < 20; ++k) {
                const double x = random.Uniform(-6.0, 6.0), y = random.Uniform(-6.0, 6.0);
                const TraceResult got =
                    TraceRay(list, {Vec3d(x, y, -5.0), kAlong}, {false, nullptr, false}, nullptr);
                const testing::ScalarResult want = ScalarTrace(
                    surfaces, lens->sensor_z_mm(), sequence, {x, y, -5}, {0, 0, 1}, false);
                ASSERT_EQ(got.fate == RayFate::kArrived,
                          want.fate == testing::ScalarFate::kArrived);
                if (got.fate != RayFate::kArrived) continue;
                EXPECT_NEAR(got.sensor_mm.x, static_cast<double>(want.x_mm),
                            1e-9 * (1.0 + got.sensor_mm.length()));
            }
        }
    }
}

// Surfaces in contact, and sags that overlap off the axis.
TEST(AZeroGap, IsFineAndOverlapsAreJudgedByOrder) {
    const Prescription touching =
        Assemble("touching", {Stop(0.0, 5.0), Sphere(40.0, 5.0, 1.6, 0.0, 12.0),
                              Sphere(-40.0, 0.0, 1.0, 0.0, 12.0), Sphere(40.0, 5.0, 1.5, 0.0, 12.0),
                              Sphere(-40.0, 0.0, 1.0, 0.0, 12.0)});
    const auto lens = BuildLens(touching);
    // On the axis the two vertices are one point: met in order, both.
    for (const BounceSequence& sequence : {BounceSequence{}, BounceSequence{3, 2}}) {
        const TraceResult axis = TraceRay(WriteOut(*lens, sequence, kLineD),
                                          {Vec3d(0.0, 0.0, -5.0), kAlong}, {}, nullptr);
        EXPECT_EQ(axis.fate, RayFate::kArrived);
        const TraceResult high = TraceRay(WriteOut(*lens, sequence, kLineD),
                                          {Vec3d(4.0, 0.0, -5.0), kAlong}, {}, nullptr);
        EXPECT_EQ(high.fate, RayFate::kArrived);
        EXPECT_FALSE(high.out_of_order);
    }
    // Here the second front lies before the first back, off the axis: clipped rays end, unclipped
    // ones go on and say so.
    const Prescription crossing =
        Assemble("crossing", {Stop(1.0, 9.0), Sphere(40.0, 3.0, 1.6, 0.0, 12.0),
                              Sphere(60.0, 0.0, 1.0, 0.0, 12.0), Sphere(-40.0, 3.0, 1.5, 0.0, 12.0),
                              Sphere(-30.0, 0.0, 1.0, 0.0, 12.0)});
    const auto overlapping = BuildLens(crossing);
    const InteractionList list = WriteOut(*overlapping, {}, kLineD);
    const Ray ray{Vec3d(8.0, 0.0, -5.0), kAlong};
    EXPECT_EQ(TraceRay(list, ray, {}, nullptr).fate, RayFate::kMissed);
    const TraceResult open = TraceRay(list, ray, {false, nullptr, false}, nullptr);
    EXPECT_EQ(open.fate, RayFate::kArrived);
    EXPECT_TRUE(open.out_of_order);
    EXPECT_TRUE(open.out_of_order_inside);
    ExpectFinite(open);
    EXPECT_EQ(TraceRay(list, {Vec3d(0.0, 0.0, -5.0), kAlong}, {}, nullptr).fate, RayFate::kArrived);
}

TEST(EqualMediaOnBothSides, ReflectNothingAndMakeNoGhost) {
    Prescription prescription = testing::SeedLens();
    prescription.surfaces[3].nd = prescription.surfaces[2].nd;
    prescription.surfaces[3].vd = prescription.surfaces[2].vd;
    const auto lens = BuildLens(prescription);
    EXPECT_EQ(TwoReflectionSequences(*lens).size(), 36U);  // 9 surfaces left: 9 * 8 / 2
    for (const BounceSequence& sequence : TwoReflectionSequences(*lens)) {
        EXPECT_NE(sequence[0], 3);
        EXPECT_NE(sequence[1], 3);
    }
    for (const double cosine : {1.0, 0.5, 1e-9, 0.0}) {
        const Reflection r = ReflectionOf({}, false, 1.67, 1.67, cosine, 550.0);
        EXPECT_EQ(r.reflectance, 0.0);
        EXPECT_EQ(r.transmittance, 1.0);
    }
    // Asked for all the same, such a path has the weight 0.
    const InteractionList list = WriteOut(*lens, {6, 3}, kLineD);
    RayRecord record;
    TraceRay(list, {Vec3d(0.0, 0.0, -5.0), kAlong}, {false, nullptr, false}, &record);
    EXPECT_EQ(PathWeight(*lens, list, record), 0.0);
}

TEST(AnIndexStepOf1e7, ReflectsItsFifteenthOfDecimals) {
    const double n = 1.6, step = 1e-7;
    const long double exact_step = static_cast<long double>(n + step) - n;
    for (const double angle : {0.0, 30.0, 60.0}) {
        const long double c1 = std::cos(static_cast<long double>(RadiansFromDegrees(angle)));
        const long double n2 = n + step;
        const long double c2 = std::sqrt(1 - n * n * (1 - c1 * c1) / (n2 * n2));
        const long double rs = (n * c1 - n2 * c2) / (n * c1 + n2 * c2);
        const long double rp = (n2 * c1 - n * c2) / (n2 * c1 + n * c2);
        const auto expected = static_cast<double>((rs * rs + rp * rp) / 2);
        const Reflection r =
            ReflectionOf({}, false, n, n + step, std::cos(RadiansFromDegrees(angle)), 550.0);
        EXPECT_NEAR(r.reflectance / expected, 1.0, 1e-6) << angle;
    }
    const double normal = std::pow(static_cast<double>(exact_step) / (2.0 * n + step), 2);
    EXPECT_NEAR(ReflectionOf({}, false, n, n + step, 1.0, 550.0).reflectance / normal, 1.0, 1e-12);
    EXPECT_NEAR(normal, 9.8e-16, 0.1e-16);
}

// Whatever numbers a ray is made of, it ends with a fate and finite numbers.
TEST(WildRays, NeverYieldNaN) {
    testing::Random random(77);
    for (const auto& lens :
         {testing::LibraryLens(testing::kSeedName), testing::LibraryLens(testing::kFisheyeName),
          BuildLens(testing::AllKindsLens())}) {
        const std::vector<BounceSequence> sequences = TwoReflectionSequences(*lens, true);
        RayRecord record;
        for (int k = 0; k < 20'000; ++k) {
            const BounceSequence& sequence = sequences[static_cast<std::size_t>(
                random.Below(static_cast<int>(sequences.size())))];
            const double size = std::pow(10.0, random.Uniform(-6.0, 6.0));
            const Ray ray{Vec3d(random.Uniform(-size, size), random.Uniform(-size, size),
                                random.Uniform(-size, size)),
                          Vec3d(random.Uniform(-1.0, 1.0), random.Uniform(-1.0, 1.0),
                                random.Uniform(-1.0, 1.0))
                              .normalized()};
            const InteractionList list = WriteOut(*lens, sequence, random.Uniform(300.0, 1100.0));
            const TraceResult result = TraceRay(list, ray, {k % 2 == 0, nullptr, false}, &record);
            ExpectFinite(result);
            for (const double cosine : record.cos_in) ASSERT_TRUE(cosine >= 0.0 && cosine <= 1.0);
            if (result.fate != RayFate::kArrived) continue;
            const double weight = PathWeight(*lens, list, record);
            ASSERT_TRUE(weight >= 0.0 && weight <= 1.0);
        }
    }
}

}  // namespace
}  // namespace flare
