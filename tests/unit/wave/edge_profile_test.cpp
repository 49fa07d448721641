// SPDX-License-Identifier: Apache-2.0
//
// Profiles beside an edge against known figures, the disc's against the propagator and its closed
// form on the axis, and the light that tables keep.
#include "core/wave/edge_profile.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"
#include "core/wave/coverage.h"
#include "core/wave/propagation.h"

namespace flare {
namespace {

TEST(KnifeEdge, HasTheKnownExtremesAndTails) {
    EXPECT_NEAR(KnifeEdge(0.0), 0.25, 1e-9);
    EXPECT_NEAR(KnifeEdge(1.2172), 1.370443, 5e-5);
    EXPECT_NEAR(KnifeEdge(1.8725), 0.778251, 5e-5);
    EXPECT_LT(KnifeEdge(1.2172 - 0.02), KnifeEdge(1.2172));
    EXPECT_LT(KnifeEdge(1.2172 + 0.02), KnifeEdge(1.2172));
    // In the dark only the edge's own wave: 1 / (2 pi^2 v^2).
    for (const double v : {-29.9, -30.1, -100.0})
        EXPECT_NEAR(KnifeEdge(v) * 2.0 * kPi * kPi * v * v, 1.0, 1e-3) << v;
    EXPECT_NEAR(KnifeEdge(40.0), 1.0, 0.02);
}

TEST(DiscPattern, IsTheClosedFormOnTheAxisAndContinuousAtTheEdge) {
    for (const double n : {0.1, 0.7, 1.0, 2.0, 7.3, 31.0, 64.0}) {
        const double expected = 4.0 * std::pow(std::sin(0.5 * kPi * n), 2);
        EXPECT_NEAR(DiscPattern(n, 0.0), expected, 1e-9) << n;
        EXPECT_NEAR(DiscPattern(n, 1e-6), expected, 1e-6) << n;
        EXPECT_NEAR(DiscPattern(n, 1.0 - 1e-9), DiscPattern(n, 1.0 + 1e-9), 1e-6) << n;
    }
}

TEST(DiscPattern, IsWhatThePropagatorGives) {
    constexpr int kSide = 512;
    constexpr double kWavelength_mm = 550e-6;
    Loop circle;
    for (int i = 0; i < 2000; ++i) {
        const double angle = 2.0 * kPi * i / 2000;
        circle.push_back({std::cos(angle), std::sin(angle)});
    }
    WaveField field{kSide, 4.0 / kSide, {}};
    const std::vector<double> mask = Sharpened(Coverage({circle}, kSide, field.pitch_mm), kSide);
    field.values.assign(mask.begin(), mask.end());
    ThreadPool threads(1);
    for (const double n : {1.5, 6.0, 20.0}) {
        const WaveField out = Propagate(field, kWavelength_mm, 1.0 / (kWavelength_mm * n),
                                        Propagator::kChirp, threads);
        for (int i = 0; i < kSide / 2; i += 7) {
            const double rho = i * out.pitch_mm;
            if (rho > 1.6) break;
            const double value = std::norm(out.At(kSide / 2 + i, kSide / 2));
            EXPECT_NEAR(value, DiscPattern(n, rho), 0.02) << n << " at " << rho;
        }
    }
}

double Last(const std::vector<float>& sums) {
    return static_cast<double>(sums.back());
}

TEST(EdgeTable, OfAStraightEdgeKeepsTheLight) {
    for (const double bandwidth : {0.0, 0.06, 0.3}) {
        for (const double source : {0.0, 0.3}) {
            for (const double weight : {1.0, 0.4}) {
                EdgeProfileSpec spec;
                spec.relative_bandwidth = bandwidth;
                spec.source_t = source;
                spec.weight = weight;
                spec.wavelength_ratio = 1.2;
                const std::vector<float> sums = EdgeTable(spec);
                const double end_t =
                    static_cast<double>(sums.size() - 1) * spec.step_t - spec.dark_t;
                EXPECT_NEAR(Last(sums) * spec.step_t, end_t, 1e-4);
                for (std::size_t i = 1; i < sums.size(); ++i)
                    EXPECT_GE(sums[i] - sums[i - 1], -1e-5F);
            }
        }
    }
}

TEST(EdgeTable, OfADiscKeepsItsLight) {
    for (const double n : {0.4, 3.0, 40.0}) {
        EdgeProfileSpec spec;
        spec.disc_fresnel_number = n;
        spec.lit_t = std::sqrt(2.0 * n);
        const std::vector<float> sums = EdgeTable(spec);
        double light = 0.0;
        for (std::size_t i = 1; i < sums.size(); ++i) {
            const double t = -spec.dark_t + (static_cast<double>(i) - 0.5) * spec.step_t;
            if (t >= spec.lit_t) continue;
            light += static_cast<double>(sums[i] - sums[i - 1]) * (spec.lit_t - t) * spec.step_t;
        }
        EXPECT_NEAR(light / (0.5 * spec.lit_t * spec.lit_t), 1.0, 2e-3) << n;
    }
}

TEST(EdgeTable, WithoutWeightIsTheSharpEdge) {
    EdgeProfileSpec spec;
    spec.weight = 0.0;
    const std::vector<float> sums = EdgeTable(spec);
    const auto count = static_cast<int>(sums.size());
    for (const double half : {1.0, 20.0}) {
        for (double place = 40.0; place < 250.0; place += 13.0) {
            const double edge = spec.dark_t / spec.step_t;
            const double expected = std::clamp(0.5 + (place - edge) / (2.0 * half), 0.0, 1.0);
            EXPECT_NEAR(TableMean(sums.data(), count, place, half), expected, 1e-5);
        }
    }
}

// A band of wavelengths against the mean of many.
TEST(EdgeTable, OfABandIsTheMeanOverIt) {
    constexpr int kMany = 100;
    EdgeProfileSpec spec;
    spec.relative_bandwidth = 0.1;
    const std::vector<float> band = EdgeTable(spec);
    std::vector<double> mean(band.size(), 0.0);
    spec.relative_bandwidth = 0.0;
    for (int k = 0; k < kMany; ++k) {
        spec.wavelength_ratio = 1.0 + 0.1 * ((k + 0.5) / kMany - 0.5);
        const std::vector<float> one = EdgeTable(spec);
        for (std::size_t i = 0; i < mean.size(); ++i)
            mean[i] += static_cast<double>(one[i]) / kMany;
    }
    double most = 0.0, fringes = 0.0;
    for (std::size_t i = 1; i < mean.size(); ++i) {
        const double profile = mean[i] - mean[i - 1];
        most = std::max(most, std::abs(static_cast<double>(band[i] - band[i - 1]) - profile));
        const double t = static_cast<double>(i) * spec.step_t - spec.dark_t;
        if (t > 4.5) fringes = std::max(fringes, std::abs(profile - 1.0));
    }
    EXPECT_LT(most, 0.01);
    EXPECT_LT(fringes, 0.06);
}

}  // namespace
}  // namespace flare
