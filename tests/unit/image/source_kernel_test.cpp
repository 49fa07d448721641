// SPDX-License-Identifier: Apache-2.0
//
// Kernels and levels against closed forms: moments of ellipses, the edge of a half-plane blurred by
// a disc, constant and linear light.
#include "core/image/source_kernel.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"
#include "core/image/coarse_levels.h"

namespace flare {
namespace {

// A disc of radius 1, by its regular polygon of the same area.
SourceCell UnitDisc() {
    constexpr int kCorners = 96;
    const double radius = std::sqrt(2.0 * kPi / (kCorners * std::sin(2.0 * kPi / kCorners)));
    std::vector<SourcePatch> patches(1);
    for (int k = 0; k < kCorners; ++k) {
        const double angle = 2.0 * kPi * k / kCorners;
        patches[0].outline.push_back(Vec2d(std::cos(angle), std::sin(angle)) * radius);
    }
    Vec2d centroid(0.0);
    return CellOfPatches(std::move(patches), centroid);
}

TEST(SourceKernel, HasTheMomentsOfTheSourcesImage) {
    const SourceCell disc = UnitDisc();
    for (const double size : {0.001, 0.1, 0.5, 0.8, 1.0, 3.0, 20.0}) {
        for (const double narrow : {0.01, 0.4, 1.0}) {
            const Vec2d u = Vec2d(0.8, 0.6) * size;
            const Vec2d v = Vec2d(0.6, -0.8) * (size * narrow);
            const BlurKernel kernel = KernelOf(disc, {u, v, 0});
            double sum = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
            Vec2d mean(0.0);
            for (int j = 0; j < kernel.height; ++j) {
                for (int i = 0; i < kernel.width; ++i) {
                    const double w = static_cast<double>(
                        kernel.weights[static_cast<std::size_t>(j * kernel.width + i)]);
                    const double x = kernel.x0 + i;
                    const double y = kernel.y0 + j;
                    sum += w;
                    mean += Vec2d(x, y) * w;
                    xx += w * x * x;
                    xy += w * x * y;
                    yy += w * y * y;
                }
            }
            const double scale = 1e-5 * (1.0 + size * size) + (size > 1.0 ? 0.04 : 0.0);
            EXPECT_NEAR(sum, 1.0, 1e-5);
            EXPECT_NEAR(mean.length(), 0.0, 1e-5 * (1.0 + size * size));
            EXPECT_NEAR(xx, 0.25 * (u.x * u.x + v.x * v.x), scale + 1e-3 * xx);
            EXPECT_NEAR(xy, 0.25 * (u.x * u.y + v.x * v.y), scale + 1e-3 * xx);
            EXPECT_NEAR(yy, 0.25 * (u.y * u.y + v.y * v.y), scale + 1e-3 * yy);
        }
    }
}

TEST(SourceKernel, OfAVanishingSourceIsTheIdentity) {
    const BlurKernel kernel = KernelOf(UnitDisc(), {Vec2d(1e-6, 0.0), Vec2d(0.0, 1e-6), 0});
    for (int j = 0; j < kernel.height; ++j) {
        for (int i = 0; i < kernel.width; ++i) {
            const bool middle = kernel.x0 + i == 0 && kernel.y0 + j == 0;
            EXPECT_NEAR(kernel.weights[static_cast<std::size_t>(j * kernel.width + i)],
                        middle ? 1.0F : 0.0F, 1e-6F);
        }
    }
}

// Integral of the share of a unit disc left of t, from -infinity.
double BlurredRamp(double t) {
    if (t <= -1.0) return 0.0;
    if (t >= 1.0) return t;
    const double root = std::sqrt(1.0 - t * t);
    return 0.5 * t + (t * std::asin(t) + root - root * root * root / 3.0) / kPi;
}

// Light right of an edge that leans by `angle`, exact on pixels of 2^coarse as far as sampling
// across them goes; black outside of `inside`.
LightPlanes HalfPlane(const PixelWindow& window, const PixelWindow& inside, int coarse,
                      double angle, double offset) {
    constexpr int kSamples = 32;
    LightPlanes light(window, 1);
    const Vec2d normal(std::cos(angle), std::sin(angle));
    const double size = std::ldexp(1.0, coarse);
    for (int j = 0; j < window.height; ++j) {
        for (int i = inside.x - window.x; i < inside.x + inside.width - window.x; ++i) {
            int lit = 0;
            for (int s = 0; s < kSamples * kSamples; ++s) {
                const Vec2d at((window.x + i + (s % kSamples + 0.5) / kSamples) * size,
                               (window.y + j + (s / kSamples + 0.5) / kSamples) * size);
                lit += at.dot(normal) > offset ? 1 : 0;
            }
            light.channels[0][static_cast<std::size_t>(j * window.width + i)] =
                static_cast<float>(lit * size * size / (kSamples * kSamples));
        }
    }
    return light;
}

// Mean of the blurred edge over the pixel around `at`, by its closed form across the pixel.
double EdgeMean(Vec2d at, double angle, double offset, double radius) {
    constexpr int kSamples = 64;
    const Vec2d normal(std::cos(angle), std::sin(angle));
    double sum = 0.0;
    for (int s = 0; s < kSamples; ++s) {
        // Exact along x, sampled along y.
        const double y = at.y + (s + 0.5) / kSamples - 0.5;
        const auto ramp = [&](double x) {
            return radius / normal.x * BlurredRamp((x * normal.x + y * normal.y - offset) / radius);
        };
        sum += ramp(at.x + 0.5) - ramp(at.x - 0.5);
    }
    return sum / kSamples;
}

TEST(SourceKernel, BlursAKnifeEdgeByItsClosedForm) {
    const SourceCell disc = UnitDisc();
    ThreadPool threads(2);
    const PixelWindow wanted{-24, -8, 48, 16};
    struct Case {
        double radius;
        int coarse;
        double most_error;
    };
    // An edge of 1 that is blurred over two radii; drawn on coarser pixels, with less.
    for (const Case& c : {Case{0.3, 0, 0.03},
                          {1.0, 0, 0.05},
                          {3.0, 0, 0.012},
                          {10.0, 0, 0.002},
                          {10.0, 1, 0.008},
                          {10.0, 2, 0.035},
                          {20.0, 2, 0.012}}) {
        CoarseLevels levels(wanted, 1);
        const double size = std::ldexp(1.0, -c.coarse);
        const BlurKernel kernel =
            KernelOf(disc, {Vec2d(c.radius * size, 0.0), Vec2d(0.0, c.radius * size), c.coarse});
        PixelWindow drawn = levels.WindowOf(c.coarse);
        drawn = {drawn.x - kernel.width, drawn.y - kernel.height, drawn.width + 2 * kernel.width,
                 drawn.height + 2 * kernel.height};
        const PixelWindow inside = drawn;
        drawn = WithBlurMargin(drawn, kernel);
        const double angle = 0.4;
        const double offset = 0.3;
        AddBlurred(HalfPlane(drawn, inside, c.coarse, angle, offset), kernel,
                   levels.Level(c.coarse), threads);
        const LightPlanes light = levels.Take(threads);
        double worst = 0.0;
        for (int j = 0; j < wanted.height; ++j) {
            for (int i = 0; i < wanted.width; ++i) {
                const double exact =
                    EdgeMean({wanted.x + i + 0.5, wanted.y + j + 0.5}, angle, offset, c.radius);
                const auto value = static_cast<double>(
                    light.channels[0][static_cast<std::size_t>(j * wanted.width + i)]);
                worst = std::max(worst, std::abs(value - exact));
            }
        }
        EXPECT_LT(worst, c.most_error) << c.radius << " px, pixels of 2^" << c.coarse;
    }
}

TEST(SourceKernel, GivesEveryWindowTheSameBits) {
    const BlurKernel kernel = KernelOf(UnitDisc(), {Vec2d(3.1, 1.0), Vec2d(-0.4, 5.0), 0});
    const PixelWindow inside{-40, -30, 100, 70};
    LightPlanes light(WithBlurMargin(inside, kernel), 3);
    const int margin = inside.x - light.window.x;
    for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t k = 0; k < light.channels[c].size(); ++k) {
            const int column = static_cast<int>(k) % light.window.width;
            if (column < margin || column >= margin + inside.width) continue;
            light.channels[c][k] = k % 7 < 4 ? static_cast<float>((k * (c + 3)) % 101) : 0.0F;
        }
    }
    ThreadPool one(1), three(3);
    LightPlanes whole(PixelWindow{-50, -40, 120, 90}, 3);
    LightPlanes part(PixelWindow{-11, 3, 37, 20}, 3);
    AddBlurred(light, kernel, whole, one);
    AddBlurred(light, kernel, part, three);
    for (std::size_t c = 0; c < 3; ++c) {
        double before = 0.0, after = 0.0;
        for (const float v : light.channels[c]) before += static_cast<double>(v);
        for (const float v : whole.channels[c]) after += static_cast<double>(v);
        EXPECT_NEAR(after, before, 1e-5 * before);
        for (int j = 0; j < 20; ++j) {
            for (int i = 0; i < 37; ++i) {
                ASSERT_EQ(part.channels[c][static_cast<std::size_t>(j * 37 + i)],
                          whole.channels[c][static_cast<std::size_t>((j + 43) * 120 + i + 39)]);
            }
        }
    }
}

