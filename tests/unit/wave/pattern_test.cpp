// SPDX-License-Identifier: Apache-2.0
//
// The pattern's middle and outskirts against closed forms: Airy's pattern for discs and, for
// polygons, the exact transform by their corners averaged over many points.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "core/base/units.h"
#include "core/wave/far_pattern.h"
#include "core/wave/near_pattern.h"

namespace flare {
namespace {

EdgeLoop Circle(double radius, Vec2d centre = {0.0, 0.0}) {
    EdgeLoop loop;
    loop.smooth = true;
    EdgePiece& piece = loop.pieces.emplace_back();
    for (int i = 0; i <= 720; ++i) {
        const double angle = 2.0 * kPi * (i % 720) / 720;
        piece.push_back(centre + Vec2d(std::cos(angle), std::sin(angle)) * radius);
    }
    return loop;
}

std::vector<Vec2d> Corners(int count, double radius, double turn) {
    std::vector<Vec2d> corners;
    for (int i = 0; i < count; ++i) {
        const double angle = turn + 2.0 * kPi * i / count;
        corners.push_back(Vec2d(std::cos(angle), std::sin(angle)) * radius);
    }
    return corners;
}

EdgeLoop Polygon(const std::vector<Vec2d>& corners) {
    EdgeLoop loop;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        loop.pieces.push_back({corners[i], corners[(i + 1) % corners.size()]});
    }
    return loop;
}

double Area(const std::vector<Vec2d>& corners) {
    double twice = 0.0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec2d a = corners[i], b = corners[(i + 1) % corners.size()];
        twice += a.x * b.y - a.y * b.x;
    }
    return 0.5 * twice;
}

// |F(k)|^2 / area of a polygon: side after side by the divergence theorem.
double Exact(const std::vector<Vec2d>& corners, Vec2d k) {
    std::complex<double> sum = 0.0;
    const double k2 = k.dot(k);
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec2d a = corners[i], b = corners[(i + 1) % corners.size()];
        const Vec2d side = b - a;
        const double x = kPi * side.dot(k);
        const double sinc = x == 0.0 ? 1.0 : std::sin(x) / x;
        sum += (k.x * side.y - k.y * side.x) * sinc * std::polar(1.0, -kPi * (a + b).dot(k));
    }
    return std::norm(sum / (2.0 * kPi * k2)) / Area(corners);
}

// The mean of f over a rectangle about `place`.
template <class Function>
double Mean(Vec2d place, double half_x, double half_y, int steps, const Function& f) {
    double sum = 0.0;
    for (int j = 0; j < steps; ++j) {
        for (int i = 0; i < steps; ++i) {
            sum += f(place + Vec2d(half_x * ((2.0 * i + 1.0) / steps - 1.0),
                                   half_y * ((2.0 * j + 1.0) / steps - 1.0)));
        }
    }
    return sum / (steps * steps);
}

double Inside(const NearPattern& pattern, double x0, double x1, double y0, double y1) {
    const auto a = pattern.LineAt(x0), b = pattern.LineAt(x1);
    const auto c = pattern.LineAt(y0), d = pattern.LineAt(y1);
    return pattern.Below(b, d) - pattern.Below(a, d) - pattern.Below(b, c) + pattern.Below(a, c);
}

TEST(NearPattern, OfADiscIsAirysPattern) {
    ThreadPool threads(1);
    const NearPattern pattern({{Circle(0.5, {3.0, -2.0})}}, 1024, false, threads);
    EXPECT_NEAR(pattern.limit(), 38.4, 0.1);
    EXPECT_NEAR(pattern.core_share(), 0.83778, 0.002);
    // Peak, zero and rings, in squares of 0.04 / D, a third of a sample wide.
    const double area = kPi / 4.0;
    for (const double k : {0.0, 0.3, 0.7, 1.0, 1.2197, 1.64, 2.233, 3.1, 6.3}) {
        const double expected = Mean({k, 0.0}, 0.02, 0.02, 8, [&](Vec2d p) {
            const double x = kPi * p.length();
            return area * std::pow(2.0 * std::cyl_bessel_j(1.0, x) / x, 2);
        });
        EXPECT_NEAR(Inside(pattern, k - 0.02, k + 0.02, -0.02, 0.02) / 0.0016, expected,
                    2e-4 * area + 0.005 * expected)
            << k;
    }
}

