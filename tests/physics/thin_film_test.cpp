// SPDX-License-Identifier: Apache-2.0
//
// Coatings against closed forms and against another method: amplitudes summed layer by layer
// (Rouard / Parratt recursion), where the core multiplies characteristic matrices.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "core/base/units.h"
#include "core/optics/coating_design.h"
#include "core/optics/paraxial.h"
#include "core/tracing/trace_reference.h"
#include "tests/support/lenses.h"
#include "tests/support/random.h"

namespace flare {
namespace {

using Complex = std::complex<double>;

Coating Layers(std::vector<CoatingLayer> layers) {
    return {"test", std::move(layers), ""};
}

Coating Mgf2() {
    return BuiltInCoating("mgf2-550")->For(Glass::Air(), Glass::FromNdVd(1.67, {}));
}

// Fresnel from the textbook, with real cosines.
Reflection Fresnel(double n1, double n2, double cos1) {
    const double sin2 = n1 / n2 * std::sqrt(1.0 - cos1 * cos1);
    if (sin2 >= 1.0) return {1.0, 0.0};
    const double cos2 = std::sqrt(1.0 - sin2 * sin2);
    const double rs = (n1 * cos1 - n2 * cos2) / (n1 * cos1 + n2 * cos2);
    const double rp = (n2 * cos1 - n1 * cos2) / (n2 * cos1 + n1 * cos2);
    const double ts = 2.0 * n1 * cos1 / (n1 * cos1 + n2 * cos2);
    const double tp = 2.0 * n1 * cos1 / (n2 * cos1 + n1 * cos2);
    const double share = n2 * cos2 / (n1 * cos1);
    return {0.5 * (rs * rs + rp * rp), 0.5 * share * (ts * ts + tp * tp)};
}

// Reflectance by recursion from the last interface to the first: r = (r_j + r' e^2ib)/(1 + r_j r'
// e^2ib).
double RecursiveReflectance(const std::vector<CoatingLayer>& in_order, double n_in, double n_out,
                            double cos_in, double wavelength_nm) {
    const double tangential = n_in * n_in * (1.0 - cos_in * cos_in);
    std::vector<Complex> index{n_in};
    for (const CoatingLayer& layer : in_order) index.push_back(layer.material.Index(wavelength_nm));
    index.emplace_back(n_out);
    const auto normal = [&](Complex n) {
        const Complex q = std::sqrt(n * n - tangential);
        return q.imag() < 0.0 ? -q : q;
    };
    double sum = 0.0;
    for (const bool p : {false, true}) {
        const auto admittance = [&](Complex n) { return p ? n * n / normal(n) : normal(n); };
        Complex r = 0.0;
        for (std::size_t j = index.size() - 1; j-- > 0;) {
            const Complex a = admittance(index[j]), b = admittance(index[j + 1]);
            const Complex step = (a - b) / (a + b);
            if (j + 1 < index.size() - 1) {
                const double k = 2.0 * kPi / wavelength_nm * in_order[j].thickness_nm;
                r *= std::exp(Complex(0.0, 2.0) * normal(index[j + 1]) * k);
            }
            r = (step + r) / (1.0 + step * r);
        }
        sum += std::norm(r);
    }
    return 0.5 * sum;
}

TEST(ThinFilm, QuarterWaveHasItsClosedFormBothWays) {
    const Coating quarter = Layers({{1.38, 550.0 / 4.0 / 1.38}});
    const double expected = std::pow((1.67 - 1.38 * 1.38) / (1.67 + 1.38 * 1.38), 2);
    EXPECT_NEAR(expected, 0.004300400580593, 1e-15);
    EXPECT_NEAR(ReflectionOf(quarter, false, 1.0, 1.67, 1.0, 550.0).reflectance, expected, 1e-13);
    EXPECT_NEAR(ReflectionOf(quarter, true, 1.67, 1.0, 1.0, 550.0).reflectance, expected, 1e-13);
    // The named coating is that layer, with its thickness rounded to 0.01 nm in name only.
    EXPECT_NEAR(ReflectionOf(Mgf2(), false, 1.0, 1.67, 1.0, 550.0).reflectance, expected, 1e-9);
    EXPECT_NEAR(Mgf2().layers.at(0).thickness_nm, 99.64, 0.005);
}

TEST(ThinFilm, HalfWaveZeroThicknessAndNoLayersAreBareGlass) {
    for (const double angle : {0.0, 20.0, 45.0, 70.0, 89.0}) {
        const double c = std::cos(RadiansFromDegrees(angle));
        const Reflection bare = Fresnel(1.0, 1.67, c);
        const auto expect_bare = [&](const Coating& coating, double tolerance) {
            const Reflection r = ReflectionOf(coating, false, 1.0, 1.67, c, 550.0);
            EXPECT_NEAR(r.reflectance, bare.reflectance, tolerance) << angle;
            EXPECT_NEAR(r.transmittance, bare.transmittance, tolerance) << angle;
        };
        // Half a wave at this angle: n d cos(theta_1) = lambda / 2.
        const double cos1 = std::sqrt(1.0 - (1.0 - c * c) / (1.38 * 1.38));
        expect_bare(Layers({{1.38, 550.0 / 2.0 / 1.38 / cos1}}), 1e-13);
        expect_bare(Layers({{1.38, 0.0}}), 1e-14);
        expect_bare(Layers({{1.38, 0.0}, {2.1, 0.0}}), 1e-14);
        expect_bare(Layers({{1.67, 123.4}}), 1e-13);
        expect_bare(Layers({{1.0, 77.7}}), 1e-13);
        expect_bare({}, 1e-14);
    }
}

TEST(ThinFilm, BareGlassIsFresnelFromBothSides) {
    for (double angle = 0.0; angle < 89.95; angle += 0.1) {
        const double c = std::cos(RadiansFromDegrees(angle));
        for (const auto& [n1, n2] : {std::pair{1.0, 1.5168}, {1.717, 1.0}, {1.67, 1.699}}) {
            const Reflection want = Fresnel(n1, n2, c);
            const Reflection got = ReflectionOf({}, n1 > n2, n1, n2, c, 550.0);
            EXPECT_NEAR(got.reflectance, want.reflectance, 6e-14) << angle << " " << n1;
            EXPECT_NEAR(got.transmittance, want.transmittance, 6e-14) << angle << " " << n1;
        }
    }
    // Brewster: p vanishes, and only half of s is left.
    const double brewster = std::cos(std::atan(1.5));
    const double rs = std::pow((1.5 * 1.5 - 1.0) / (1.5 * 1.5 + 1.0), 2);
    EXPECT_NEAR(ReflectionOf({}, false, 1.0, 1.5, brewster, 550.0).reflectance, 0.5 * rs, 1e-15);
}

TEST(ThinFilm, NothingIsLostUpTo89_9Degrees) {
    const Coating broadband = Layers({{1.38, 99.6}, {2.1, 130.9}, {1.62, 84.9}});
    for (const Coating& coating : {Coating{}, Mgf2(), broadband}) {
        for (const double wavelength : {400.0, 550.0, 700.0}) {
            for (double angle = 0.0; angle < 89.95; angle += 0.1) {
                const double c = std::cos(RadiansFromDegrees(angle));
                const Reflection in = ReflectionOf(coating, false, 1.0, 1.67, c, wavelength);
                EXPECT_NEAR(in.reflectance + in.transmittance, 1.0, 1e-14) << angle;
                const Reflection out = ReflectionOf(coating, true, 1.67, 1.0, c, wavelength);
                EXPECT_NEAR(out.reflectance + out.transmittance, 1.0, 1e-14) << angle;
            }
        }
    }
}

TEST(ThinFilm, OneLayerIsTheAirySum) {
    testing::Random random(3);
    for (int i = 0; i < 500; ++i) {
        const double n1 = random.Uniform(1.1, 2.4), d = random.Uniform(1.0, 600.0);
        const double n2 = random.Uniform(1.4, 1.9), c = random.Uniform(0.01, 1.0);
        const double wavelength = random.Uniform(380.0, 780.0);
        const std::vector<CoatingLayer> layer{{n1, d}};
        EXPECT_NEAR(ReflectionOf(Layers(layer), false, 1.0, n2, c, wavelength).reflectance,
                    RecursiveReflectance(layer, 1.0, n2, c, wavelength), 1e-13);
        EXPECT_NEAR(ReflectionOf(Layers(layer), true, n2, 1.0, c, wavelength).reflectance,
                    RecursiveReflectance(layer, n2, 1.0, c, wavelength), 1e-12);
    }
}

// Layers are listed from the low-index side: from the other side they come in reverse order.
TEST(ThinFilm, ManyLayersFollowTheRecursionInBothDirections) {
    testing::Random random(4);
    for (int round = 0; round < 100; ++round) {
        std::vector<CoatingLayer> layers;
        for (int k = random.Below(12) + 2; k > 0; --k) {
            layers.push_back({Complex(random.Uniform(1.3, 2.4), round % 2 == 0 ? 0.0 : 0.02),
                              random.Uniform(10.0, 200.0)});
        }
        const std::vector<CoatingLayer> reversed(layers.rbegin(), layers.rend());
        const double c = random.Uniform(0.05, 1.0);
        EXPECT_NEAR(ReflectionOf(Layers(layers), false, 1.0, 1.6, c, 520.0).reflectance,
                    RecursiveReflectance(layers, 1.0, 1.6, c, 520.0), 1e-11);
        EXPECT_NEAR(ReflectionOf(Layers(layers), true, 1.6, 1.0, c, 520.0).reflectance,
                    RecursiveReflectance(reversed, 1.6, 1.0, c, 520.0), 1e-11);
    }
}

TEST(ThinFilm, TransmittanceIsTheSameBothWays) {
    testing::Random random(5);
    for (const double absorption : {0.0, 0.01, 0.3}) {
        for (int i = 0; i < 200; ++i) {
            const Coating coating = Layers({{Complex(1.38, absorption), 99.64},
                                            {Complex(random.Uniform(1.6, 2.3), 0.0), 60.0}});
            const double cos_air = random.Uniform(0.01, 1.0);
            const double sin_glass = std::sqrt(1.0 - cos_air * cos_air) / 1.67;
            const double cos_glass = std::sqrt(1.0 - sin_glass * sin_glass);
            const Reflection in = ReflectionOf(coating, false, 1.0, 1.67, cos_air, 500.0);
            const Reflection out = ReflectionOf(coating, true, 1.67, 1.0, cos_glass, 500.0);
            EXPECT_NEAR(in.transmittance, out.transmittance, 1e-12);
            if (absorption == 0.0) {
                EXPECT_NEAR(in.reflectance, out.reflectance, 1e-12);
            }
        }
    }
}

TEST(ThinFilm, AnAbsorbingLayerKeepsItsShare) {
    const Coating lossy = Layers({{Complex(1.38, 0.01), 550.0 / 4.0 / 1.38}});
    const Reflection r = ReflectionOf(lossy, false, 1.0, 1.67, 1.0, 550.0);
    EXPECT_NEAR(r.reflectance + r.transmittance, 0.9773, 1e-4);
    // A thick absorber is Beer's law between its two faces, multiple reflections being absorbed
    // away.
    const double kappa = 0.05, thickness = 20'000.0;
    const Coating thick = Layers({{Complex(1.67, kappa), thickness}});
    const Reflection t = ReflectionOf(thick, false, 1.0, 1.67, 1.0, 550.0);
    const double beer = std::exp(-4.0 * kPi * kappa * thickness / 550.0);
    EXPECT_NEAR(t.transmittance / beer, 1.0 - std::pow(0.67 / 2.67, 2), 2e-3);
}

// Axial transmittance of the seed lens, traced; figures from an independent program.
TEST(AxialTransmittance, OfTheSeedLensIsThatOfItsTracedRay) {
    const auto coated = testing::LibraryLens(testing::kSeedName);
    const auto bare = coated->WithBareGlass();
    const auto traced = [](const Lens& lens, double wavelength) {
        const InteractionList list = WriteOut(lens, {}, wavelength);
        RayRecord record;
        TraceRay(list, {Vec3d(0.0, 0.0, -5.0), Vec3d(0.0, 0.0, 1.0)}, {}, &record);
        return PathWeight(lens, list, record);
    };
    const std::pair<double, double> known[] = {
        {450.0, 0.912339}, {550.0, 0.967423}, {650.0, 0.937865}};
    for (const auto& [wavelength, transmittance] : known) {
        EXPECT_NEAR(traced(*coated, wavelength), transmittance, 1e-5);
        EXPECT_NEAR(AxialTransmittance(*coated, wavelength), transmittance, 1e-5);
    }
    EXPECT_NEAR(traced(*bare, kLineD), 0.589977, 1e-6);
    EXPECT_NEAR(AxialTransmittance(*bare, kLineD), 0.589977, 1e-6);
}

}  // namespace
}  // namespace flare
