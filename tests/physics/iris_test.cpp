// SPDX-License-Identifier: Apache-2.0
//
// The iris's opening, measured from outside: by asking point after point whether it is open.
#include "core/optics/iris.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"
#include "tests/support/random.h"
#include "tests/support/stop_masks.h"

namespace flare {
namespace {

Vec2d Polar(double radius, double angle_deg) {
    const double a = RadiansFromDegrees(angle_deg);
    return {radius * std::cos(a), radius * std::sin(a)};
}

// How far the opening reaches from the centre in a direction.
double Reach(const Iris& iris, double angle_deg, double limit) {
    double lo = 0.0, hi = limit;
    for (int i = 0; i < 48; ++i) {
        const double mid = 0.5 * (lo + hi);
        (iris.Distance(Polar(mid, angle_deg)) <= 0.0 ? lo : hi) = mid;
    }
    return lo;
}

// Area over [from, from + span] degrees, midpoint rule.
double SectorArea(const Iris& iris, double from_deg, double span_deg, int steps, double limit) {
    double sum = 0.0;
    for (int i = 0; i < steps; ++i) {
        const double r = Reach(iris, from_deg + span_deg * (i + 0.5) / steps, limit);
        sum += 0.5 * r * r;
    }
    return sum * RadiansFromDegrees(span_deg) / steps;
}

TEST(IrisOpening, HasTheAreaOfTheDiscForEveryBladeCountAndRoundness) {
    const double radius = 4.34;
    for (int blades = 3; blades <= 32; ++blades) {
        for (const double roundness : {0.0, 0.2, 0.7, 1.0}) {
            const Iris iris({blades, roundness, 13.0}, radius, 100.0);
            // From a corner to the next: smooth but for the ends.
            const double span = 360.0 / blades;
            const double sector = SectorArea(iris, 90.0 + 13.0, span, 240, 100.0);
            EXPECT_NEAR(blades * sector, kPi * radius * radius, 3e-5 * kPi * radius * radius)
                << blades << " blades, roundness " << roundness;
            EXPECT_NEAR(iris.area_mm2(), kPi * radius * radius, 1e-9 * kPi * radius * radius);
        }
    }
}

TEST(IrisOpening, HasItsFirstCornerAtTheTopAndTurnsAnticlockwise) {
    for (const int blades : {3, 5, 6, 9}) {
        for (const double roundness : {0.0, 0.4}) {
            const Iris iris({blades, roundness, 0.0}, 2.0, 100.0);
            const double corner = Reach(iris, 90.0, 100.0);
            EXPECT_NEAR(corner, iris.outer_radius(), 1e-9);
            EXPECT_LT(Reach(iris, 90.0 + 180.0 / blades, 100.0), corner);
            EXPECT_NEAR(Reach(iris, 90.0 + 180.0 / blades, 100.0), iris.inner_radius(), 1e-9);
            const Iris turned({blades, roundness, 10.0}, 2.0, 100.0);
            EXPECT_NEAR(Reach(turned, 100.0, 100.0), corner, 1e-9);
            EXPECT_LT(Reach(turned, 90.0, 100.0), corner);
        }
    }
}

TEST(IrisOpening, OfStraightBladesIsTheRegularPolygon) {
    const double radius = 3.0;
    for (const int blades : {3, 4, 7, 32}) {
        const Iris iris({blades, 0.0, 0.0}, radius, 100.0);
        // Area of the regular n-gon of circumradius R: n/2 R^2 sin(2 pi / n).
        const double circumradius =
            radius * std::sqrt(kPi / (0.5 * blades * std::sin(2.0 * kPi / blades)));
        EXPECT_NEAR(iris.outer_radius(), circumradius, 1e-12);
        for (double t = 0.0; t <= 1.0; t += 0.125) {
            // Along the first side, from corner to corner.
            const Vec2d a = Polar(circumradius, 90.0),
                        b = Polar(circumradius, 90.0 + 360.0 / blades);
            const Vec2d p = a + (b - a) * t;
            EXPECT_NEAR(iris.Distance(p), 0.0, 1e-12);
            EXPECT_GT(iris.Distance(p * 1.01), 0.0);
            EXPECT_LT(iris.Distance(p * 0.99), 0.0);
        }
    }
}

TEST(IrisOpening, BulgesByItsShareOfTheCirclesSagitta) {
    for (const double roundness : {0.25, 0.5, 1.0}) {
        const int blades = 6;
        const Iris iris({blades, roundness, 0.0}, 3.0, 100.0);
        const double corner = iris.outer_radius();
        const double apothem = corner * std::cos(kPi / blades);
        EXPECT_NEAR(Reach(iris, 90.0 + 30.0, 100.0), apothem + roundness * (corner - apothem),
                    1e-9);
    }
    const Iris round({7, 1.0, 0.0}, 3.0, 100.0);
    for (double angle = 0.0; angle < 360.0; angle += 7.0) {
        EXPECT_NEAR(Reach(round, angle, 100.0), 3.0, 1e-9);
    }
    // And no blades are a disc.
    const Iris none({0, 0.0, 0.0}, 3.0, 100.0);
    for (double angle = 0.0; angle < 360.0; angle += 7.0) {
        EXPECT_NEAR(Reach(none, angle, 100.0), 3.0, 1e-9);
    }
}

TEST(IrisOpening, IsCutByTheStopsRim) {
    // A triangle whose corners stand out of the rim.
    const Iris cut({3, 0.0, 0.0}, 8.0, 8.55);
    EXPECT_NEAR(Reach(cut, 90.0, 100.0), 8.55, 1e-9);
    EXPECT_LE(cut.outer_radius(), 8.55);
    const double area = SectorArea(cut, 90.0, 360.0, 6000, 100.0);
    EXPECT_LT(area, 0.95 * kPi * 64.0);
    EXPECT_NEAR(cut.area_mm2(), area, 1e-4 * area);
    // A round iris wider than the rim is the rim.
    const Iris wide({0, 0.0, 0.0}, 20.0, 8.55);
    EXPECT_NEAR(Reach(wide, 200.0, 100.0), 8.55, 1e-9);
    EXPECT_NEAR(wide.area_mm2(), kPi * 8.55 * 8.55, 1e-9);
}

TEST(IrisOpening, OfIrregularBladesKeepsTheAreaAndItsBounds) {
    testing::Random random(4);
    for (int i = 0; i < 60; ++i) {
        IrisShape shape{random.Below(14) + 3, i % 3 == 0 ? 0.0 : random.Uniform(0.0, 1.0), 5.0};
        shape.irregularity = random.Uniform(0.05, 1.0);
        shape.seed = static_cast<std::uint64_t>(i);
        const Iris iris(shape, 4.0, 100.0);
        double sum = 0.0;
        constexpr int kSteps = 3000;
        for (int k = 0; k < kSteps; ++k) {
            const double reach = Reach(iris, 360.0 * (k + 0.5) / kSteps, 40.0);
            EXPECT_LE(reach, iris.outer_radius());
            EXPECT_GE(reach, iris.inner_radius() * (1.0 - 1e-9));
            sum += reach * reach;
        }
        EXPECT_NEAR(sum / kSteps, 16.0, 16.0 * 2e-3);
    }
}

TEST(IrisOpening, OfIrregularBladesGoesBackToTheRegularOneAndFollowsItsSeed) {
    IrisShape shape{7, 0.3, 5.0};
    const Iris regular(shape, 4.0, 100.0);
    shape.irregularity = 1e-6;
    const Iris hardly(shape, 4.0, 100.0);
    shape.irregularity = 0.8;
    const Iris irregular(shape, 4.0, 100.0);
    const Iris again(shape, 4.0, 100.0);
    shape.seed = 1;
    const Iris other(shape, 4.0, 100.0);
    double most = 0.0, most_other = 0.0;
    for (double angle = 0.0; angle < 360.0; angle += 3.0) {
        const double reach = Reach(irregular, angle, 40.0);
        EXPECT_NEAR(Reach(hardly, angle, 40.0), Reach(regular, angle, 40.0), 1e-4);
        EXPECT_EQ(Reach(again, angle, 40.0), reach);
        most = std::max(most, std::abs(reach - Reach(regular, angle, 40.0)));
        most_other = std::max(most_other, std::abs(reach - Reach(other, angle, 40.0)));
    }
    EXPECT_GT(most, 0.1);
    EXPECT_GT(most_other, 0.1);
}

TEST(IrisOpening, OfAMaskHasTheDiscsAreaOrTheRimsSize) {
    IrisShape shape;
    shape.mask = StopPicture::Sharp(testing::Drawn(160, 10.0, testing::InStar));
    const Iris star(shape, 4.0, 100.0);
    EXPECT_NEAR(star.area_mm2(), kPi * 16.0, 2e-3 * kPi * 16.0);
    EXPECT_NEAR(star.outer_radius(), 8.0 * 4.0 * std::sqrt(kPi / testing::kStarArea), 0.25);
    // Where a point of the star would stand out of the rim it is cut.
    EXPECT_EQ(Iris(shape, 4.0, 5.0).outer_radius(), 5.0);
    shape.mask_scale = MaskScale::kStop;
    shape.mask = shape.mask->Placed(1.0, 0.0);
    EXPECT_NEAR(Iris(shape, 4.0, 5.0).outer_radius(), 4.0, 1e-9);
    EXPECT_NEAR(Iris(shape, 5.0, 5.0).area_mm2(), testing::kStarArea / 4.0,
                2e-3 * testing::kStarArea);
    EXPECT_EQ(Iris(shape, 5.0, 5.0).TransmissionAt({0.0, 3.5}), 1.0);
    EXPECT_EQ(Iris(shape, 5.0, 5.0).TransmissionAt({0.0, -3.5}), 0.0);
}

TEST(IrisOpening, BoundsAreTrue) {
    testing::Random random(9);
    for (int i = 0; i < 20'000; ++i) {
        // Now and then so wide that the rim cuts it; such a one is dear to build.
        const double widest = i % 4000 == 0 ? 12.0 : 5.0;
        const IrisShape shape{random.Below(30) + 3, random.Uniform(0.0, 1.0),
                              random.Uniform(-720.0, 720.0)};
        const Iris iris(shape, random.Uniform(0.9 * widest - 4.0, widest), 8.55);
        const Vec2d p = Polar(random.Uniform(0.0, 12.0), random.Uniform(0.0, 360.0));
        const bool open = iris.Distance(p) <= 0.0;
        if (p.length() < iris.inner_radius() * (1.0 - 1e-12)) {
            EXPECT_TRUE(open);
        }
        if (p.length() > iris.outer_radius() * (1.0 + 1e-12)) {
            EXPECT_FALSE(open);
        }
    }
}

}  // namespace
}  // namespace flare
