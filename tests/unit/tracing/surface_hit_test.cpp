// SPDX-License-Identifier: Apache-2.0
//
// Hits against a brute-force search with bisection in long double (tests/support/scalar_surface.h),
// for every form of surface and from every side.
#include "core/tracing/surface_hit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/scalar_surface.h"

namespace flare {
namespace {

using testing::Random;
using testing::Real;
using testing::Real3;
using testing::ScalarHit;

struct Case {
    std::string name;
    SurfaceShape shape;
    double semi;
};

// Every form, gentle and steep: the rims reach up to 0.98 of the equator.
std::vector<Case> Cases() {
    return {
        {"plane", SurfaceShape(), 10.0},
        {"sphere", SurfaceShape::Sphere(1.0 / 20.0), 19.6},
        {"hollow sphere", SurfaceShape::Sphere(-1.0 / 300.0), 30.0},
        {"weak sphere", SurfaceShape::Sphere(1e-6), 30.0},
        {"ellipsoid", SurfaceShape::Asphere(1.0 / 20.0, -0.43, {}), 25.0},
        {"oblate", SurfaceShape::Asphere(-1.0 / 20.0, 2.0, {}), 11.0},
        {"paraboloid", SurfaceShape::Asphere(1.0 / 15.0, -1.0, {}), 30.0},
        {"hyperboloid", SurfaceShape::Asphere(-1.0 / 15.0, -2.4, {}), 40.0},
        {"asphere", SurfaceShape::Asphere(1.0 / 40.0, 0.0, {-2.3e-6, -2.1e-10, 2.7e-13}), 20.0},
        {"steep asphere", SurfaceShape::Asphere(1.0 / 18.0, -0.6, {6e-6, -2e-8, 3e-11}), 17.0},
        {"flat asphere", SurfaceShape::Asphere(0.0, 0.0, {1e-5, 2e-8}), 15.0},
        // Its slope turns at 0.74 of the rim, and the sag falls again.
        {"gull wing", SurfaceShape::Asphere(1.0 / 25.0, 0.0, {-1.6e-4, 1e-7}), 14.0},
        {"cylinder x", SurfaceShape::CylinderX(1.0 / 25.0), 24.0},
        {"cylinder y", SurfaceShape::CylinderY(-1.0 / 60.0), 20.0},
        {"toroid", SurfaceShape::Toroid(1.0 / 25.0, 1.0 / 60.0), 24.0},
        {"saddle", SurfaceShape::Toroid(1.0 / 50.0, -1.0 / 30.0), 25.0},
        {"nearly a sphere", SurfaceShape::Toroid(1.0 / 25.0, 1.0 / 25.0001), 20.0},
        {"nearly a cylinder", SurfaceShape::Toroid(1.0 / 25.0, 1e-9), 20.0},
    };
}

testing::ScalarShape Scalar(const SurfaceShape& from) {
    testing::ScalarShape to;
    const SurfaceForm form = from.form();
    if (form == SurfaceForm::kCylinderX || form == SurfaceForm::kCylinderY) {
        to.cylinder = form == SurfaceForm::kCylinderX ? 0 : 1;
        to.radius = 1 / Real(to.cylinder == 0 ? from.curvature_x() : from.curvature_y());
    } else if (from.flat()) {
        to.radius = 0;
    } else if (form == SurfaceForm::kQuadric && from.conic() == 0.0) {
        to.radius = 1 / Real(from.curvature_x());
    } else {
        to.by_sag = true;
        to.cx = from.curvature_x();
        to.cy = from.curvature_y();
        to.conic = from.conic();
        to.even.assign(from.coefficients().begin(), from.coefficients().end());
    }
    return to;
}

Real3 ToReal(const Vec3d& v) {
    return {v.x, v.y, v.z};
}

// A line through a random point near the surface, in any direction whatever, its origin before or
// behind the point.
struct Line {
    Vec3d origin, direction;
};
Line RandomLine(Random& random, const Case& c) {
    const double r = c.semi * 1.1 * std::sqrt(random.Uniform(0.0, 1.0));
    const double angle = random.Uniform(0.0, 6.2831853);
    const double spread = random.Below(3) == 0 ? 1.0 : 0.5;
    const Vec3d through(r * std::cos(angle), r * std::sin(angle),
                        random.Uniform(-0.6, 0.6) * c.semi);
    const double z = random.Uniform(-1.0, 1.0);
    Vec3d direction(random.Uniform(-spread, spread), random.Uniform(-spread, spread), z);
    direction.normalize();
    return {through - direction * random.Uniform(-100.0, 100.0), direction};
}

void ExpectSound(const SurfaceHit& hit, const std::string& name) {
    if (!hit.met) return;
    EXPECT_TRUE(std::isfinite(hit.distance)) << name;
    EXPECT_TRUE(std::isfinite(hit.point.x + hit.point.y + hit.point.z)) << name;
    EXPECT_TRUE(std::isfinite(hit.normal.x + hit.normal.y + hit.normal.z)) << name;
    EXPECT_TRUE(std::isfinite(hit.cosine)) << name;
}

TEST(SurfaceHit, IsWhereBisectionFindsIt) {
    Random random(11);
    for (const Case& c : Cases()) {
        const testing::ScalarShape scalar = Scalar(c.shape);
        int met = 0, missed = 0, backward = 0, several = 0;
        double worst = 0.0;
        for (int k = 0; k < 800; ++k) {
            const Line line = RandomLine(random, c);
            const bool forward = k % 2 == 0;
            const SurfaceHit got =
                MeetSurface(c.shape, c.semi, forward, line.origin, line.direction);
            ExpectSound(got, c.name);
            const Real3 p = ToReal(line.origin), d = testing::Unit(ToReal(line.direction));
            const ScalarHit want = testing::MeetShape(scalar, c.semi, p, d, forward);
            // Beyond the clear aperture a surface given by its sag may be met or not.
            const double bound = std::min(1.2 * c.semi, 0.999 * c.shape.reach_mm());
            const auto inside = [&](double x, double y) {
                return !scalar.by_sag || std::hypot(x, y) < bound;
            };
            const bool got_inside = got.met && inside(got.point.x, got.point.y);
            const bool want_inside = want.met && inside(static_cast<double>(want.point.x),
                                                        static_cast<double>(want.point.y));
            // A graze within rounding is met or not.
            if (want.met && std::abs(want.cosine) < 1e-6L) continue;
            ASSERT_EQ(got_inside, want_inside)
                << c.name << " line " << k << " cosine " << static_cast<double>(want.cosine)
                << " of " << want.crossings << " got " << got.met << " at "
                << std::hypot(got.point.x, got.point.y);
            if (!want_inside) {
                ++missed;
                continue;
            }
            ++met;
            backward += forward ? 0 : 1;
            if (want.crossings > 1) {
                ++several;
                // One of them, on the surface and crossed the right way.
                EXPECT_NEAR(got.point.z, c.shape.Sag(got.point.x, got.point.y), 1e-11) << c.name;
                EXPECT_EQ(got.cosine > 0.0, forward) << c.name;
                continue;
            }
            // An error of the place along the surface grows as the graze, and with the distance of
            // hits kilometres beyond the rim.
            const double size = 1.0 + got.point.length() / 100.0;
            const double graze = std::abs(static_cast<double>(want.cosine)) / size;
            const double error = static_cast<double>(std::sqrt(
                testing::Dot(ToReal(got.point) - want.point, ToReal(got.point) - want.point)));
            worst = std::max(worst, error * graze);
            ASSERT_LT(error * graze, 2e-13) << c.name << " line " << k;
            EXPECT_NEAR(got.distance, static_cast<double>(want.t), 3e-13 / graze) << c.name;
            EXPECT_NEAR(got.cosine, static_cast<double>(want.cosine), 1e-12 / graze) << c.name;
            EXPECT_NEAR(got.normal.x, static_cast<double>(want.normal.x), 1e-12 / graze) << c.name;
            EXPECT_NEAR(got.normal.y, static_cast<double>(want.normal.y), 1e-12 / graze) << c.name;
            EXPECT_NEAR(got.normal.z, static_cast<double>(want.normal.z), 1e-12 / graze) << c.name;
        }
        EXPECT_GT(met, 60) << c.name;
        EXPECT_GT(missed, 60) << c.name;
        EXPECT_GT(backward, 30) << c.name;
        RecordProperty(c.name + " worst_mm", ::testing::PrintToString(worst));
        RecordProperty(c.name + " several", several);
    }
}

// Light from beyond 90 degrees: d_z < 0 and yet from the front to the back of the surface's flank.
TEST(SurfaceHit, IsFoundForLightFromBehindTheVertexPlane) {
    const double deg = 0.017453292519943295;
    for (const Case& c : Cases()) {
        if (c.shape.curvature_x() <= 1e-3) continue;  // it must bulge towards the light
        const double r = 0.9 * c.semi;
        const Vec3d point(-r, 0.0, c.shape.Sag(-r, 0.0));
        const Vec2d slope = c.shape.Slope(-r, 0.0);
        const double flank = std::atan(-slope.x);
        if (flank < 0.1) continue;
        for (const double beyond : {0.2 * flank, 0.7 * flank}) {
            const Vec3d direction(std::cos(beyond), 0.0, -std::sin(beyond));
            const SurfaceHit hit =
                MeetSurface(c.shape, c.semi, true, point - direction * 50.0, direction);
            ASSERT_TRUE(hit.met) << c.name << " " << beyond / deg;
            EXPECT_NEAR((hit.point - point).length(), 0.0, 1e-11) << c.name;
            EXPECT_GT(hit.cosine, 0.0) << c.name;
            EXPECT_LT(direction.z, 0.0);
        }
    }
}

TEST(SurfaceHit, MissesWhatItPasses) {
    const Vec3d along(0.0, 0.0, 1.0), across(1.0, 0.0, 0.0);
    for (const Case& c : Cases()) {
        const double reach = c.shape.reach_mm();
        if (std::isfinite(reach)) {
            // Along the axis, outside the equator of both sections.
            const double far =
                1.001 /
                    std::min(std::abs(c.shape.curvature_x()) > 0.0 ? std::abs(c.shape.curvature_x())
                                                                   : 1e9,
                             std::abs(c.shape.curvature_y()) > 0.0 ? std::abs(c.shape.curvature_y())
                                                                   : 1e9) +
                reach;
            for (const bool forward : {true, false}) {
                EXPECT_FALSE(
                    MeetSurface(c.shape, c.semi, forward, Vec3d(far, far, -9.0), along).met)
                    << c.name;
            }
        }
        // Across, in front of all of it.
        if (c.shape.curvature_x() > 0.0 && c.shape.form() != SurfaceForm::kAsphere) {
            EXPECT_FALSE(MeetSurface(c.shape, c.semi, true, Vec3d(-50.0, 0.0, -1.0), across).met)
                << c.name;
        }
        // The wrong way.
        EXPECT_FALSE(MeetSurface(c.shape, c.semi, false, Vec3d(1.0, 0.5, -20.0), along).met)
            << c.name;
        EXPECT_FALSE(MeetSurface(c.shape, c.semi, true, Vec3d(1.0, 0.5, 20.0), -along).met)
            << c.name;
    }
}

// Beyond the equator a sphere bends back: a forward ray that would meet only that half misses.
TEST(SurfaceHit, NeverLiesBeyondTheEquator) {
    Random random(5);
    for (const Case& c : Cases()) {
        for (int k = 0; k < 5000; ++k) {
            const Line line = RandomLine(random, c);
            const SurfaceHit hit =
                MeetSurface(c.shape, c.semi, k % 2 == 0, line.origin, line.direction);
            if (!hit.met) continue;
            EXPECT_GT(hit.normal.z, 0.0) << c.name;
            EXPECT_NEAR(hit.normal.length(), 1.0, 1e-12) << c.name;
            EXPECT_NEAR(hit.normal.dot(line.direction), hit.cosine, 1e-9) << c.name;
        }
    }
}

// A line that touches the surface: a little nearer it is met at a small angle, a little further
// not.
TEST(SurfaceHit, OfATangentIsOnTheSurfaceOrNone) {
    for (const Case& c : Cases()) {
        if (!(c.shape.curvature_x() > 1e-3)) continue;
        for (const double share : {0.3, 0.6, 0.9}) {
            const double r = share * c.semi;
            const Vec2d slope = c.shape.Slope(-r, 0.0);
            const double bend = (c.shape.Slope(-r + 1e-4, 0.0).x - slope.x) / 1e-4;
            if (!(bend > 1e-3)) continue;  // the line is to lie in front on both sides
            const Vec3d tangent = Vec3d(1.0, 0.0, slope.x).normalized();
            const Vec3d normal = Vec3d(-slope.x, 0.0, 1.0).normalized();
            const Vec3d touch(-r, 0.0, c.shape.Sag(-r, 0.0));
            for (const double depth : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10}) {
                // Into the glass by `depth`: met forward, at a cosine of about sqrt(2 depth bend).
                const Vec3d origin = touch + normal * depth - tangent * 30.0;
                const SurfaceHit hit = MeetSurface(c.shape, c.semi, true, origin, tangent);
                ASSERT_TRUE(hit.met) << c.name << " " << share << " " << depth;
                EXPECT_NEAR(hit.point.z, c.shape.Sag(hit.point.x, hit.point.y), 1e-12) << c.name;
                EXPECT_GT(hit.cosine, 0.0) << c.name;
                if (depth < 1e-3) {
                    const double cosine =
                        std::sqrt(2.0 * depth * bend / std::pow(1.0 + slope.x * slope.x, 1.5));
                    EXPECT_NEAR(hit.cosine / cosine, 1.0, 0.2) << c.name << " " << depth;
                }
                // And as far above it: not met there.
                const SurfaceHit none = MeetSurface(
                    c.shape, c.semi, true, touch - normal * depth - tangent * 30.0, tangent);
                if (none.met) {
                    EXPECT_GT((none.point - touch).length(), 1.0) << c.name << " " << depth;
                }
            }
            const SurfaceHit exact =
                MeetSurface(c.shape, c.semi, true, touch - tangent * 30.0, tangent);
            ExpectSound(exact, c.name);
        }
    }
}

// What is promised where a line meets a surface several times in the asked direction: one of these
// places, and the one nearest to the conic's where there is but one near it.
TEST(SurfaceHit, OfAGullWingIsOneOfItsCrossings) {
    const Case c = {"gull wing", SurfaceShape::Asphere(1.0 / 25.0, 0.0, {-1.6e-4, 1e-7}), 14.0};
    const testing::ScalarShape scalar = Scalar(c.shape);
    // Almost across, through both of the wings: enters, leaves and enters again.
    const double top = c.shape.Sag(7.5, 0.0);
    int several = 0;
    for (int k = 0; k < 200; ++k) {
        const double height = 0.2 + 0.6 * k / 200.0;
        const Vec3d direction = Vec3d(1.0, 0.0, 0.02).normalized();
        const Vec3d origin(-40.0, 0.1, top * height - 0.8);
        const SurfaceHit hit = MeetSurface(c.shape, c.semi, true, origin, direction);
        const std::vector<Real> all =
            testing::SagCrossings(scalar, 1.25L * Real(c.semi), ToReal(origin),
                                  testing::Unit(ToReal(direction)), true)
                .Find();
        ASSERT_EQ(hit.met, !all.empty()) << k;
        if (!hit.met) continue;
        several += all.size() > 1 ? 1 : 0;
        double nearest = 1e300;
        for (const Real t : all) {
            nearest = std::min(nearest, std::abs(hit.distance - static_cast<double>(t)));
        }
        EXPECT_LT(nearest, 1e-10) << k;
    }
    EXPECT_GT(several, 20);
}

TEST(SurfaceHit, KeepsItsDigitsOnWeakSurfacesAndFarOrigins) {
    const Vec3d direction = Vec3d(0.2, -0.1, 1.0).normalized();
    for (const double radius : {1e7, -1e7, 1e9, 1e12}) {
        for (const SurfaceShape& shape :
             {SurfaceShape::Sphere(1.0 / radius), SurfaceShape::Asphere(1.0 / radius, 5.0, {}),
              SurfaceShape::Asphere(1.0 / radius, 0.0, {1e-300}),
              SurfaceShape::CylinderX(1.0 / radius), SurfaceShape::CylinderY(1.0 / radius),
              SurfaceShape::Toroid(1.0 / radius, 1.01 / radius)}) {
            const SurfaceHit hit =
                MeetSurface(shape, 40.0, true, Vec3d(3.0, 7.0, -30.0), direction);
            ASSERT_TRUE(hit.met) << radius;
            const Vec3d& p = hit.point;
            const double sag =
                0.5 * (shape.curvature_x() * p.x * p.x + shape.curvature_y() * p.y * p.y);
            EXPECT_NEAR(p.z, sag, 1e-13) << radius;
            EXPECT_NEAR(p.x, 3.0 + 0.2 * (p.z + 30.0), 1e-13) << radius;
        }
    }
    // A thousand kilometres away: the line is known to 1e-7 mm, the place on it to 1e-13.
    for (const Case& c : Cases()) {
        const Vec3d aim(0.3 * c.semi, -0.2 * c.semi, 0.0);
        const Vec3d origin = aim - direction * 1e9;
        const SurfaceHit hit = MeetSurface(c.shape, c.semi, true, origin, direction);
        ASSERT_TRUE(hit.met) << c.name;
        EXPECT_NEAR(hit.point.z, c.shape.Sag(hit.point.x, hit.point.y), 1e-12) << c.name;
    }
}

TEST(SurfaceHit, IsNeverMetWithANaN) {
    Random random(2);
    std::vector<Case> cases = Cases();
    for (const double c : {1e-300, 1e-30, 1e6, -1e6}) {
        cases.push_back({"extreme sphere", SurfaceShape::Sphere(c), 1e-7});
        cases.push_back({"extreme conic", SurfaceShape::Asphere(c, 1e6, {}), 1e-9});
        cases.push_back({"extreme hyperboloid", SurfaceShape::Asphere(c, -1e6, {}), 1.0});
        cases.push_back({"extreme asphere", SurfaceShape::Asphere(c, -1.0, {1e300, -1e300}), 1.0});
        cases.push_back({"extreme cylinder", SurfaceShape::CylinderY(c), 1e-7});
        cases.push_back({"extreme toroid", SurfaceShape::Toroid(c, -1e3), 1e-7});
    }
    const double most = std::numeric_limits<double>::max();
    const double least = std::numeric_limits<double>::denorm_min();
    const double sizes[] = {0.0,
                            least,
                            1e-300,
                            1e-9,
                            1.0,
                            1e9,
                            1e154,
                            1e300,
                            most,
                            std::numeric_limits<double>::infinity(),
                            std::numeric_limits<double>::quiet_NaN()};
    for (const Case& c : cases) {
        for (int k = 0; k < 3000; ++k) {
            const auto coordinate = [&] {
                return sizes[random.Below(11)] * random.Uniform(-1.0, 1.0);
            };
            const Vec3d origin(coordinate(), coordinate(), coordinate());
            Vec3d direction(random.Uniform(-1.0, 1.0), random.Uniform(-1.0, 1.0),
                            random.Uniform(-1.0, 1.0));
            if (k % 5 == 0) direction = Vec3d(0.0, 0.0, k % 2 == 0 ? 1.0 : -1.0);
            if (k % 7 == 0) direction = Vec3d(0.0, k % 2 == 0 ? 1.0 : -1.0, 0.0);
            if (k % 11 == 0) direction = Vec3d(1.0, 0.0, least);
            direction.normalize();
            ExpectSound(MeetSurface(c.shape, c.semi, k % 2 == 0, origin, direction), c.name);
        }
    }
}

}  // namespace
}  // namespace flare
