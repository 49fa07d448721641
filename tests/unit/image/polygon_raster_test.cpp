// SPDX-License-Identifier: Apache-2.0
//
// Coverage against an independent computation: the polygon is clipped to each pixel's square and
// its area taken by the shoelace formula.
#include "core/image/polygon_raster.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "tests/support/random.h"

namespace flare {
namespace {

using Polygon = std::vector<Vec2d>;

double Area(const Polygon& p) {
    double twice = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) {
        const Vec2d &a = p[i], &b = p[(i + 1) % p.size()];
        twice += a.x * b.y - b.x * a.y;
    }
    return 0.5 * twice;
}

// Keeps what lies where sign * coordinate >= sign * bound.
Polygon Cut(const Polygon& p, int axis, double bound, double sign) {
    Polygon out;
    for (std::size_t i = 0; i < p.size(); ++i) {
        const Vec2d &a = p[i], &b = p[(i + 1) % p.size()];
        const double da = sign * (a[axis] - bound), db = sign * (b[axis] - bound);
        if (da >= 0.0) out.push_back(a);
        if ((da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0))
            out.push_back(a + (b - a) * (da / (da - db)));
    }
    return out;
}

double AreaInPixel(const Polygon& p, int x, int y) {
    Polygon q = Cut(p, 0, x, 1.0);
    if (!q.empty()) q = Cut(q, 0, x + 1, -1.0);
    if (!q.empty()) q = Cut(q, 1, y, 1.0);
    if (!q.empty()) q = Cut(q, 1, y + 1, -1.0);
    return q.size() < 3 ? 0.0 : Area(q);
}

struct Canvas {
    Canvas(int x0_, int y0_, int width_, int rows_)
        : x0(x0_),
          y0(y0_),
          width(width_),
          rows(rows_),
          pixels(static_cast<std::size_t>(width_) * static_cast<std::size_t>(rows_)) {}

    void Draw(const Polygon& p, double amount) {
        RasterTarget target;
        target.layers = {pixels.data()};
        target.x0 = x0;
        target.y0 = y0;
        target.width = width;
        target.rows = rows;
        PolygonRaster raster(target, 1);
        raster.Add(p, std::vector<double>{amount}, 0);
        raster.Flush();
    }
    double At(int x, int y) const {
        return pixels[static_cast<std::size_t>((y - y0) * width + (x - x0))];
    }
    double Sum() const {
        double sum = 0.0;
        for (const double v : pixels) sum += v;
        return sum;
    }

    int x0, y0, width, rows;
    std::vector<double> pixels;
};

Polygon RandomConvex(testing::Random& random, double size) {
    const Vec2d centre(random.Uniform(8.0, 24.0), random.Uniform(8.0, 24.0));
    const int corners = random.Below(6) + 3;
    const double start = random.Uniform(0.0, 2.0 * kPi);
    const double a = size * random.Uniform(0.05, 1.0), b = size * random.Uniform(0.05, 1.0);
    Polygon p;
    for (int i = 0; i < corners; ++i) {
        const double angle = start + 2.0 * kPi * i / corners;
        p.emplace_back(centre.x + a * std::cos(angle), centre.y + b * std::sin(angle));
    }
    if (random.Below(2) == 0) std::reverse(p.begin(), p.end());
    return p;
}

TEST(PolygonRaster, GivesEachPixelItsExactShare) {
    testing::Random random(12);
    for (int round = 0; round < 400; ++round) {
        const Polygon p = RandomConvex(random, round % 2 == 0 ? 8.0 : 1.2);
        Canvas canvas(0, 0, 32, 32);
        canvas.Draw(p, 3.0);
        EXPECT_NEAR(canvas.Sum(), 3.0, 1e-12);
        const double area = Area(p);
        for (int y = 0; y < 32; ++y) {
            for (int x = 0; x < 32; ++x) {
                ASSERT_NEAR(canvas.At(x, y), 3.0 * AreaInPixel(p, x, y) / area, 1e-11) << round;
            }
        }
    }
}

TEST(PolygonRaster, DrawsSimpleShapesAsTheyAre) {
    Canvas square(0, 0, 4, 4);
    square.Draw({{1.0, 1.0}, {3.0, 1.0}, {3.0, 3.0}, {1.0, 3.0}}, 4.0);
    for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 4; ++x) {
            const bool inside = x >= 1 && x < 3 && y >= 1 && y < 3;
            EXPECT_DOUBLE_EQ(square.At(x, y), inside ? 1.0 : 0.0);
        }
    }
    Canvas half(0, 0, 1, 1);
    half.Draw({{0.5, -1.0}, {1.5, -1.0}, {1.5, 2.0}, {0.5, 2.0}}, 3.0);  // a sixth of it is inside
    EXPECT_DOUBLE_EQ(half.At(0, 0), 0.5);
    // A polygon that is not convex.
    Canvas arrow(0, 0, 4, 4);
    const Polygon p{{0.0, 0.0}, {4.0, 2.0}, {0.0, 4.0}, {1.5, 2.0}};
    arrow.Draw(p, 1.0);
    EXPECT_NEAR(arrow.Sum(), 1.0, 1e-14);
    EXPECT_NEAR(arrow.At(0, 2) + arrow.At(0, 1) + arrow.At(0, 0) + arrow.At(0, 3),
                (AreaInPixel(p, 0, 0) + AreaInPixel(p, 0, 1) + AreaInPixel(p, 0, 2) +
                 AreaInPixel(p, 0, 3)) /
                    Area(p),
                1e-13);
}

