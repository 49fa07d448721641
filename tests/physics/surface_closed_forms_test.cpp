// SPDX-License-Identifier: Apache-2.0
//
// Surfaces of every kind against what geometry knows without tracing: Cartesian surfaces focus
// perfectly, plates shift, cylinders leave one section alone.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/tracing/trace_reference.h"
#include "tests/support/all_kinds_lens.h"
#include "tests/support/interaction_list.h"
#include "tests/support/lenses.h"
#include "tests/support/random.h"

namespace flare {
namespace {

using testing::ListOf;

using testing::Random;

constexpr double kFocus_mm = 1e-12;

Interaction At(const SurfaceShape& shape, double z, double n_in, double n_out,
               InteractionKind kind = InteractionKind::kRefract, bool forward = true) {
    Interaction step;
    step.kind = kind;
    step.shape = shape;
    step.vertex_z_mm = z;
    step.semi_diameter_mm = 25.0;
    step.n_in = n_in;
    step.n_out = n_out;
    step.forward = forward;
    return step;
}

// The same conic as a closed form, and as an asphere whose coefficient does nothing, so that it is
// iterated.
std::vector<SurfaceShape> BothWays(double curvature, double conic) {
    const SurfaceShape closed = SurfaceShape::Asphere(curvature, conic, {});
    const SurfaceShape iterated = SurfaceShape::Asphere(curvature, conic, {1e-300});
    EXPECT_EQ(closed.form(), SurfaceForm::kQuadric);
    EXPECT_EQ(iterated.form(), SurfaceForm::kAsphere);
    return {closed, iterated};
}

const std::vector<Vec2d> kBeam = {{0.0, 0.0},   {0.01, 0.0}, {3.0, -4.0},  {-8.0, 1.0},
                                  {0.0, 12.0},  {-9.0, 9.0}, {14.0, 10.0}, {-17.0, -10.0},
                                  {1e-9, 1e-9}, {0.0, 20.0}};

TEST(AParabola, FocusesAnAxialBeamToAPoint) {
    const double focal = 60.0;
    for (const SurfaceShape& mirror : BothWays(1.0 / (2.0 * focal), -1.0)) {
        // Light that travels towards -z meets the hollow side and is sent to z = focal.
        const InteractionList list =
            ListOf({At(mirror, 0.0, 1.0, 1.5, InteractionKind::kReflect, false)}, focal);
        for (const Vec2d& p : kBeam) {
            const TraceResult ray =
                TraceRay(list, {Vec3d(p.x, p.y, 90.0), Vec3d(0.0, 0.0, -1.0)}, {}, nullptr);
            ASSERT_EQ(ray.fate, RayFate::kArrived);
            EXPECT_LT(ray.sensor_mm.length(), kFocus_mm) << p.x << " " << p.y;
            // Every way is as long as every other: 90 down and the focal length back.
            EXPECT_NEAR(ray.path_mm, 90.0 + focal, 1e-12);
        }
    }
}

// An ellipse sends the light of one focus to the other.
TEST(AnEllipse, ImagesOneFocusOnTheOther) {
    const double a = 80.0, c = 30.0, b2 = a * a - c * c;  // half axis, eccentric distance
    for (const SurfaceShape& mirror : BothWays(a / b2, b2 / (a * a) - 1.0)) {
        const InteractionList list =
            ListOf({At(mirror, 0.0, 1.0, 1.5, InteractionKind::kReflect, false)}, a + c);
        for (const Vec2d& slope : kBeam) {
            const Vec3d direction = Vec3d(0.02 * slope.x, 0.02 * slope.y, -1.0).normalized();
            const TraceResult ray =
                TraceRay(list, {Vec3d(0.0, 0.0, a - c), direction}, {}, nullptr);
            ASSERT_EQ(ray.fate, RayFate::kArrived);
            EXPECT_LT(ray.sensor_mm.length(), kFocus_mm * 1.0) << slope.x << " " << slope.y;
            EXPECT_NEAR(ray.path_mm, 2.0 * a, 1e-12);
        }
    }
}

// By Fermat n z + n' sqrt(r^2 + (f - z)^2) = n' f, so r^2 + (1 - n^2/n'^2) z^2 = 2 (1 - n/n') f z:
// a conic with k = -(n/n')^2 and R = (1 - n/n') f.
TEST(ACartesianSurface, RefractsAnAxialBeamToAPoint) {
    for (const double index : {1.33, 1.5, 1.9}) {
        // Into glass: an ellipse.
        const double inside = 70.0;
        for (const SurfaceShape& front :
             BothWays(1.0 / ((1.0 - 1.0 / index) * inside), -1.0 / (index * index))) {
            const InteractionList list = ListOf({At(front, 0.0, 1.0, index)}, inside);
            for (const Vec2d& p : kBeam) {
                // A small index makes a short radius: within 0.8 of the equator.
                if (p.length() > 0.8 * front.reach_mm()) continue;
                const TraceResult ray =
                    TraceRay(list, {Vec3d(p.x, p.y, -10.0), Vec3d(0.0, 0.0, 1.0)}, {}, nullptr);
                ASSERT_EQ(ray.fate, RayFate::kArrived) << index;
                EXPECT_LT(ray.sensor_mm.length(), kFocus_mm) << index << " " << p.x << " " << p.y;
            }
        }
        // Out of glass: a hyperbola behind a plane.
        const double focal = 80.0, thick = 9.0;
        for (const SurfaceShape& back : BothWays(1.0 / ((1.0 - index) * focal), -index * index)) {
            const InteractionList list =
                ListOf({At(SurfaceShape(), -thick, 1.0, index), At(back, 0.0, index, 1.0)}, focal);
            for (const Vec2d& p : kBeam) {
                const TraceResult ray =
                    TraceRay(list, {Vec3d(p.x, p.y, -20.0), Vec3d(0.0, 0.0, 1.0)}, {}, nullptr);
                ASSERT_EQ(ray.fate, RayFate::kArrived) << index;
                EXPECT_LT(ray.sensor_mm.length(), kFocus_mm) << index << " " << p.x << " " << p.y;
                EXPECT_NEAR(ray.path_mm, 11.0 + index * thick + focal, 1e-12);
            }
        }
    }
}

// A field of rays at all heights and angles.
std::vector<Ray> Rays(int count, double height, double slope) {
    Random random(4);
    std::vector<Ray> rays;
    for (int k = 0; k < count; ++k) {
        const auto within = [&](double size) { return random.Uniform(-size, size); };
        rays.push_back({Vec3d(within(height), within(height), -15.0),
                        Vec3d(within(slope), within(slope), 1.0).normalized()});
    }
    return rays;
}

TEST(AToroid, OfEqualRadiiIsTheSphere) {
    EXPECT_EQ(SurfaceShape::Toroid(1.0 / 30.0, 1.0 / 30.0), SurfaceShape::Sphere(1.0 / 30.0));
    // And the nearer its radii come to each other, the nearer to it, in proportion. The toroid is
    // iterated, the sphere a closed form.
    const InteractionList sphere =
        ListOf({At(SurfaceShape::Sphere(1.0 / 30.0), 0.0, 1.0, 1.6)}, 60.0);
    for (const Ray& ray : Rays(200, 10.0, 0.3)) {
        const TraceResult want = TraceRay(sphere, ray, {}, nullptr);
        ASSERT_EQ(want.fate, RayFate::kArrived);
        double last = 0.0;
        for (const double off : {1e-3, 1e-6, 1e-9, 1e-13}) {
            const SurfaceShape toroid =
                SurfaceShape::Toroid((1.0 + off) / 30.0, (1.0 - off) / 30.0);
            ASSERT_EQ(toroid.form(), SurfaceForm::kToroid);
            const TraceResult got =
                TraceRay(ListOf({At(toroid, 0.0, 1.0, 1.6)}, 60.0), ray, {}, nullptr);
            const double error = (got.sensor_mm - want.sensor_mm).length();
            EXPECT_LT(error, 60.0 * off + 1e-13);
            if (off == 1e-6) {
                EXPECT_NEAR(error / last, 1e-3, 2e-5);
            }
            last = error;
        }
    }
}

TEST(ACylinder, InItsOwnPlaneIsTheSpheresSection) {
    for (const double curvature : {1.0 / 30.0, -1.0 / 45.0}) {
        const SurfaceShape sphere = SurfaceShape::Sphere(curvature);
        for (Ray ray : Rays(200, 12.0, 0.3)) {
            for (const bool in_x : {true, false}) {
                const SurfaceShape cylinder =
                    in_x ? SurfaceShape::CylinderX(curvature) : SurfaceShape::CylinderY(curvature);
                Ray flat = ray;
                (in_x ? flat.origin.y : flat.origin.x) = 0.0;
                (in_x ? flat.direction.y : flat.direction.x) = 0.0;
                flat.direction.normalize();
                // Through a thick lens of it, forward.
                const auto trace = [&](const SurfaceShape& shape) {
                    return TraceRay(
                        ListOf({At(shape, 0.0, 1.0, 1.6), At(shape, 8.0, 1.6, 1.2)}, 50.0), flat,
                        {}, nullptr);
                };
                const TraceResult want = trace(sphere);
                const TraceResult got = trace(cylinder);
                ASSERT_EQ(got.fate, want.fate);
                if (want.fate != RayFate::kArrived) continue;
                EXPECT_NEAR((got.sensor_mm - want.sensor_mm).length(), 0.0, 1e-13);
                EXPECT_NEAR(got.path_mm, want.path_mm, 1e-13);
            }
        }
    }
}

TEST(ACylinder, LeavesTheOtherSectionAlone) {
    for (const Ray& ray : Rays(300, 12.0, 0.3)) {
        const InteractionList curved =
            ListOf({At(SurfaceShape::CylinderX(1.0 / 30.0), 0.0, 1.0, 1.6)}, 40.0);
        const TraceResult got = TraceRay(curved, ray, {}, nullptr);
        ASSERT_EQ(got.fate, RayFate::kArrived);
        // Along its axis the cylinder bears no force: n d_y is kept, for skew rays too.
        EXPECT_NEAR(1.6 * got.exit_direction.y, ray.direction.y, 1e-15);
        // In the plane of its axis it is a plane.
        const Ray flat{Vec3d(0.0, ray.origin.y, ray.origin.z),
                       Vec3d(0.0, ray.direction.y, ray.direction.z).normalized()};
        const InteractionList plane = ListOf({At(SurfaceShape(), 0.0, 1.0, 1.6)}, 40.0);
        const TraceResult along = TraceRay(curved, flat, {}, nullptr);
        EXPECT_NEAR((along.sensor_mm - TraceRay(plane, flat, {}, nullptr).sensor_mm).length(), 0.0,
                    1e-14);
    }
}

// A plate of thickness t and index n moves a ray sideways by t sin a (1 - cos a / sqrt(n^2 - sin^2
// a)) and does not turn it.
TEST(APlate, ShiftsARayAndDoesNotTurnIt) {
    const double thick = 7.0, index = 1.6;
    const std::vector<SurfaceShape> planes = {
        SurfaceShape(), SurfaceShape::Asphere(0.0, -1.0, {1e-300}), SurfaceShape::CylinderX(0.0),
        SurfaceShape::Toroid(0.0, 1e-300), SurfaceShape::Sphere(1e-300)};
    for (const SurfaceShape& face : planes) {
        const InteractionList list =
            ListOf({At(face, 0.0, 1.0, index), At(face, thick, index, 1.0)}, 30.0);
        for (const double degrees : {0.0, 1.0, 20.0, 45.0, 70.0}) {
            for (const double azimuth : {0.0, 1.0, 2.5}) {
                const double a = degrees * 0.017453292519943295;
                const Vec3d direction(std::sin(a) * std::cos(azimuth),
                                      std::sin(a) * std::sin(azimuth), std::cos(a));
                const Ray ray{Vec3d(1.0, -2.0, 0.0) - direction * 3.0, direction};
                const TraceResult got = TraceRay(list, ray, {false, nullptr, false}, nullptr);
                ASSERT_EQ(got.fate, RayFate::kArrived);
                EXPECT_NEAR((got.exit_direction - direction).length(), 0.0, 1e-15);
                const double shift =
                    thick * std::sin(a) *
                    (1.0 - std::cos(a) / std::sqrt(index * index - std::pow(std::sin(a), 2)));
                const Vec2d straight(1.0 + 30.0 * direction.x / direction.z,
                                     -2.0 + 30.0 * direction.y / direction.z);
                const Vec2d back =
                    Vec2d(std::cos(azimuth), std::sin(azimuth)) * (-shift / std::cos(a));
                EXPECT_NEAR((got.sensor_mm - straight - back).length(), 0.0, 1e-12) << degrees;
            }
        }
    }
}

// ---- The sensor as a mirror ----

// A plano-convex lens and a reflecting sensor: light back from the sensor, reflected by the plane
// face, lands after three times the way from the plane.
TEST(AReflectingSensor, MakesTheGhostThatTrigonometryKnows) {
    Prescription prescription = testing::PlanoConvex();
    prescription.surfaces.push_back(testing::Mirror(0.25, 30.0));
    const auto lens = testing::BuildLens(prescription);
    ASSERT_EQ(lens->sensor_index(), 3);
    EXPECT_EQ(ReflectingSurfaces(*lens, true), (std::vector<int>{1, 2, 3}));
    EXPECT_EQ(ReflectingSurfaces(*lens, false), (std::vector<int>{1, 2}));
    EXPECT_EQ(TwoReflectionSequences(*lens, true),
              (std::vector<BounceSequence>{{2, 1}, {3, 1}, {3, 2}}));
    EXPECT_EQ(TwoReflectionSequences(*lens).size(), 1U);
    EXPECT_FALSE(CheckSequence(*lens, {3, 2}).has_value());
    EXPECT_FALSE(CheckSequence(*lens, {3, 1, 3, 2}).has_value());
    EXPECT_TRUE(CheckSequence(*lens, {2, 3}).has_value());
    EXPECT_TRUE(CheckSequence(*lens, {4, 1}).has_value());

    const double distance = lens->sensor_z_mm() - 8.0;  // the plane stands at z = 8
    for (const double h : {0.3, 2.0, 4.5}) {
        const Ray ray{Vec3d(0.0, h, -5.0), Vec3d(0.0, 0.0, 1.0)};
        // At the sphere (R 50, n 1.5, vertex at z = 2), at the plane, and straight to the sensor.
        const double in = std::asin(h / 50.0), turn = in - std::asin(h / 75.0);
        const double sag = 50.0 * (1.0 - std::cos(in));
        const double at_plane = h - (6.0 - sag) * std::tan(turn);
        const double out = std::asin(1.5 * std::sin(turn));
        RayRecord record;
        for (const int passages : {1, 3, 5}) {
            BounceSequence sequence;
            for (int k = 1; k < passages; k += 2) sequence.insert(sequence.end(), {3, 2});
            const InteractionList list = WriteOut(*lens, sequence, kLineD);
            // Rims do not matter: the third time the beam is wider than the lens.
            const TraceResult got = TraceRay(list, ray, {false, nullptr, false}, &record);
            ASSERT_EQ(got.fate, RayFate::kArrived);
            EXPECT_NEAR(got.sensor_mm.y, at_plane - passages * distance * std::tan(out), 1e-12);
            EXPECT_EQ(got.sensor_mm.x, 0.0);
            // Each time round costs the sensor's share and the plane's.
            const auto share = [](double n1, double n2, double cos1) {
                const double cos2 = std::sqrt(1.0 - n1 * n1 / (n2 * n2) * (1.0 - cos1 * cos1));
                const double s = (n1 * cos1 - n2 * cos2) / (n1 * cos1 + n2 * cos2);
                const double p = (n2 * cos1 - n1 * cos2) / (n2 * cos1 + n1 * cos2);
                return 0.5 * (s * s + p * p);
            };
            const double front = share(1.0, 1.5, std::cos(in));
            const double plane = share(1.5, 1.0, std::cos(turn));
            const double round = 0.25 * share(1.0, 1.5, std::cos(out));
            EXPECT_NEAR(PathWeight(*lens, list, record),
                        (1.0 - front) * (1.0 - plane) * std::pow(round, (passages - 1) / 2), 1e-14);
        }
    }
}

}  // namespace
}  // namespace flare
