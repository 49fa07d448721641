// SPDX-License-Identifier: Apache-2.0
//
// Coatings that no maker would lay (row 30): none of them may make or lose light, or overflow.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "core/base/units.h"
#include "core/optics/coating_design.h"
#include "tests/support/random.h"

namespace flare {
namespace {

using Complex = std::complex<double>;

Coating Layers(std::vector<CoatingLayer> layers) {
    return {"test", std::move(layers), ""};
}

TEST(AHundredLayers, ConserveLightAtEveryAngle) {
    std::vector<CoatingLayer> stack;
    for (int i = 0; i < 50; ++i) {
        stack.push_back({2.35, 550.0 / 4.0 / 2.35});
        stack.push_back({1.46, 550.0 / 4.0 / 1.46});
    }
    const Coating mirror = Layers(stack);
    for (double angle = 0.0; angle < 90.0; angle += 0.5) {
        for (const double wavelength : {380.0, 480.0, 550.0, 700.0}) {
            const double c = std::cos(RadiansFromDegrees(angle));
            const Reflection r = ReflectionOf(mirror, false, 1.0, 1.5, c, wavelength);
            EXPECT_NEAR(r.reflectance + r.transmittance, 1.0, 1e-9) << angle << " " << wavelength;
            EXPECT_GE(r.transmittance, 0.0);
        }
    }
    // In its stop band it is a mirror: with q pairs R = ((1 - Y)/(1 + Y))^2, Y = (nH/nL)^2q n_s.
    const Reflection at = ReflectionOf(mirror, false, 1.0, 1.5, 1.0, 550.0);
    EXPECT_NEAR(at.transmittance / (4.0 * 1.5 * std::pow(1.46 / 2.35, 100.0) / (1.5 * 1.5)), 1.0,
                1e-6);
}

TEST(ALayerOfNoThickness, IsNoLayer) {
    for (const double c : {1.0, 0.6, 0.05}) {
        const double bare = ReflectionOf({}, false, 1.0, 1.6, c, 550.0).reflectance;
        for (const double n : {1.0, 1.38, 4.0}) {
            EXPECT_NEAR(ReflectionOf(Layers({{n, 0.0}}), false, 1.0, 1.6, c, 550.0).reflectance,
                        bare, 1e-14);
        }
        EXPECT_NEAR(
            ReflectionOf(Layers({{Complex(2.0, 3.0), 0.0}}), false, 1.0, 1.6, c, 550.0).reflectance,
            bare, 1e-14);
    }
}

TEST(ALossyLayer, KeepsSomeAndMakesNone) {
    testing::Random random(8);
    for (int i = 0; i < 2000; ++i) {
        const Coating coating =
            Layers({{Complex(random.Uniform(0.2, 3.0), random.Uniform(0.0, 4.0)),
                     random.Uniform(0.0, 500.0)},
                    {1.46, random.Uniform(0.0, 300.0)}});
        const double c = random.Uniform(0.0, 1.0);
        const bool reversed = i % 2 == 0;
        const Reflection r = ReflectionOf(coating, reversed, reversed ? 1.6 : 1.0,
                                          reversed ? 1.0 : 1.6, c, random.Uniform(300.0, 1100.0));
        ASSERT_TRUE(std::isfinite(r.reflectance) && std::isfinite(r.transmittance));
        ASSERT_GE(r.reflectance, 0.0);
        ASSERT_GE(r.transmittance, 0.0);
        ASSERT_LE(r.reflectance + r.transmittance, 1.0 + 1e-12);
    }
}

// A millimetre of metal: exp(-4 pi k d / lambda) underflows, and nothing overflows.
TEST(AThickMetalLayer, IsAMirrorThatPassesNothing) {
    const Complex silver(0.06, 3.6);
    const Reflection r = ReflectionOf(Layers({{silver, 1e6}}), false, 1.0, 1.5, 1.0, 550.0);
    EXPECT_NEAR(r.reflectance, std::norm((1.0 - silver) / (1.0 + silver)), 1e-12);
    EXPECT_EQ(r.transmittance, 0.0);
}

// Light in glass beyond the critical angle of a thin air-like layer tunnels through it.
TEST(AnEvanescentLayer, LetsLightTunnelAsFrustratedTotalReflection) {
    const double n = 1.6, gap_index = 1.0, angle = RadiansFromDegrees(50.0);
    const double c = std::cos(angle), t = n * std::sin(angle);
    ASSERT_GT(t, gap_index);
    double last = 1.0;
    for (const double d : {1.0, 30.0, 100.0, 300.0, 1000.0, 1e5}) {
        const Reflection r = ReflectionOf(Layers({{gap_index, d}}), false, n, n, c, 550.0);
        EXPECT_NEAR(r.reflectance + r.transmittance, 1.0, 1e-12) << d;
        EXPECT_LT(r.transmittance, last);
        // s and p from the closed form 1/T = 1 + ((a + 1/a)/2)^2 sinh^2, a the ratio of
        // admittances.
        const double kappa = std::sqrt(t * t - gap_index * gap_index);
        const double s = std::sinh(2.0 * kPi * kappa * d / 550.0);
        double mean = 0.0;
        for (const bool p : {false, true}) {
            const double a =
                p ? (n * n / (n * c)) / (gap_index * gap_index / kappa) : n * c / kappa;
            const double f = 0.5 * (a + 1.0 / a);
            mean += 0.5 / (1.0 + f * f * s * s);
        }
        EXPECT_NEAR(r.transmittance, mean, 1e-12 + 1e-10 * mean) << d;
        last = r.transmittance;
    }
}

TEST(GrazingLightOnACoating, IsReflectedWhole) {
    for (const double c : {1e-3, 1e-8, 1e-16, 1e-300, 0.0}) {
        for (const bool reversed : {false, true}) {
            const Reflection r = ReflectionOf(
                BuiltInCoating("mgf2-550")->For(Glass::Air(), Glass::FromNdVd(1.6, {})), reversed,
                reversed ? 1.6 : 1.0, reversed ? 1.0 : 1.6, c, 550.0);
            ASSERT_TRUE(std::isfinite(r.reflectance) && std::isfinite(r.transmittance)) << c;
            EXPECT_GT(r.reflectance, 0.97);
            EXPECT_LE(r.reflectance + r.transmittance, 1.0 + 1e-12);
        }
    }
}

TEST(CoatingNames, ThatAreNotOnesAreRefused) {
    for (const char* name : {"", "mgf2", "mgf2-", "mgf2-299", "mgf2-1101", "mgf2-5e2", "mgf2-550x",
                             "MGF2-550", "mgf2--550", "mgf2-99999999999"}) {
        EXPECT_FALSE(BuiltInCoating(name).ok()) << name;
    }
    EXPECT_TRUE(BuiltInCoating("mgf2-300").ok());
    EXPECT_TRUE(BuiltInCoating("mgf2-1100").ok());
    EXPECT_TRUE(BuiltInCoating("none")->layers().empty());
}

}  // namespace
}  // namespace flare