TEST(NearPattern, WithoutItsCoreHasAllLightButTheCoreShare) {
    ThreadPool threads(1);
    const NearPattern whole({{Polygon(Corners(6, 0.5, 0.3))}}, 512, false, threads);
    const NearPattern rest({{Polygon(Corners(6, 0.5, 0.3))}}, 512, true, threads);
    const double all = Inside(whole, -30.0, 30.0, -30.0, 30.0);
    EXPECT_NEAR(all, 1.0, 0.01);
    EXPECT_NEAR(Inside(rest, -30.0, 30.0, -30.0, 30.0), all - whole.core_share(), 1e-9);
    EXPECT_NEAR(Inside(rest, -0.3, 0.3, -0.3, 0.3), 0.0, 1e-9);
}

TEST(FarPattern, OfADiscIsTheMeanOfAirysRings) {
    const FarPattern far({{Circle(0.5)}}, {{0.25, Vec3d(2.0, 1.0, 0.0)}}, {}, 16.0, 500.0);
    for (const double radius : {16.0, 77.0, 400.0}) {
        // J1^2 is 1 / (pi x) on average: area (2 J1 / x)^2 with x = pi k.
        const double x = kPi * radius / 0.25;
        const double expected = kPi / 4.0 * 4.0 / (kPi * x * x * x) / (0.25 * 0.25);
        for (const double angle : {0.0, 0.1, 2.0, 4.4}) {
            const Vec3d light = far.At(Vec2d(std::cos(angle), std::sin(angle)) * radius);
            EXPECT_NEAR(light.x, 2.0 * expected, 0.02 * expected);
            EXPECT_NEAR(light.y, expected, 0.01 * expected);
            EXPECT_EQ(light.z, 0.0);
        }
    }
}

// Spikes, the haze between them, and the shoulders, against the exact transform.
TEST(FarPattern, OfAHexagonIsTheMeanOfItsExactTransform) {
    constexpr double kWavelength = 0.25;
    const double turn = 0.2;
    for (const int count : {6, 7, 3}) {
        const std::vector<Vec2d> corners = Corners(count, 0.5, turn);
        const FarPattern far({{Polygon(corners)}}, {{kWavelength, Vec3d(1.0, 0.0, 0.0)}}, {}, 16.0,
                             500.0);
        const auto exact = [&](Vec2d place) {
            return Exact(corners, place / kWavelength) / (kWavelength * kWavelength);
        };
        const auto mean = [&](Vec2d place) { return far.At(place).x; };
        const double spike = turn + kPi / count;
        for (const double radius : {20.0, 130.0}) {
            // Haze: off the spikes, over 6 x 6 pixels.
            for (const double off : {0.5, 0.3, 0.15}) {
                const double angle = spike + off * 2.0 * kPi / count;
                const Vec2d place = Vec2d(std::cos(angle), std::sin(angle)) * radius;
                const double expected = Mean(place, 3.0, 3.0, 150, exact);
                EXPECT_NEAR(Mean(place, 3.0, 3.0, 12, mean), expected, 0.05 * expected)
                    << count << " blades, haze at " << radius << ", " << off;
            }
            // A spike: over 12 x 12 pixels that hold it.
            const Vec2d place = Vec2d(std::cos(spike), std::sin(spike)) * radius;
            const double expected = Mean(place, 6.0, 6.0, 300, exact);
            EXPECT_NEAR(Mean(place, 6.0, 6.0, 96, mean), expected, 0.03 * expected)
                << count << " blades, spike at " << radius;
        }
    }
}

