// SPDX-License-Identifier: Apache-2.0
#include "core/optics/stop_dirt.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"
#include "core/optics/iris.h"

namespace flare {
namespace {

constexpr double kRim_mm = 10.0;
// Of the picture: the square around the rim's disc.
double Square(const StopPicture& picture) {
    return 4.0 * picture.half_width_mm() * picture.half_width_mm();
}

double AreaOf(const StopMark& mark) {
    return kPi * mark.radius_mm * mark.radius_mm +
           2.0 * mark.radius_mm * (mark.b - mark.a).length();
}

TEST(StopDirt, HoldsBackTheAreaOfItsMarks) {
    for (const double opacity : {1.0, 0.3}) {
        const std::vector<StopMark> marks = {{{1.0, 2.0}, {1.0, 2.0}, 0.5, opacity},
                                             {{-6.0, -3.3}, {-2.1, -1.0}, 0.21, opacity},
                                             {{-3.0, 4.0}, {3.0, 4.0}, 0.2, opacity},
                                             {{5.0, -4.0}, {5.0, 1.0}, 0.15, opacity}};
        const auto picture = DirtyStop(marks, kRim_mm);
        double area = 0.0;
        for (const StopMark& mark : marks) area += opacity * AreaOf(mark);
        const double held = (Square(*picture) - picture->area_mm2()) * kRim_mm * kRim_mm;
        EXPECT_NEAR(held, area, 1e-3 * area);
        EXPECT_NEAR(picture->At(Vec2d(1.0, 2.0) / kRim_mm), 1.0 - opacity, 1e-6);
        EXPECT_EQ(picture->At(Vec2d(-1.0, -6.0) / kRim_mm), 1.0);
    }
    EXPECT_FALSE(DirtyStop({}, kRim_mm));
}

// A speck's edge is a circle to a tenth of a cell, though cells are a tenth of it.
TEST(StopDirt, HasRoundSpecks) {
    const auto picture = DirtyStop({{{1.0, 2.0}, {1.0, 2.0}, 0.5, 1.0}}, kRim_mm);
    for (int k = 0; k < 24; ++k) {
        const double angle = 2.0 * kPi * k / 24;
        const Vec2d out(std::cos(angle), std::sin(angle));
        const double cell = picture->cell_mm() * kRim_mm;
        EXPECT_EQ(picture->At((Vec2d(1.0, 2.0) + out * (0.5 - 0.1 * cell)) / kRim_mm), 0.0);
        EXPECT_EQ(picture->At((Vec2d(1.0, 2.0) + out * (0.5 + 0.1 * cell)) / kRim_mm), 1.0);
    }
}

TEST(StopDirt, LiesEvenlyAndClearOfItself) {
    const StopDust dust{300, 0.2, 0.8, 7};
    const std::vector<StopMark> marks = MarksOf(dust, {}, kRim_mm);
    ASSERT_EQ(marks.size(), 300U);
    int inner = 0;
    for (std::size_t a = 0; a < marks.size(); ++a) {
        EXPECT_GE(marks[a].radius_mm, 0.05);
        EXPECT_LE(marks[a].radius_mm, 0.2);
        EXPECT_EQ(marks[a].opacity, 0.8);
        EXPECT_LE(marks[a].a.length(), kRim_mm);
        inner += marks[a].a.length() < kRim_mm * std::sqrt(0.5) ? 1 : 0;
        for (std::size_t b = 0; b < a; ++b) {
            EXPECT_GT((marks[a].a - marks[b].a).length(), marks[a].radius_mm + marks[b].radius_mm);
        }
    }
    EXPECT_NEAR(inner, 150, 35);
    const StopScratches scratches{20, 4.0, 0.05, 0.5, 3};
    for (const StopMark& mark : MarksOf({}, scratches, kRim_mm)) {
        EXPECT_NEAR((mark.b - mark.a).length(), 4.0, 1e-12);
        EXPECT_EQ(mark.radius_mm, 0.025);
    }
    StopDust other = dust;
    other.seed = 8;
    EXPECT_NE(MarksOf(other, {}, kRim_mm)[0].a, marks[0].a);
    EXPECT_EQ(MarksOf(dust, {}, kRim_mm)[299].a, marks[299].a);
}

// On a real iris, by points between the cells of a square that lies wholly within the blades.
TEST(StopDirt, IsMultipliedOntoTheIris) {
    for (const double opacity : {1.0, 0.3}) {
        const StopMark speck{{1.0, 1.0}, {1.0, 1.0}, 0.4, opacity};
        const StopMark scratch{{-1.5, 0.0}, {0.5, -1.0}, 0.1, opacity};
        const IrisShape shape{
            6, 0.0, 0.0, 0.0, 0, DirtyStop({speck, scratch}, kRim_mm), MaskScale::kStop};
        const Iris iris(shape, 4.0, kRim_mm);
        constexpr int kSide = 400;
        constexpr double kHalf_mm = 2.0, kStep_mm = 2.0 * kHalf_mm / kSide;
        double held = 0.0;
        for (int j = 0; j < kSide; ++j) {
            for (int i = 0; i < kSide; ++i) {
                const Vec2d at((i + 0.5) * kStep_mm - kHalf_mm, (j + 0.5) * kStep_mm - kHalf_mm);
                held += (1.0 - iris.TransmissionAt(at)) * kStep_mm * kStep_mm;
            }
        }
        const double expected = opacity * (AreaOf(speck) + AreaOf(scratch));
        EXPECT_NEAR(held, expected, 0.03 * expected);
        EXPECT_EQ(iris.TransmissionAt({0.0, 4.5}), 0.0);
    }
}

}  // namespace
}  // namespace flare
