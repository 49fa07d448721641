// SPDX-License-Identifier: Apache-2.0
#include "core/spectrum/light_spectrum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/spectrum/cie_table.h"
#include "core/spectrum/color_response.h"

namespace flare {
namespace {

double Largest(const Vec3d& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

double Least(const Spectrum& power) {
    return *std::min_element(power.begin(), power.end());
}

Vec2d ChromaticityOf(const Spectrum& power) {
    Vec3d xyz(0.0);
    for (std::size_t i = 0; i < power.size(); ++i) {
        const CieRow& row = CieTable()[i];
        xyz += Vec3d(row.x_bar, row.y_bar, row.z_bar) * power[i];
    }
    return Vec2d(xyz.x, xyz.y) / (xyz.x + xyz.y + xyz.z);
}

// The Planckian locus as tables print it (Wyszecki and Stiles, table 1(3.11), c2 = 1.4388e-2).
TEST(Blackbody, LiesOnThePlanckianLocusWithLuminanceOne) {
    const struct {
        double kelvin, x, y;
    } kLocus[] = {{2000.0, 0.5267, 0.4133},
                  {3000.0, 0.4369, 0.4041},
                  {5000.0, 0.3451, 0.3516},
                  {10'000.0, 0.2807, 0.2884}};
    for (const auto& point : kLocus) {
        const Spectrum power = BlackbodySpectrum(point.kelvin);
        EXPECT_NEAR(Luminance(power), 1.0, 1e-12);
        EXPECT_NEAR(ChromaticityOf(power).x, point.x, 2e-4) << point.kelvin;
        EXPECT_NEAR(ChromaticityOf(power).y, point.y, 2e-4) << point.kelvin;
    }
}

TEST(Blackbody, StaysFiniteAtTheEndsOfTheRange) {
    for (const double kelvin : {500.0, 1e6}) {
        for (const double value : BlackbodySpectrum(kelvin)) {
            EXPECT_TRUE(std::isfinite(value));
            EXPECT_GT(value, 0.0);
        }
    }
}

// A blackbody of twice the strength is what it is, and white is the mix of primaries.
TEST(SpectrumOfColor, IsTheBaseItselfWhereTheColourIsTheBases) {
    for (const double kelvin : {1200.0, 3200.0, 20'000.0}) {
        const Spectrum base = BlackbodySpectrum(kelvin);
        const Spectrum twice = SpectrumOfColor(base, Rec709FromSpectrum(base) * 2.0);
        for (std::size_t i = 0; i < base.size(); ++i) {
            EXPECT_NEAR(twice[i], 2.0 * base[i], 1e-6 * base[i]) << kelvin << " " << i;
        }
    }
    const Vec3d rgb(0.2, 0.7, 0.1);
    const Spectrum mixed = SpectrumOfColor(WhiteSpectrum(), rgb);
    for (std::size_t i = 0; i < mixed.size(); ++i) {
        EXPECT_NEAR(mixed[i], LightSpectrum(rgb)[i], 1e-12);
    }
}

// Saturated colours of the wide spaces, of which light can be made: exact, and no light is
// negative. Colours grow with the light.
TEST(SpectrumOfColor, IsNowhereNegativeForRealColoursOutsideRec709) {
    const Vec3d acescg[] = {{1.0, 0.05, 0.05}, {0.1, 1.0, 0.1},  {0.03, 0.03, 1.0},
                            {1.0, 1.0, 0.05},  {0.05, 1.0, 1.0}, {1.0, 0.05, 1.0}};
    for (const Vec3d& asked : acescg) {
        const Vec3d rgb = Rec709FromSpace(ColorSpace::kAcesCg, asked);
        EXPECT_LT(std::min({rgb.x, rgb.y, rgb.z}), 0.0);
        const Spectrum power = SpectrumOfColor(WhiteSpectrum(), rgb);
        EXPECT_GE(Least(power), 0.0);
        EXPECT_LT(Largest(Rec709FromSpectrum(power) - rgb), 1e-8 * Largest(rgb));
        const Spectrum tenfold = SpectrumOfColor(WhiteSpectrum(), rgb * 10.0);
        for (std::size_t i = 0; i < power.size(); ++i) {
            EXPECT_NEAR(tenfold[i], 10.0 * power[i], 1e-6);
        }
    }
}

// Nearest: no step that keeps the colour and the sign brings it nearer to the mix.
TEST(SpectrumOfColor, CannotBeBroughtNearerToTheMix) {
    const Vec3d rgb = Rec709FromSpace(ColorSpace::kAcesCg, {0.1, 1.0, 0.1});
    const Spectrum power = SpectrumOfColor(WhiteSpectrum(), rgb);
    const Spectrum mix = LightSpectrum(rgb);
    const auto distance = [&](const Spectrum& of) {
        double sum = 0.0;
        for (std::size_t i = 0; i < of.size(); ++i) {
            sum += std::pow((of[i] - mix[i]) / WhiteSpectrum()[i], 2.0);
        }
        return sum;
    };
    int tried = 0;
    for (std::size_t a = 0; a < 3 * kSpectrumSamples; ++a) {
        // Four samples and the one combination of them that has no colour.
        const std::size_t first = a / 3, step = 2 + 2 * (a % 3);
        if (first + 3 * step >= kSpectrumSamples) continue;
        const std::size_t at[] = {first, first + step, first + 2 * step, first + 3 * step};
        const auto& r = Rec709Response();
        const Vec3d b = r[at[1]], c = r[at[2]], d = r[at[3]], e = r[at[0]];
        const double volume = b.dot(c.cross(d));
        const double weight[] = {volume, -e.dot(c.cross(d)), -b.dot(e.cross(d)),
                                 -b.dot(c.cross(e))};
        for (const double sign : {1.0, -1.0}) {
            Spectrum moved = power;
            bool negative = false;
            double scale = 0.0;
            for (const double w : weight) scale = std::max(scale, std::abs(w));
            for (int k = 0; k < 4; ++k) {
                moved[at[k]] += sign * 1e-5 * weight[k] / scale;
                negative = negative || moved[at[k]] < 0.0;
            }
            if (negative) continue;
            EXPECT_GE(distance(moved), distance(power) - 1e-12) << a << " " << sign;
            ++tried;
        }
    }
    EXPECT_GT(tried, 20);
}

// The primaries of AP0 and, by a little, AP1 lie outside the spectral locus: exact all the same.
TEST(SpectrumOfColor, HasTheColourEvenIfNoLightHas) {
    for (const ColorSpace space : {ColorSpace::kAcesCg, ColorSpace::kAces2065}) {
        for (int k = 0; k < 3; ++k) {
            Vec3d asked(0.0);
            asked[k] = 1.0;
            const Vec3d rgb = Rec709FromSpace(space, asked);
            const Spectrum power = SpectrumOfColor(WhiteSpectrum(), rgb);
            EXPECT_LT(Largest(Rec709FromSpectrum(power) - rgb), 1e-8 * Largest(rgb));
            double below = 0.0, all = 0.0;
            for (const double value : power) {
                below += std::max(0.0, -value);
                all += std::abs(value);
            }
            EXPECT_LT(below, (space == ColorSpace::kAcesCg ? 0.1 : 0.45) * all) << k;
            RecordProperty("negative_share", std::to_string(below / all));
            std::printf("%s primary %d: %.3f of the light is negative\n",
                        space == ColorSpace::kAcesCg ? "AP1" : "AP0", k, below / all);
        }
    }
}

}  // namespace
}  // namespace flare