TEST(FarPattern, CountsSpikes) {
    for (const auto& [blades, spikes] : {std::pair{6, 6}, {7, 14}, {5, 10}, {8, 8}}) {
        const FarPattern far({{Polygon(Corners(blades, 0.5, 0.123))}},
                             {{0.1, Vec3d(1.0, 0.0, 0.0)}}, {}, 16.0, 500.0);
        // Maxima around a circle that stand out from their surroundings.
        constexpr int kSteps = 7200;
        std::vector<double> ring;
        for (int i = 0; i < kSteps; ++i) {
            const double angle = 2.0 * kPi * i / kSteps;
            ring.push_back(far.At(Vec2d(std::cos(angle), std::sin(angle)) * 200.0).x);
        }
        double mean = 0.0;
        for (const double value : ring) mean += value / kSteps;
        int found = 0;
        for (int i = 0; i < kSteps; ++i) {
            const double value = ring[static_cast<std::size_t>(i)];
            const bool high = value > 5.0 * mean;
            const bool before =
                ring[static_cast<std::size_t>((i + kSteps - 1) % kSteps)] > 5.0 * mean;
            found += high && !before ? 1 : 0;
        }
        EXPECT_EQ(found, spikes);
    }
}

// The two halves of the pattern meet.
TEST(FarPattern, ContinuesTheNearOne) {
    ThreadPool threads(1);
    constexpr double kWavelength = 0.25;
    // A cat's eye: two arcs that meet in corners.
    EdgeLoop lens;
    for (const double side : {1.0, -1.0}) {
        EdgePiece& piece = lens.pieces.emplace_back();
        for (int i = 0; i <= 200; ++i) {
            const double angle = (-0.9 + 1.8 * i / 200.0) + (side > 0.0 ? 0.0 : kPi);
            piece.push_back(
                Vec2d(0.5 * std::cos(angle) - side * 0.5 * std::cos(0.9), 0.5 * std::sin(angle)));
        }
    }
    lens.pieces[1].front() = lens.pieces[0].back();
    lens.pieces[1].back() = lens.pieces[0].front();
    for (const EdgeLoop& loop : {Polygon(Corners(6, 0.5, 0.2)), Circle(0.5), lens}) {
        const NearPattern near({{loop}}, 1024, false, threads);
        const FarPattern far({{loop}}, {{kWavelength, Vec3d(1.0, 0.0, 0.0)}}, {}, 5.0, 40.0);
        double near_light = 0.0, far_light = 0.0, difference = 0.0;
        for (int j = -12; j < 12; j += 2) {
            for (int i = -12; i < 12; i += 2) {
                const double radius = std::hypot(i + 1.0, j + 1.0);
                if (radius < 5.5 || radius > 9.0) continue;
                const double a = Inside(near, i / kWavelength, (i + 2) / kWavelength,
                                        j / kWavelength, (j + 2) / kWavelength);
                const double b =
                    Mean({i + 1.0, j + 1.0}, 1.0, 1.0, 16, [&](Vec2d p) { return far.At(p).x; }) *
                    4.0;
                near_light += a;
                far_light += b;
                difference += std::abs(a - b);
            }
        }
        EXPECT_NEAR(far_light, near_light, 0.05 * near_light);
        EXPECT_LT(difference, 0.15 * near_light);
    }
}

// A disc as source: as many points.
TEST(FarPattern, OfAnEllipseIsThatOfManyPoints) {
    const ApertureOutline hexagon = {Polygon(Corners(6, 0.5, 0.2))};
    const std::vector<PatternBand> bands = {{0.25, Vec3d(1.0, 0.0, 0.0)}};
    const SourceEllipse source{{9.0, 2.0}, {-1.0, 5.0}};
    const FarPattern point({hexagon}, bands, {}, 16.0, 500.0);
    const FarPattern disc({hexagon}, bands, source, 16.0, 500.0);
    const double spike = 0.2 + kPi / 6.0;
    for (const double off : {0.0, 0.03, 0.06, 0.5}) {
        const Vec2d place = Vec2d(std::cos(spike + off), std::sin(spike + off)) * 120.0;
        double sum = 0.0;
        int count = 0;
        for (int j = -100; j <= 100; ++j) {
            for (int i = -100; i <= 100; ++i) {
                if (i * i + j * j > 100 * 100) continue;
                sum += point.At(place + source.a * (i / 100.0) + source.b * (j / 100.0)).x;
                ++count;
            }
        }
        EXPECT_NEAR(disc.At(place).x, sum / count, 0.05 * sum / count) << off;
    }
}

}  // namespace
}  // namespace flare
