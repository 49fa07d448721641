// SPDX-License-Identifier: Apache-2.0
#include "core/optics/surface_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/scalar_surface.h"

namespace flare {
namespace {

using testing::Random;

struct Named {
    std::string name;
    SurfaceShape shape;
    double reach_mm;  // by hand
};

std::vector<Named> Shapes() {
    const double infinite = std::numeric_limits<double>::infinity();
    return {
        {"plane", SurfaceShape(), infinite},
        {"sphere", SurfaceShape::Sphere(1.0 / 20.0), 20.0},
        {"sphere, hollow", SurfaceShape::Sphere(-1.0 / 35.0), 35.0},
        {"ellipsoid", SurfaceShape::Asphere(1.0 / 20.0, -0.75, {}), 40.0},
        {"oblate", SurfaceShape::Asphere(-1.0 / 20.0, 3.0, {}), 10.0},
        {"paraboloid", SurfaceShape::Asphere(1.0 / 20.0, -1.0, {}), infinite},
        {"hyperboloid", SurfaceShape::Asphere(-1.0 / 20.0, -4.0, {}), infinite},
        {"asphere", SurfaceShape::Asphere(1.0 / 40.0, -0.2, {-2e-6, 3e-9, -4e-12, 5e-16}),
         40.0 / std::sqrt(0.8)},
        {"flat asphere", SurfaceShape::Asphere(0.0, 7.0, {1e-5, -2e-8}), infinite},
        {"cylinder x", SurfaceShape::CylinderX(1.0 / 25.0), 25.0},
        {"cylinder y", SurfaceShape::CylinderY(-1.0 / 30.0), 30.0},
        {"toroid", SurfaceShape::Toroid(1.0 / 25.0, 1.0 / 60.0), 25.0},
        {"saddle", SurfaceShape::Toroid(1.0 / 50.0, -1.0 / 30.0), 30.0},
        {"toroid, flat in x", SurfaceShape::Toroid(0.0, 1.0 / 30.0), 30.0},
    };
}

double Reach(const Named& named) {
    return std::min(named.reach_mm, 30.0);
}

TEST(SurfaceShape, HasTheSagOfItsTextbook) {
    const auto sag = [](const SurfaceShape& shape, double x, double y) { return shape.Sag(x, y); };
    // Circles by Pythagoras.
    EXPECT_NEAR(sag(SurfaceShape::Sphere(0.05), 6.0, -8.0), 20.0 - std::sqrt(300.0), 1e-14);
    EXPECT_NEAR(sag(SurfaceShape::Sphere(-0.05), 6.0, -8.0), std::sqrt(300.0) - 20.0, 1e-14);
    EXPECT_NEAR(sag(SurfaceShape::CylinderX(0.05), 10.0, -8.0), 20.0 - std::sqrt(300.0), 1e-14);
    EXPECT_NEAR(sag(SurfaceShape::CylinderY(0.05), 10.0, -10.0), 20.0 - std::sqrt(300.0), 1e-14);
    // A parabola is r^2 / 2R; an ellipse of half axes a (along z) and b has R = b^2 / a and
    // k = b^2 / a^2 - 1; a hyperbola likewise with k = -1 - b^2 / a^2.
    EXPECT_NEAR(sag(SurfaceShape::Asphere(0.05, -1.0, {}), 6.0, 8.0), 2.5, 1e-14);
    const double a = 30.0, b = 18.0;
    EXPECT_NEAR(sag(SurfaceShape::Asphere(a / (b * b), b * b / (a * a) - 1.0, {}), 9.0, 12.0),
                a - a * std::sqrt(1.0 - 225.0 / (b * b)), 1e-13);
    EXPECT_NEAR(sag(SurfaceShape::Asphere(a / (b * b), -1.0 - b * b / (a * a), {}), 9.0, 12.0),
                a * std::sqrt(1.0 + 225.0 / (b * b)) - a, 1e-13);
    // a4 ... a18 one by one.
    for (std::size_t i = 0; i < SurfaceShape::kMostCoefficients; ++i) {
        std::vector<double> even(i + 1, 0.0);
        even[i] = 0.3;
        EXPECT_NEAR(sag(SurfaceShape::Asphere(0.0, 0.0, even), 0.6, 0.8), 0.3, 1e-15) << i;
        EXPECT_NEAR(sag(SurfaceShape::Asphere(0.0, 0.0, even), 0.0, 0.5),
                    0.3 * std::pow(0.5, 2.0 * static_cast<double>(i) + 4.0), 1e-17)
            << i;
    }
    // A toroid is a circle in each of its planes.
    const SurfaceShape toroid = SurfaceShape::Toroid(1.0 / 25.0, -1.0 / 40.0);
    for (const double r : {1e-6, 1.0, 10.0, 24.0}) {
        EXPECT_NEAR(toroid.Sag(r, 0.0), SurfaceShape::Sphere(1.0 / 25.0).Sag(0.0, r), 1e-14);
        EXPECT_NEAR(toroid.Sag(0.0, r), SurfaceShape::Sphere(-1.0 / 40.0).Sag(r, 0.0), 1e-14);
    }
}

TEST(SurfaceShape, SlopesAreTheDerivativesOfTheSag) {
    Random random(3);
    for (const Named& named : Shapes()) {
        for (int k = 0; k < 200; ++k) {
            const double r = Reach(named) * 0.95 * std::sqrt(random.Uniform(0.0, 1.0));
            const double angle = random.Uniform(0.0, 6.2831853);
            const double x = r * std::cos(angle), y = r * std::sin(angle);
            const double h = 1e-4;
            const auto difference = [&](double dx, double dy) {
                return (8.0 * (named.shape.Sag(x + dx, y + dy) - named.shape.Sag(x - dx, y - dy)) -
                        (named.shape.Sag(x + 2.0 * dx, y + 2.0 * dy) -
                         named.shape.Sag(x - 2.0 * dx, y - 2.0 * dy))) /
                       (12.0 * h);
            };
            const Vec2d slope = named.shape.Slope(x, y);
            const double allowed = 1e-9 * (1.0 + slope.length());
            EXPECT_NEAR(slope.x, difference(h, 0.0), allowed) << named.name << " at " << r;
            EXPECT_NEAR(slope.y, difference(0.0, h), allowed) << named.name << " at " << r;
        }
        EXPECT_EQ(named.shape.Slope(0.0, 0.0), Vec2d(0.0, 0.0)) << named.name;
        EXPECT_EQ(named.shape.Sag(0.0, 0.0), 0.0) << named.name;
    }
}

TEST(SurfaceShape, ItsCurvaturesAreTheSecondDerivativesAtTheVertex) {
    for (const Named& named : Shapes()) {
        const double h = 1e-3;
        EXPECT_NEAR(named.shape.curvature(Section::kX), 2.0 * named.shape.Sag(h, 0.0) / (h * h),
                    1e-9)
            << named.name;
        EXPECT_NEAR(named.shape.curvature(Section::kY), 2.0 * named.shape.Sag(0.0, h) / (h * h),
                    1e-9)
            << named.name;
        EXPECT_EQ(named.shape.rotational(),
                  std::abs(named.shape.Sag(3.0, 0.0) - named.shape.Sag(0.0, 3.0)) < 1e-12)
            << named.name;
    }
}

TEST(SurfaceShape, HasASagWithinItsReachAndNoneBeyond) {
    for (const Named& named : Shapes()) {
        EXPECT_DOUBLE_EQ(named.shape.reach_mm(), named.reach_mm) << named.name;
        const double r = std::isinf(named.reach_mm) ? 1e4 : named.reach_mm * (1.0 - 1e-9);
        for (int k = 0; k < 32; ++k) {
            const double angle = 0.19634954 * k;
            const double x = r * std::cos(angle), y = r * std::sin(angle);
            EXPECT_TRUE(std::isfinite(named.shape.Sag(x, y))) << named.name << " " << angle;
            EXPECT_TRUE(std::isfinite(named.shape.Slope(x, y).length())) << named.name;
        }
        if (std::isinf(named.reach_mm)) continue;
        // In the steeper section, just beyond the equator.
        const double beyond = named.reach_mm * (1.0 + 1e-9);
        EXPECT_TRUE(std::isnan(named.shape.Sag(beyond, 0.0)) ||
                    std::isnan(named.shape.Sag(0.0, beyond)))
            << named.name;
    }
}

TEST(SurfaceShape, TheSagRangeHoldsEverySag) {
    Random random(8);
    for (const Named& named : Shapes()) {
        for (const double radius : {0.5, 7.0, 24.0, 1e3}) {
            const double within = std::min(radius, named.shape.reach_mm());
            const std::array<double, 2> range = named.shape.SagRange(radius);
            double lowest = 0.0, highest = 0.0;
            for (int k = 0; k < 4000; ++k) {
                const double r = within * std::sqrt(random.Uniform(0.0, 1.0));
                const double angle = random.Uniform(0.0, 6.2831853);
                const double sag = named.shape.Sag(r * std::cos(angle), r * std::sin(angle));
                lowest = std::min(lowest, sag);
                highest = std::max(highest, sag);
            }
            // By sampling, so a turning point may stand out a little.
            const double spare = 0.01 * (range[1] - range[0]);
            EXPECT_GE(lowest, range[0] - spare) << named.name << " " << radius;
            EXPECT_LE(highest, range[1] + spare) << named.name << " " << radius;
            // And it is no wider than it must be.
            EXPECT_LE(range[1] - range[0], 1.2 * (highest - lowest) + 1e-12)
                << named.name << " " << radius;
        }
    }
}

TEST(SurfaceShape, OneShapeHasOneForm) {
    EXPECT_EQ(SurfaceShape::Toroid(0.02, 0.02), SurfaceShape::Sphere(0.02));
    EXPECT_EQ(SurfaceShape::Toroid(0.0, 0.0), SurfaceShape());
    EXPECT_EQ(SurfaceShape::CylinderX(0.0), SurfaceShape());
    EXPECT_EQ(SurfaceShape::CylinderY(0.0), SurfaceShape());
    EXPECT_EQ(SurfaceShape::Asphere(0.02, 0.0, {}), SurfaceShape::Sphere(0.02));
    EXPECT_EQ(SurfaceShape::Asphere(0.02, 0.0, {0.0, 0.0}), SurfaceShape::Sphere(0.02));
    EXPECT_EQ(SurfaceShape::Asphere(0.0, -1.0, {}), SurfaceShape());
    EXPECT_TRUE(SurfaceShape().flat());
    EXPECT_FALSE(SurfaceShape::Asphere(0.0, 0.0, {1e-6}).flat());
    EXPECT_FALSE(SurfaceShape::CylinderX(0.02).flat());
    EXPECT_EQ(SurfaceShape::Asphere(0.02, -1.0, {}).form(), SurfaceForm::kQuadric);
    EXPECT_EQ(SurfaceShape::Asphere(0.02, -1.0, {0.0, 1e-9}).form(), SurfaceForm::kAsphere);
    EXPECT_NE(SurfaceShape::CylinderX(0.02), SurfaceShape::CylinderY(0.02));
}

}  // namespace
}  // namespace flare
