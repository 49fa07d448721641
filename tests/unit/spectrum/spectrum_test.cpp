// SPDX-License-Identifier: Apache-2.0
#include "core/spectrum/spectrum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>

#include "core/spectrum/cie_table.h"
#include "core/spectrum/primaries_table.h"

namespace flare {
namespace {

struct Chromaticity {
    double x, y;
};

// Chromaticity straight from the colour matching functions, without the Rec.709 matrix.
Chromaticity ChromaticityOf(const Spectrum& power) {
    double x = 0.0, y = 0.0, z = 0.0;
    for (std::size_t i = 0; i < power.size(); ++i) {
        x += CieTable()[i].x_bar * power[i];
        y += CieTable()[i].y_bar * power[i];
        z += CieTable()[i].z_bar * power[i];
    }
    return {x / (x + y + z), y / (x + y + z)};
}

// Planck's law up to a factor; `c2_nm_k` is the second radiation constant.
Spectrum Planck(double kelvin, double c2_nm_k) {
    Spectrum power;
    for (int i = 0; i < kSpectrumSamples; ++i) {
        const double nm = SampleWavelength(i);
        power[static_cast<std::size_t>(i)] =
            std::pow(nm / 560.0, -5.0) / std::expm1(c2_nm_k / (nm * kelvin));
    }
    return power;
}

TEST(Spectrum, WhiteIsOneOneOne) {
    const Vec3d rgb = Rec709FromSpectrum(WhiteSpectrum());
    EXPECT_NEAR(rgb.x, 1.0, 1e-12);
    EXPECT_NEAR(rgb.y, 1.0, 1e-12);
    EXPECT_NEAR(rgb.z, 1.0, 1e-12);
}

TEST(Spectrum, WhiteHasTheStatedChromaticityOfD65) {
    const Chromaticity d65 = ChromaticityOf(WhiteSpectrum());
    EXPECT_NEAR(d65.x, 0.3127, 1e-4);
    EXPECT_NEAR(d65.y, 0.3290, 1e-4);
}

TEST(Spectrum, BlackbodyOf6504KelvinLiesOnThePlanckianLocus) {
    const Chromaticity xy = ChromaticityOf(Planck(6504.0, 1.438776877e7));
    EXPECT_NEAR(xy.x, 0.3135, 1e-4);
    EXPECT_NEAR(xy.y, 0.3237, 1e-4);
}

// ISO/CIE 11664-2 defines A by Planck's law with c2 = 1.435e7 nm K and T = 2848 K.
TEST(Spectrum, IlluminantAHasItsChromaticity) {
    const Chromaticity xy = ChromaticityOf(Planck(2848.0, 1.435e7));
    EXPECT_NEAR(xy.x, 0.4476, 1e-4);
    EXPECT_NEAR(xy.y, 0.4074, 1e-4);
}

// IEC 61966-2-1 prints the matrix from XYZ to linear Rec.709 rounded to four decimals.
TEST(Spectrum, ResponseIsThePublishedMatrixTimesTheMatchingFunctions) {
    for (std::size_t i = 0; i < kSpectrumSamples; ++i) {
        const CieRow& c = CieTable()[i];
        const Vec3d rgb = Rec709Response()[i];
        EXPECT_NEAR(rgb.x, 3.2406 * c.x_bar - 1.5372 * c.y_bar - 0.4986 * c.z_bar, 2e-3);
        EXPECT_NEAR(rgb.y, -0.9689 * c.x_bar + 1.8758 * c.y_bar + 0.0415 * c.z_bar, 2e-3);
        EXPECT_NEAR(rgb.z, 0.0557 * c.x_bar - 0.2040 * c.y_bar + 1.0570 * c.z_bar, 2e-3);
    }
}

TEST(LightSpectrum, GivesBackEveryPrimary) {
    for (int k = 0; k < 3; ++k) {
        Vec3d asked(0.0);
        asked[k] = 1.0;
        const Vec3d seen = Rec709FromSpectrum(LightSpectrum(asked));
        EXPECT_NEAR(seen.x, asked.x, 1e-9);
        EXPECT_NEAR(seen.y, asked.y, 1e-9);
        EXPECT_NEAR(seen.z, asked.z, 1e-9);
    }
}

TEST(LightSpectrum, GivesBackColoursOutsideTheUnitCube) {
    const Vec3d asked(37.5, -0.25, 1e-3);
    const Vec3d seen = Rec709FromSpectrum(LightSpectrum(asked));
    EXPECT_NEAR(seen.x, asked.x, 1e-10);
    EXPECT_NEAR(seen.y, asked.y, 1e-10);
    EXPECT_NEAR(seen.z, asked.z, 1e-10);
}

TEST(LightSpectrum, WhiteLightHasTheWhiteSpectrum) {
    const Spectrum light = LightSpectrum({1.0, 1.0, 1.0});
    for (std::size_t i = 0; i < light.size(); ++i) {
        EXPECT_NEAR(light[i], WhiteSpectrum()[i], 1e-14 * WhiteSpectrum()[i]);
    }
}

TEST(LightSpectrum, PrimariesAreNonNegativeSmoothAndSumToOne) {
    const auto& table = PrimariesTable();
    for (std::size_t i = 0; i < table.size(); ++i) {
        EXPECT_GE(table[i].red, 0.0);
        EXPECT_GE(table[i].green, 0.0);
        EXPECT_GE(table[i].blue, 0.0);
        EXPECT_NEAR(table[i].red + table[i].green + table[i].blue, 1.0, 1e-15);
        if (i == 0) continue;
        EXPECT_LT(std::abs(table[i].red - table[i - 1].red), 0.15);
        EXPECT_LT(std::abs(table[i].green - table[i - 1].green), 0.15);
        EXPECT_LT(std::abs(table[i].blue - table[i - 1].blue), 0.15);
    }
}

}  // namespace
}  // namespace flare