TEST(PolygonRaster, LosesNoLightOfSliversAndPoints) {
    for (const Polygon& p :
         {Polygon{{3.0, 3.0}, {9.0, 6.0}, {3.0, 3.0}}, Polygon{{2.5, 2.5}, {2.5, 2.5}, {2.5, 2.5}},
          Polygon{{1.0, 4.0}, {9.0, 4.0}, {5.0, 4.0}}, Polygon{{4.0, 1.0}, {4.0, 9.0}, {4.0, 5.0}},
          Polygon{{2.0, 2.0}, {8.0, 2.0}, {8.0, 2.0 + 1e-13}, {2.0, 2.0 + 1e-13}},
          Polygon{{2.3, 2.3}, {2.3 + 1e-9, 2.3}, {2.3, 2.3 + 1e-9}}}) {
        Canvas canvas(0, 0, 12, 12);
        canvas.Draw(p, 2.0);
        EXPECT_NEAR(canvas.Sum(), 2.0, 1e-9);
        for (const double v : canvas.pixels) {
            EXPECT_TRUE(std::isfinite(v));
            EXPECT_GE(v, -1e-12);
        }
    }
    // A thin one along a row is spread along it, not put on one pixel.
    Canvas canvas(0, 0, 12, 12);
    canvas.Draw({{1.0, 4.5}, {9.0, 4.5}, {5.0, 4.5}}, 8.0);
    for (int x = 1; x < 9; ++x) EXPECT_NEAR(canvas.At(x, 4), 1.0, 0.3);
}

TEST(PolygonRaster, GivesAPixelTheSameValueInEveryWindow) {
    testing::Random random(14);
    for (int round = 0; round < 200; ++round) {
        const Polygon p = RandomConvex(random, 9.0);
        Canvas whole(-10, -10, 60, 60);
        whole.Draw(p, 1.0);
        const int x0 = random.Below(20), y0 = random.Below(20);
        Canvas part(x0, y0, random.Below(12) + 1, random.Below(12) + 1);
        part.Draw(p, 1.0);
        for (int y = part.y0; y < part.y0 + part.rows; ++y) {
            for (int x = part.x0; x < part.x0 + part.width; ++x) {
                ASSERT_EQ(part.At(x, y), whole.At(x, y)) << round;
            }
        }
    }
}

TEST(PolygonRaster, DropsWhatFallsOutside) {
    Canvas canvas(0, 0, 8, 8);
    canvas.Draw({{100.0, 100.0}, {110.0, 100.0}, {105.0, 120.0}}, 1.0);
    canvas.Draw({{-1e9, -1e9}, {-1e9 + 5.0, -1e9}, {-1e9, -1e9 + 5.0}}, 1.0);
    EXPECT_EQ(canvas.Sum(), 0.0);
    // One that covers far more than the window leaves its even share in each pixel.
    canvas.Draw({{-1e5, -1e5}, {1e5, -1e5}, {1e5, 1e5}, {-1e5, 1e5}}, 4e10);
    for (const double v : canvas.pixels) EXPECT_NEAR(v, 1.0, 1e-9);
}

TEST(PolygonRaster, DrawsColoursTogetherAsItDrawsThemAlone) {
    const Polygon a{{1.2, 1.1}, {6.7, 2.3}, {4.0, 6.6}},
        b{{2.0, 3.0}, {7.5, 3.5}, {5.0, 7.0}, {1.0, 6.0}};
    std::vector<double> pixels(8 * 8 * kColourStride);
    RasterTarget target;
    target.layers = {pixels.data()};
    target.width = target.rows = 8;
    PolygonRaster raster(target, 3);
    raster.Add(a, std::vector<double>{1.0, 2.0, -0.5}, 0);
    raster.Add(b, std::vector<double>{0.25, 0.0, 4.0}, 0);
    raster.Flush();
    Canvas alone_a(0, 0, 8, 8), alone_b(0, 0, 8, 8);
    alone_a.Draw(a, 1.0);
    alone_b.Draw(b, 1.0);
    const double amounts[][2] = {{1.0, 0.25}, {2.0, 0.0}, {-0.5, 4.0}, {0.0, 0.0}};
    for (std::size_t i = 0; i < 64; ++i) {
        for (std::size_t c = 0; c < kColourStride; ++c) {
            EXPECT_NEAR(pixels[i * kColourStride + c],
                        amounts[c][0] * alone_a.pixels[i] + amounts[c][1] * alone_b.pixels[i],
                        1e-13);
        }
    }
    EXPECT_GT(raster.fragments(), 20U);
}

}  // namespace
}  // namespace flare
