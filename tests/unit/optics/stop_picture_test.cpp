// SPDX-License-Identifier: Apache-2.0
#include "core/optics/stop_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/optics/stop_outline.h"
#include "tests/support/stop_masks.h"

namespace flare {
namespace {

using testing::Drawn;
using testing::InStar;

double LoopArea(const std::vector<std::vector<Vec2d>>& loops) {
    double twice = 0.0;
    for (const auto& loop : loops) {
        for (std::size_t n = 0; n < loop.size(); ++n)
            twice += loop[n].cross(loop[(n + 1) % loop.size()]);
    }
    return 0.5 * twice;
}

TEST(StopPicture, AreasOfStarRingAndSlitAreTheirClosedForms) {
    const auto star = StopPicture::Sharp(Drawn(128, 10.0, InStar));
    const double star_area = 10.0 * 0.5 * 8.0 * 3.2 * std::sin(0.2 * kPi);
    EXPECT_NEAR(star->area_mm2(), star_area, 1e-3 * star_area);
    EXPECT_NEAR(LoopArea(star->Outlines()), star_area, 3e-3 * star_area);

    const auto ring = StopPicture::Sharp(Drawn(128, 10.0, [](Vec2d p) {
        return p.length() < 7.0 && (p - Vec2d(1.0, 2.0)).length() > 3.0;
    }));
    EXPECT_NEAR(ring->area_mm2(), 40.0 * kPi, 1e-3 * 40.0 * kPi);
    EXPECT_NEAR(LoopArea(ring->Outlines()), 40.0 * kPi, 1e-3 * 40.0 * kPi);
    EXPECT_EQ(ring->Outlines().size(), 2U);

    const auto slit = StopPicture::Sharp(
        Drawn(64, 8.0, [](Vec2d p) { return std::abs(p.x) < 0.25 && std::abs(p.y) < 6.0; }));
    EXPECT_NEAR(slit->area_mm2(), 6.0, 1e-6);
    EXPECT_NEAR(LoopArea(slit->Outlines()), 6.0, 0.1);
}

TEST(StopPicture, EdgesLieWhereTheyWereDrawnHoweverFarMagnified) {
    const Vec2d normal(std::cos(0.3), std::sin(0.3));
    const auto half =
        StopPicture::Sharp(Drawn(64, 8.0, [&](Vec2d p) { return p.dot(normal) < 0.31; }));
    const double pixel = half->cell_mm() / 20.0;
    for (double along = -4.0; along < 4.0; along += 0.37) {
        const Vec2d on = normal * 0.31 + Vec2d(-normal.y, normal.x) * along;
        // The place of the edge from the light that pixels across it get.
        double light = 0.0;
        for (int k = -60; k < 60; ++k) {
            light += pixel * half->Mean({on + normal * ((k + 0.5) * pixel), normal * pixel,
                                         Vec2d(-normal.y, normal.x) * pixel, Vec2d(0.0, 0.0)});
        }
        EXPECT_NEAR(light, 60 * pixel, 0.1 * half->cell_mm());
        EXPECT_EQ(half->At(on - normal * half->cell_mm() * 0.15), 1.0);
        EXPECT_EQ(half->At(on + normal * half->cell_mm() * 0.15), 0.0);
    }
}

// The means of all pixels together hold the picture's area, from magnified to a point.
TEST(StopPicture, MeansOverPixelsOfAnySizeAddUpToTheArea) {
    const auto star = StopPicture::Sharp(Drawn(128, 10.0, InStar));
    for (const double pixel : {0.04, 0.3, 0.9, 2.7, 8.1}) {
        const double turn = 0.4;
        const Vec2d right(pixel * std::cos(turn), pixel * std::sin(turn));
        const Vec2d down(0.6 * right.y, -0.6 * right.x);
        const int reach = static_cast<int>(20.0 / (0.6 * pixel)) + 2;
        double sum = 0.0;
        for (int j = -reach; j <= reach; ++j) {
            for (int i = -reach; i <= reach; ++i) {
                const Vec2d at = right * (i + 0.2) + down * (j + 0.7);
                if (std::max(std::abs(at.x), std::abs(at.y)) < 20.0)
                    sum += star->Mean({at, right, down, Vec2d(0.0, 0.0)});
            }
        }
        const double tolerance = pixel < 1.0 ? 0.003 : pixel < 3.0 ? 0.01 : 0.05;
        EXPECT_NEAR(sum * 0.6 * pixel * pixel, star->area_mm2(), tolerance * star->area_mm2())
            << pixel;
    }
}

TEST(StopPicture, RangesHoldEveryMean) {
    const auto star = StopPicture::Sharp(Drawn(48, 10.0, InStar));
    unsigned seed = 7;
    const auto random = [&] {
        seed = seed * 1664525U + 1013904223U;
        return static_cast<double>(seed >> 8) * 0x1.0p-24;
    };
    for (int n = 0; n < 2000; ++n) {
        const Vec2d lo(22.0 * random() - 11.0, 22.0 * random() - 11.0);
        const Vec2d size(4.0 * random(), 4.0 * random());
        const StopRange range = star->Over(lo.x, lo.y, lo.x + size.x, lo.y + size.y);
        const Vec2d pixel = size * (0.5 * random());
        const Vec2d middle =
            lo + pixel * 0.5 + Vec2d((size.x - pixel.x) * random(), (size.y - pixel.y) * random());
        const double mean =
            star->Mean({middle, Vec2d(pixel.x, 0.0), Vec2d(0.0, pixel.y), Vec2d(0.0, 0.0)});
        const double at = star->At(middle);
        EXPECT_GE(std::min(mean, at), static_cast<double>(range.lo) - 1e-6);
        EXPECT_LE(std::max(mean, at), static_cast<double>(range.hi) + 1e-6);
    }
}

TEST(StopPicture, RadiiBoundLightAndTheClearMiddle) {
    const auto star = StopPicture::Sharp(Drawn(128, 10.0, InStar));
    EXPECT_GE(star->outer_radius(), 8.0);
    EXPECT_LE(star->outer_radius(), 8.5);
    EXPECT_LE(star->clear_radius(), 3.2);
    EXPECT_GE(star->clear_radius(), 2.7);
    const auto hole = StopPicture::Sharp(
        Drawn(64, 10.0, [](Vec2d p) { return p.length() < 8.0 && p.length() > 1.0; }));
    EXPECT_EQ(hole->clear_radius(), 0.0);
}

TEST(StopPicture, ShadesStayOnBothSidesOfAnEdge) {
    StopGrid grid{32, 16.0, {}};
    for (int j = 0; j < 32; ++j) {
        for (int i = 0; i < 32; ++i) grid.values.push_back(i < 16 ? 0.75F : 0.25F);
    }
    const auto shaded = StopPicture::Sharp(grid);
    EXPECT_NEAR(shaded->At({-0.05, 0.0}), 0.75, 1e-6);
    EXPECT_NEAR(shaded->At({0.05, 0.0}), 0.25, 1e-6);
    const auto smooth = StopPicture::Smooth(grid);
    EXPECT_NEAR(smooth->At({0.0, 0.0}), 0.5, 1e-6);
    EXPECT_NEAR(smooth->At({0.25, 0.0}), 0.375, 1e-6);
    EXPECT_NEAR(smooth->area_mm2(), 512.0, 1e-3);
}

// Rows go from below: a light cell in the lower right corner is at x > 0, y < 0.
TEST(StopPicture, RowsGoUp) {
    StopGrid grid{4, 2.0, std::vector<float>(16, 0.0F)};
    grid.values[3] = 2.5F;
    const auto picture = StopPicture::Smooth(grid);
    EXPECT_EQ(picture->At({1.5, -1.5}), 2.5);
    EXPECT_EQ(picture->At({-1.5, -1.5}), 0.0);
    EXPECT_EQ(picture->At({1.5, 1.5}), 0.0);
}

// Turned and resized it is the same picture.
TEST(StopPicture, PlacedIsTurnedAnticlockwiseAndScaled) {
    const auto star = StopPicture::Sharp(Drawn(64, 10.0, InStar));
    const double turn = 0.3;
    const auto placed = star->Placed(5.0, turn);
    EXPECT_NEAR(placed->area_mm2(), 0.25 * star->area_mm2(), 1e-9 * star->area_mm2());
    EXPECT_NEAR(placed->outer_radius(), 0.5 * star->outer_radius(), 1e-12);
    EXPECT_NEAR(LoopArea(placed->Outlines()), 0.25 * LoopArea(star->Outlines()), 1e-9);
    for (int n = 0; n < 400; ++n) {
        const Vec2d p(0.9 * (n % 20 - 9.7), 0.9 * (n / 20 - 9.7));
        const Vec2d q = Vec2d(p.x * std::cos(turn) - p.y * std::sin(turn),
                              p.x * std::sin(turn) + p.y * std::cos(turn)) *
                        0.5;
        EXPECT_EQ(star->At(p), placed->At(q));
        const StopRange range = placed->Over(q.x, q.y, q.x, q.y);
        EXPECT_GE(placed->At(q), static_cast<double>(range.lo));
        EXPECT_LE(placed->At(q), static_cast<double>(range.hi));
    }
}

// Two cells that touch at a corner are apart, two others joined by the light beside them.
TEST(StopOutline, LoopsAreClosedAndTurnAroundLight) {
    std::vector<float> saddle(36, 0.0F);
    saddle[1 * 6 + 2] = saddle[2 * 6 + 1] = 1.0F;
    saddle[4 * 6 + 4] = 1.0F;
    saddle[3 * 6 + 3] = 1.0F;
    saddle[3 * 6 + 4] = 0.2F;
    const auto loops = OutlinesOf(saddle, 6);
    double area = 0.0;
    for (const auto& loop : loops) area += LoopArea({loop});
    EXPECT_GT(area, 1.0);
    for (const auto& loop : loops) EXPECT_GT(LoopArea({loop}), 0.0);
    EXPECT_EQ(loops.size(), 3U);
}

}  // namespace
}  // namespace flare
