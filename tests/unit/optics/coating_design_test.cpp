// SPDX-License-Identifier: Apache-2.0
//
// The built-in designs against closed forms, against the figures of the program that designed the
// multilayer, and against each other.
#include "core/optics/coating_design.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <sstream>

#include "core/base/units.h"

namespace flare {
namespace {

using Complex = std::complex<double>;

Coating Laid(const std::string& name, double substrate, double rare = 1.0) {
    return BuiltInCoating(name)->For(Glass::FromNdVd(rare, {}), Glass::FromNdVd(substrate, {}));
}

Reflection At(const Coating& coating, double substrate, double angle_deg, double wavelength_nm) {
    return ReflectionOf(coating, false, 1.0, substrate, std::cos(RadiansFromDegrees(angle_deg)),
                        wavelength_nm);
}

double MeanReflectance(const Coating& coating, double substrate, double angle_deg) {
    double sum = 0.0;
    for (int i = 0; i <= 60; ++i)
        sum += At(coating, substrate, angle_deg, 400.0 + 5.0 * i).reflectance;
    return sum / 61.0;
}

TEST(CoatingDesign, SingleLayerIsAQuarterWaveOf138) {
    const Coating coating = Laid("mgf2-550", 1.67);
    ASSERT_EQ(coating.layers.size(), 1U);
    EXPECT_EQ(coating.layers[0].thickness_nm, 550.0 / 4.0 / 1.38);
    EXPECT_EQ(coating.layers[0].material.Index(430.0), Complex(1.38));
    const Coating dispersive = Laid("mgf2-disp-550", 1.67);
    const double n = dispersive.layers.at(0).material.Index(550.0).real();
    EXPECT_NEAR(n, 1.3785, 1e-4);
    EXPECT_DOUBLE_EQ(dispersive.layers[0].thickness_nm * n, 137.5);
}

// Also on a real glass, whose index at the design wavelength is not n_d.
TEST(CoatingDesign, VCoatHasNoReflectanceAtItsWavelength) {
    for (const int nm : {300, 450, 550, 633, 1100}) {
        for (const double nd : {1.40, 1.45, 1.5168, 1.62, 1.75, 1.85, 1.92, 2.0, 2.4}) {
            const Glass glass = Glass::FromNdVd(nd, 30.0);
            const Coating coating =
                BuiltInCoating("v-" + std::to_string(nm))->For(Glass::Air(), glass);
            ASSERT_EQ(coating.layers.size(), 2U);
            EXPECT_EQ(coating.note, "");
            EXPECT_LT(ReflectionOf(coating, false, 1.0, glass.Index(nm), 1.0, nm).reflectance,
                      1e-12)
                << nd << " " << nm;
            // No thicker than the thinner solution can be.
            EXPECT_GT(coating.layers[0].thickness_nm, 0.0);
            EXPECT_LT(coating.layers[0].thickness_nm + coating.layers[1].thickness_nm, 0.5 * nm);
        }
    }
}

TEST(CoatingDesign, VCoatBetweenGlassesSaysThatItHasNoZero) {
    const Coating coating = Laid("v-550", 1.7, 1.5);
    EXPECT_NE(coating.note.find("two quarter waves"), std::string::npos);
    ASSERT_EQ(coating.layers.size(), 2U);
    for (const CoatingLayer& layer : coating.layers) {
        EXPECT_NEAR(layer.thickness_nm * layer.material.Index(550.0).real(), 137.5, 1e-12);
    }
}

// At the design wavelength the half wave is absent, and two quarter waves turn the substrate's
// admittance ns into (n1 / n3)^2 ns.
TEST(CoatingDesign, QuarterHalfQuarterHasItsClosedForm) {
    for (const int nm : {420, 550, 700}) {
        for (const double ns : {1.45, 1.52, 1.67, 1.85, 2.0}) {
            Coating coating = Laid("broadband-" + std::to_string(nm), ns);
            ASSERT_EQ(coating.layers.size(), 3U);
            const double n1 = coating.layers[0].material.Index(nm).real();
            const double n3 = coating.layers[2].material.Index(nm).real();
            const double y = std::pow(n1 / n3, 2) * ns;
            const double want = std::pow((1.0 - y) / (1.0 + y), 2);
            EXPECT_NEAR(At(coating, ns, 0.0, nm).reflectance, want, 1e-14) << ns;
            EXPECT_LT(want, 0.005) << "the inner layer must suit the glass";
            coating.layers.erase(coating.layers.begin() + 1);
            EXPECT_NEAR(At(coating, ns, 0.0, nm).reflectance, want, 1e-14) << ns;
        }
    }
}

// The designing program works in another language with its own matrices; its figure stands beside
// each stack: mean over 400-700 nm in steps of 12.5 and 0, 15, 30, 45 degrees.
TEST(CoatingDesign, MultilayerHasTheReflectanceItWasDesignedFor) {
    std::ifstream file(FLARE_SOURCE_DIR "/lenses/coatings/multilayer.tsv");
    int stacks = 0;
    for (std::string line; std::getline(file, line);) {
        if (line.empty() || line[0] == '#') continue;
        const double substrate = std::stod(line);
        const double claimed = std::stod(line.substr(line.rfind('\t')));
        const Coating coating = Laid("multi-550", substrate);
        double sum = 0.0;
        for (int i = 0; i < 25; ++i) {
            for (const double angle : {0.0, 15.0, 30.0, 45.0}) {
                sum += At(coating, substrate, angle, 400.0 + 12.5 * i).reflectance;
            }
        }
        EXPECT_NEAR(sum / 100.0, claimed, 1e-6) << substrate;
        ++stacks;
    }
    EXPECT_EQ(stacks, 7);
    // Another design wavelength scales it; glasses in between take the nearest stack.
    EXPECT_NEAR(Laid("multi-600", 1.60).layers[0].thickness_nm,
                Laid("multi-550", 1.60).layers[0].thickness_nm * 600.0 / 550.0, 1e-12);
    EXPECT_EQ(Laid("multi-550", 1.62).layers, Laid("multi-550", 1.60).layers);
    EXPECT_NE(Laid("multi-550", 1.65).layers, Laid("multi-550", 1.60).layers);
}

// More layers reflect less over the visible. The figures are those of docs/physics/coatings.md.
TEST(CoatingDesign, MoreLayersReflectLessOverTheVisible) {
    std::printf("mean reflectance over 400-700 nm in %%, at 0 and at 45 degrees\n");
    for (const double ns : {1.52, 1.67, 1.85}) {
        std::array<double, 5> mean{};
        const std::array<const char*, 5> names{"bare", "mgf2-550", "v-550", "broadband-550",
                                               "multi-550"};
        std::printf("n %.2f", ns);
        for (std::size_t i = 0; i < names.size(); ++i) {
            mean[i] = MeanReflectance(Laid(names[i], ns), ns, 0.0);
            std::printf("  %s %.2f %.2f", names[i], 100.0 * mean[i],
                        100.0 * MeanReflectance(Laid(names[i], ns), ns, 45.0));
        }
        std::printf("\n");
        EXPECT_LT(mean[1], 0.4 * mean[0]);
        EXPECT_LT(mean[2], mean[0]) << "a V-coat is for one wavelength";
        EXPECT_LT(mean[3], mean[1]);
        EXPECT_LT(mean[4], mean[3]);
        EXPECT_LT(mean[4], 0.004);
    }
}

TEST(CoatingDesign, KeepsTheLightUnlessItsMaterialsAbsorb) {
    for (const char* name : {"mgf2-disp-550", "v-550", "broadband-550", "multi-550"}) {
        for (const double ns : {1.45, 1.67, 2.0}) {
            const Coating coating = Laid(name, ns);
            for (const double wavelength : {380.0, 420.0, 550.0, 700.0}) {
                for (const double angle : {0.0, 40.0, 75.0, 89.0}) {
                    const double c = std::cos(RadiansFromDegrees(angle));
                    const double inside = std::sqrt(1.0 - (1.0 - c * c) / (ns * ns));
                    const Reflection in = ReflectionOf(coating, false, 1.0, ns, c, wavelength);
                    const Reflection out = ReflectionOf(coating, true, ns, 1.0, inside, wavelength);
                    EXPECT_NEAR(in.transmittance, out.transmittance, 1e-12);
                    const double kept = in.reflectance + in.transmittance;
                    const bool absorbs = std::string(name) == "multi-550" && wavelength < 600.0;
                    if (absorbs) {
                        EXPECT_LT(kept, 1.0 - 1e-6);
                        EXPECT_GT(kept, 0.99);
                        EXPECT_GT(std::abs(in.reflectance - out.reflectance), 1e-7);
                    } else {
                        EXPECT_NEAR(kept, 1.0, 1e-12) << name << wavelength;
                        EXPECT_NEAR(in.reflectance, out.reflectance, 1e-12);
                    }
                }
            }
        }
    }
}

TEST(CoatingDesign, NamesThatAreNotOnesAreRefusedWithTheKnownOnes) {
    for (const char* name :
         {"", "v", "v-", "v-299", "v-1101", "V-550", "broadband", "broadband-55x", "multi",
          "multi--550", "mgf2-disp", "mgf2-disp-", "mgf2_550", "gold"}) {
        const Result<CoatingDesign> design = BuiltInCoating(name);
        ASSERT_FALSE(design.ok()) << name;
        for (const char* known :
             {"mgf2-NNN", "v-NNN", "broadband-NNN", "multi-NNN", "300 to 1100"}) {
            EXPECT_NE(design.error().message.find(known), std::string::npos);
        }
    }
    EXPECT_TRUE(Laid("none", 1.5).bare());
    EXPECT_EQ(BuiltInCoating("v-480")->name(), "v-480");
}

TEST(CoatingDesign, ImpossibleLayersAreRefused) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    const CoatingLayer bad[] = {{0.0, 10.0},
                                {-1.5, 10.0},
                                {kNan, 10.0},
                                {11.0, 10.0},
                                {1.5, -1e-9},
                                {1.5, kNan},
                                {1.5, 2e5},
                                {Complex(1.5, -0.1), 10.0},
                                {Complex(1.5, 11.0), 10.0}};
    for (const CoatingLayer& layer : bad) {
        const auto design = CoatingDesign::Stack("x", {{1.38, 100.0}, layer});
        ASSERT_FALSE(design.ok());
        EXPECT_NE(design.error().message.find("layer 1"), std::string::npos);
    }
    EXPECT_TRUE(CoatingDesign::Stack("x", std::vector<CoatingLayer>(100, {1.5, 0.0})).ok());
    EXPECT_FALSE(CoatingDesign::Stack("x", std::vector<CoatingLayer>(101, {1.5, 0.0})).ok());
    EXPECT_FALSE(CoatingDesign::Stack("none", {{1.5, 10.0}}).ok());
}

TEST(CoatingDesign, OwnCoatingsAreFoundBeforeBuiltInOnes) {
    CoatingDefinitions own;
    own["amber"] = *CoatingDesign::Stack("amber", {{1.38, 82.0}});
    own["mgf2-550"] = *CoatingDesign::Stack("mgf2-550", {{1.4, 90.0}});
    EXPECT_EQ(CoatingDesignByName("amber", own)->layers().at(0).thickness_nm, 82.0);
    EXPECT_EQ(CoatingDesignByName("mgf2-550", own)->layers().at(0).thickness_nm, 90.0);
    EXPECT_EQ(CoatingDesignByName("mgf2-560", own)->name(), "mgf2-560");
    const auto unknown = CoatingDesignByName("gold", own);
    ASSERT_FALSE(unknown.ok());
    EXPECT_NE(unknown.error().message.find("amber, mgf2-550"), std::string::npos);
}

TEST(CoatingFingerprint, NamesTheLayersAndNothingElse) {
    const auto print = [](const Coating& coating) {
        Fingerprinter fingerprinter;
        coating.AddTo(fingerprinter);
        return fingerprinter.value();
    };
    const Coating a = Laid("multi-550", 1.60);
    Coating b = a;
    b.name = "another";
    EXPECT_EQ(print(a), print(b));
    b.layers[3].thickness_nm += 0.01;
    EXPECT_NE(print(a), print(b));
    b = a;
    b.layers[1].material = *MaterialByName("TiO2");
    EXPECT_NE(print(a), print(b));
    b = a;
    std::swap(b.layers[1], b.layers[2]);
    EXPECT_NE(print(a), print(b));
    EXPECT_NE(print({"x", {{Complex(1.5, 0.1), 9.0}}, ""}), print({"x", {{1.5, 9.0}}, ""}));
}

}  // namespace
}  // namespace flare
