// SPDX-License-Identifier: Apache-2.0
#include "core/optics/coating_material.h"

#include <gtest/gtest.h>

#include <cmath>

namespace flare {
namespace {

using Complex = std::complex<double>;

Complex IndexOf(const char* name, double wavelength_nm) {
    return MaterialByName(name)->Index(wavelength_nm);
}

// Li 1980, MgF2 ordinary ray, and Malitson 1965, fused silica, written out.
TEST(CoatingMaterial, FollowsPublishedFormulas) {
    for (double nm = 360.0; nm <= 1100.0; nm += 7.0) {
        const double l2 = nm * nm * 1e-6;
        const double mgf2 =
            std::sqrt(1.0 + 0.27620 + 0.60967 * l2 / (l2 - 0.08636 * 0.08636) +
                      0.0080 * l2 / (l2 - 18.0 * 18.0) + 2.14973 * l2 / (l2 - 25.0 * 25.0));
        const double silica = std::sqrt(1.0 + 0.6961663 * l2 / (l2 - std::pow(0.0684043, 2)) +
                                        0.4079426 * l2 / (l2 - std::pow(0.1162414, 2)) +
                                        0.8974794 * l2 / (l2 - std::pow(9.896161, 2)));
        EXPECT_NEAR(IndexOf("MgF2", nm).real(), mgf2, 1e-14) << nm;
        EXPECT_NEAR(IndexOf("SiO2", nm).real(), silica, 1e-14) << nm;
        EXPECT_EQ(IndexOf("MgF2", nm).imag(), 0.0);
    }
    EXPECT_NEAR(IndexOf("MgF2", 587.5618).real(), 1.37774, 5e-5);   // handbook n_d 1.3777
    EXPECT_NEAR(IndexOf("SiO2", 587.5618).real(), 1.45846, 5e-6);   // handbook n_d 1.4585
    EXPECT_NEAR(IndexOf("CaF2", 587.5618).real(), 1.43384, 1e-5);   // handbook n_d 1.4338
    EXPECT_NEAR(IndexOf("Al2O3", 587.5618).real(), 1.76823, 1e-5);  // sapphire n_o 1.7682
    // Formula 5, Al-Kuhaili 2004: 1.875 + 6.28e-3 / L^2 + 5.80e-4 / L^4.
    EXPECT_NEAR(IndexOf("HfO2", 500.0).real(), 1.875 + 6.28e-3 / 0.25 + 5.80e-4 / 0.0625, 1e-14);
}

// Points of the measured tables before they were thinned, most of which were left out.
TEST(CoatingMaterial, KeepsToMeasuredTables) {
    struct Point {
        const char* name;
        double nm, n, k;
    };
    for (const Point& p : {Point{"TiO2-Siefke", 360.857988, 2.915807649, 0.026907082},
                           {"TiO2-Siefke", 386.666301, 2.738236524, 0.002133294},
                           {"TiO2-Siefke", 400.254593, 2.680116861, 0.000633834},
                           {"TiO2-Siefke", 549.333803, 2.436329289, 5.55e-8},
                           {"TiO2-Siefke", 699.57829, 2.365403507, 1.73e-10},
                           {"TiO2-Sarkar", 450.0, 2.247783, 0.0},
                           {"Ta2O5-Gao", 376.0, 2.275751, 0.000456},
                           {"Ta2O5-Gao", 450.0, 2.204562, 0.000158},
                           {"Ta2O5-Gao", 700.0, 2.124149, 0.0}}) {
        EXPECT_NEAR(IndexOf(p.name, p.nm).real(), p.n, 3.1e-5) << p.name << " " << p.nm;
        EXPECT_NEAR(IndexOf(p.name, p.nm).imag(), p.k, 3.1e-6) << p.name << " " << p.nm;
    }
    EXPECT_EQ(IndexOf("TiO2", 500.0), IndexOf("TiO2-Siefke", 500.0));
    EXPECT_EQ(IndexOf("Ta2O5", 500.0), IndexOf("Ta2O5-Gao", 500.0));
}

TEST(CoatingMaterial, KeepsItsLastIndexBeyondItsData) {
    EXPECT_EQ(IndexOf("Ta2O5", 300.0), IndexOf("Ta2O5", 360.0));
    EXPECT_EQ(IndexOf("Ta2O5", 1100.0), IndexOf("Ta2O5", 800.0));
    // Fitted to 405-635 nm, used to the ends of the visible, no further.
    EXPECT_NE(IndexOf("ZrO2", 361.0), IndexOf("ZrO2", 360.0));
    EXPECT_EQ(IndexOf("ZrO2", 300.0), IndexOf("ZrO2", 360.0));
    for (double nm = 300.0; nm <= 1100.0; nm += 1.0) {
        for (const char* name : {"MgF2", "SiO2", "TiO2", "TiO2-Sarkar", "Al2O3", "ZrO2", "Ta2O5",
                                 "HfO2", "Y2O3", "LaF3", "CaF2"}) {
            const Complex n = IndexOf(name, nm);
            ASSERT_TRUE(n.real() > 1.3 && n.real() < 3.0 && n.imag() >= 0.0) << name << nm;
        }
    }
}

TEST(CoatingMaterial, MayBeAConstant) {
    const CoatingMaterial glass(1.46), metal(Complex(0.2, 3.4));
    EXPECT_EQ(glass.Index(400.0), Complex(1.46));
    EXPECT_EQ(metal.Index(700.0), Complex(0.2, 3.4));
    EXPECT_EQ(glass.name(), "n 1.46");
    EXPECT_EQ(metal.name(), "n 0.2 + 3.4i");
    EXPECT_EQ(MaterialByName("MgF2")->name(), "MgF2-Li-o");
    EXPECT_NE(glass, metal);
    EXPECT_NE(*MaterialByName("TiO2"), *MaterialByName("TiO2-Sarkar"));
    EXPECT_EQ(*MaterialByName("TiO2"), *MaterialByName("TiO2-Siefke"));
}

TEST(CoatingMaterial, UnknownNamesAreRefusedWithTheKnownOnes) {
    for (const char* name : {"", "Unobtainium", "mgf2", "MgF2-", "TiO2-Gao", "MgF"}) {
        const auto material = MaterialByName(name);
        ASSERT_FALSE(material.ok()) << name;
        EXPECT_NE(material.error().message.find("TiO2 (Siefke, Sarkar)"), std::string::npos)
            << material.error().message;
    }
}

}  // namespace
}  // namespace flare
