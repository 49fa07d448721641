// SPDX-License-Identifier: Apache-2.0
#include "core/render/source_picture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"

namespace flare {
namespace {

TEST(SourcePicture, StandsInTheMiddleOfItsSquareFromBelow) {
    const auto picture = SourcePicture::Of(2, 4, {1, 0, 0, 0, 0, 0, 2, 1});
    ASSERT_TRUE(picture);
    ASSERT_EQ(picture->side(), 4);
    EXPECT_DOUBLE_EQ(picture->At(1, 3), 0.25);
    EXPECT_DOUBLE_EQ(picture->At(1, 0), 0.5);
    EXPECT_DOUBLE_EQ(picture->At(2, 0), 0.25);
    EXPECT_EQ(picture->At(0, 0), 0.0);
    EXPECT_FALSE(SourcePicture::Of(2, 1, {0, 0}));
}

// 150 pixels on 64 cells: each holds the part of every pixel that it covers.
TEST(SourcePicture, KeepsLightAndMiddleOfALargeImage) {
    constexpr int kSize = 150;
    std::vector<float> values;
    double sum = 0.0, x = 0.0, y = 0.0;
    for (int j = 0; j < kSize; ++j) {
        for (int i = 0; i < kSize; ++i) {
            const float value = static_cast<float>((i * 7 + j * j) % 11) * (i > 90 ? 3.0F : 1.0F);
            values.push_back(value);
            sum += static_cast<double>(value);
            x += static_cast<double>(value) * (i + 0.5) / kSize;
            y += static_cast<double>(value) * (1.0 - (j + 0.5) / kSize);
        }
    }
    const auto picture = SourcePicture::Of(kSize, kSize, values);
    ASSERT_EQ(picture->side(), SourcePicture::kMostSide);
    double all = 0.0, u = 0.0, v = 0.0;
    for (int j = 0; j < picture->side(); ++j) {
        for (int i = 0; i < picture->side(); ++i) {
            all += picture->At(i, j);
            u += picture->At(i, j) * (i + 0.5) / picture->side();
            v += picture->At(i, j) * (j + 0.5) / picture->side();
        }
    }
    EXPECT_NEAR(all, 1.0, 1e-12);
    EXPECT_NEAR(u, x / sum, 1e-4);
    EXPECT_NEAR(v, y / sum, 1e-4);
}

TEST(SourcePicture, KnowsHowFineItIs) {
    std::vector<float> disc, bars;
    for (int j = 0; j < 64; ++j) {
        for (int i = 0; i < 64; ++i) {
            disc.push_back(std::hypot(i - 31.5, j - 31.5) < 24.0 ? 1.0F : 0.0F);
            bars.push_back(i % 8 < 4 ? 1.0F : 0.0F);
        }
    }
    // Steps of cells make an outline a little longer.
    EXPECT_NEAR(SourcePicture::Of(64, 64, disc)->detail(), 24.0 / 32.0, 0.2);
    // Bars of width w have two sides: a disc of radius w.
    EXPECT_NEAR(SourcePicture::Of(64, 64, bars)->detail(), 4.0 / 32.0, 0.02);
}

TEST(UprightAt, IsUpInALevelPicture) {
    const Vec3d d = Vec3d(0.4, -0.3, 0.8).normalized();
    const UprightAxes axes = UprightAt(d);
    EXPECT_NEAR(axes.up.dot(d), 0.0, 1e-15);
    EXPECT_NEAR(axes.right.dot(d), 0.0, 1e-15);
    EXPECT_NEAR(axes.right.dot(axes.up), 0.0, 1e-15);
    const auto pinhole = [](const Vec3d& at) { return Vec2d(at.x, at.y) / at.z; };
    const Vec2d moved = pinhole(d + axes.up * 1e-6) - pinhole(d);
    EXPECT_NEAR(moved.x, 0.0, 1e-12);
    EXPECT_GT(moved.y, 0.0);
    EXPECT_GT((pinhole(d + axes.right * 1e-6) - pinhole(d)).x, 0.0);
    EXPECT_EQ(UprightAt(Vec3d(0.0, 1.0, 0.0)).up, Vec3d(0.0, 0.0, -1.0));
}

}  // namespace
}  // namespace flare