TEST(CoarseLevels, KeepConstantAndLinearLight) {
    ThreadPool threads(2);
    const PixelWindow wanted{-37, 5, 61, 40};
    CoarseLevels levels(wanted, 1);
    constexpr int kLevel = 3;
    LightPlanes& coarse = levels.Level(kLevel);
    // Light a pixel of density 1 + 0.01 x - 0.02 y.
    for (int j = 0; j < coarse.window.height; ++j) {
        for (int i = 0; i < coarse.window.width; ++i) {
            const double x = 8.0 * (coarse.window.x + i + 0.5);
            const double y = 8.0 * (coarse.window.y + j + 0.5);
            coarse.channels[0][static_cast<std::size_t>(j * coarse.window.width + i)] =
                static_cast<float>(64.0 * (1.0 + 0.01 * x - 0.02 * y));
        }
    }
    const LightPlanes light = levels.Take(threads);
    ASSERT_EQ(light.window, wanted);
    for (int j = 0; j < wanted.height; ++j) {
        for (int i = 0; i < wanted.width; ++i) {
            const double exact = 1.0 + 0.01 * (wanted.x + i + 0.5) - 0.02 * (wanted.y + j + 0.5);
            EXPECT_NEAR(light.channels[0][static_cast<std::size_t>(j * wanted.width + i)], exact,
                        2e-6);
        }
    }
}

TEST(CoarseLevels, LoseNoLight) {
    ThreadPool threads(1);
    CoarseLevels levels(PixelWindow{-64, -64, 128, 128}, 1);
    LightPlanes& coarse = levels.Level(4);
    const int stride = coarse.window.width;
    coarse
        .channels[0][static_cast<std::size_t>((-1 - coarse.window.y) * stride - coarse.window.x)] =
        3.0F;
    const LightPlanes light = levels.Take(threads);
    double sum = 0.0;
    for (const float v : light.channels[0]) sum += static_cast<double>(v);
    EXPECT_NEAR(sum, 3.0, 1e-5);
}

}  // namespace
}  // namespace flare
