// SPDX-License-Identifier: Apache-2.0
//
// The propagators against closed forms: knife edge, circular aperture on its axis, Arago's spot,
// Talbot's distance, Airy's pattern, energy, and against each other.
#include "core/wave/propagation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"
#include "core/wave/coverage.h"

namespace flare {
namespace {

constexpr double kWavelength_mm = 550e-6;

WaveField FieldOf(int side, double pitch_mm) {
    const auto n = static_cast<std::size_t>(side);
    return {side, pitch_mm, std::vector<Complex>(n * n)};
}

Loop Circle(double radius) {
    Loop loop;
    for (int i = 0; i < 2000; ++i) {
        const double angle = 2.0 * kPi * i / 2000;
        loop.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    return loop;
}

// A disc of radius 1 mm.
WaveField Disc(int side, double width_mm) {
    WaveField field = FieldOf(side, width_mm / side);
    const std::vector<double> samples =
        Sharpened(Coverage({Circle(1.0)}, side, field.pitch_mm), side);
    std::copy(samples.begin(), samples.end(), field.values.begin());
    return field;
}

double OnAxis(const WaveField& field) {
    return std::norm(field.At(field.side / 2, field.side / 2));
}

// 1 up to `inner`, 0 from `outer` on, without an edge that would diffract.
double Soft(double x, double inner, double outer) {
    if (x <= inner) return 1.0;
    if (x >= outer) return 0.0;
    return 0.5 + 0.5 * std::cos(kPi * (x - inner) / (outer - inner));
}

TEST(KnifeEdge, HasTheFresnelIntegralsFringes) {
    // v = x sqrt(2 / (lambda z)); samples are 1/8 of v apart.
    constexpr int kSide = 1024;
    WaveField field = FieldOf(kSide, 1e-3);
    const double z = 2.0 * std::pow(8.0 * field.pitch_mm, 2) / kWavelength_mm;
    std::vector<double> edge;
    for (int i = 0; i < kSide * kSide; ++i) {
        const int x = i % kSide - kSide / 2;
        edge.push_back(x < 0 ? 0.0 : x == 0 ? 0.5 : Soft(x, kSide / 4, kSide / 2 - 1));
    }
    edge = Sharpened(edge, kSide);
    std::copy(edge.begin(), edge.end(), field.values.begin());
    ThreadPool threads(1);
    ASSERT_EQ(PropagatorFor(field, kWavelength_mm, z), Propagator::kTransferFunction);
    const WaveField out =
        Propagate(field, kWavelength_mm, z, Propagator::kTransferFunction, threads);
    const auto intensity = [&](int x) { return std::norm(out.At(kSide / 2 + x, 5)); };
    // The extreme of the parabola through the samples next to v = x / 8.
    const auto extreme = [&](int x) {
        const double a = intensity(x - 1), b = intensity(x), c = intensity(x + 1);
        const double shift = 0.5 * (a - c) / (a - 2.0 * b + c);
        return Vec2d((x + shift) / 8.0, b - 0.25 * (a - c) * shift);
    };
    EXPECT_NEAR(intensity(0), 0.25, 0.25 * 0.01);
    EXPECT_NEAR(extreme(10).y, 1.370443, 1.37 * 0.003);
    EXPECT_NEAR(extreme(10).x, 1.2172, 1.2172 * 0.01);
    EXPECT_NEAR(extreme(15).y, 0.778251, 0.778 * 0.01);
    EXPECT_NEAR(extreme(15).x, 1.8725, 1.8725 * 0.01);
}

// 4 sin^2(pi N_F / 2) for N_F = a^2 / (lambda z).
TEST(CircularAperture, OnItsAxisIsRightToAThousandthOfThePeak) {
    ThreadPool threads(1);
    const WaveField disc = Disc(1024, 2.5);
    for (const double fresnel_number : {0.1, 1.0, 3.3, 17.0, 31.5, 49.0, 64.0}) {
        const double z = 1.0 / (kWavelength_mm * fresnel_number);
        const double expected = 4.0 * std::pow(std::sin(0.5 * kPi * fresnel_number), 2);
        const WaveField out = Propagate(disc, kWavelength_mm, z, Propagator::kChirp, threads);
        EXPECT_NEAR(OnAxis(out), expected, 0.0015) << fresnel_number;
        EXPECT_NEAR(out.energy_mm2(), disc.energy_mm2(), 1e-9 * disc.energy_mm2());
    }
}

// The aperture is real, so in front of it stands what will be as far behind it.
TEST(NegativeDistance, GivesTheSamePattern) {
    ThreadPool threads(1);
    const WaveField disc = Disc(128, 4.0);
    for (const Propagator how : {Propagator::kTransferFunction, Propagator::kChirp}) {
        const double z = 1.0 / (kWavelength_mm * 9.0);
        const WaveField out = Propagate(disc, kWavelength_mm, z, how, threads);
        const WaveField back = Propagate(disc, kWavelength_mm, -z, how, threads);
        for (std::size_t i = 0; i < out.values.size(); ++i) {
            EXPECT_NEAR(std::abs(back.values[i] - std::conj(out.values[i])), 0.0, 1e-9);
        }
    }
}

TEST(Propagators, AgreeWhereBothAreValid) {
    ThreadPool threads(1);
    const WaveField disc = Disc(512, 4.0);
    // At the limit their grids are the same.
    const double z = disc.width_mm() * disc.pitch_mm / kWavelength_mm;
    const WaveField a = Propagate(disc, kWavelength_mm, z, Propagator::kTransferFunction, threads);
    const WaveField b = Propagate(disc, kWavelength_mm, z, Propagator::kChirp, threads);
    ASSERT_NEAR(a.pitch_mm, b.pitch_mm, 1e-12);
    double difference = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < a.values.size(); ++i) {
        difference += std::abs(std::norm(a.values[i]) - std::norm(b.values[i]));
        sum += std::norm(a.values[i]);
    }
    EXPECT_LT(difference, 0.01 * sum);
    EXPECT_NEAR(a.energy_mm2(), disc.energy_mm2(), 1e-9 * disc.energy_mm2());
    EXPECT_EQ(PropagatorFor(disc, kWavelength_mm, 1.01 * z), Propagator::kChirp);
    EXPECT_EQ(PropagatorFor(disc, kWavelength_mm, -0.99 * z), Propagator::kTransferFunction);
}

TEST(AragoSpot, IsAsBrightAsWithoutTheDisc) {
    constexpr int kSide = 512;
    ThreadPool threads(1);
    WaveField field = FieldOf(kSide, 4.0 / kSide);
    const std::vector<double> disc =
        Sharpened(Coverage({Circle(0.5)}, kSide, field.pitch_mm), kSide);
    for (int j = 0; j < kSide; ++j) {
        for (int i = 0; i < kSide; ++i) {
            const auto n = static_cast<std::size_t>(j * kSide + i);
            const double r = std::hypot(i - kSide / 2, j - kSide / 2) * field.pitch_mm;
            field.values[n] = (1.0 - disc[n]) * Soft(r, 0.9, 1.9);
        }
    }
    const double z = 0.25 / (kWavelength_mm * 8.0);  // the disc's Fresnel number is 8
    const WaveField out =
        Propagate(field, kWavelength_mm, z, PropagatorFor(field, kWavelength_mm, z), threads);
    EXPECT_NEAR(OnAxis(out), 1.0, 0.01);
}

TEST(Talbot, AGratingImagesItselfAt36_36Millimetres) {
    constexpr int kSide = 256;
    constexpr int kPeriod = 32;  // samples: 0.1 mm
    ThreadPool threads(1);
    WaveField field = FieldOf(kSide, 0.1 / kPeriod);
    for (int j = 0; j < kSide; ++j) {
        for (int i = 0; i < kSide; ++i) {
            field.values[static_cast<std::size_t>(j * kSide + i)] =
                i % kPeriod < kPeriod / 4 ? 1.0 : 0.0;
        }
    }
    const double talbot_mm = 2.0 * 0.1 * 0.1 / kWavelength_mm;
    EXPECT_NEAR(talbot_mm, 36.36, 0.01);
    const auto miss = [&](double z, int shift) {
        const WaveField out =
            Propagate(field, kWavelength_mm, z, Propagator::kTransferFunction, threads);
        double sum = 0.0;
        for (int i = 0; i < kPeriod; ++i) {
            sum += std::abs(std::norm(out.At(i + shift, 7)) - std::norm(field.At(i, 7)));
        }
        return sum / (kPeriod / 4);
    };
    EXPECT_LT(miss(talbot_mm, 0), 1e-9);
    EXPECT_LT(miss(0.5 * talbot_mm, kPeriod / 2), 1e-9);
    EXPECT_GT(miss(0.99 * talbot_mm, 0), 0.05);
}

TEST(Fraunhofer, OfADiscIsAirysPattern) {
    constexpr int kSide = 1024;
    ThreadPool threads(1);
    WaveField field = FieldOf(kSide, 16.0 / kSide);
    const std::vector<double> samples =
        Sharpened(Coverage({Circle(1.0)}, kSide, field.pitch_mm), kSide);
    std::copy(samples.begin(), samples.end(), field.values.begin());
    const WaveField out = FraunhoferPattern(field, threads);
    EXPECT_NEAR(out.energy_mm2(), field.energy_mm2(), 1e-9 * field.energy_mm2());
    const double peak = kPi * kPi;
    EXPECT_NEAR(OnAxis(out), peak, 1e-4 * peak);
    for (int i = 1; i < 60; ++i) {
        const double x = 2.0 * kPi * i * out.pitch_mm;
        const double airy = peak * std::pow(2.0 * std::cyl_bessel_j(1.0, x) / x, 2);
        EXPECT_NEAR(std::norm(out.At(kSide / 2 + i, kSide / 2)), airy, 1e-3 * peak) << i;
    }
    // The first zero, 1.2196699 / D, by the change of sign of the field.
    int last = 1;
    while (out.At(kSide / 2 + last + 1, kSide / 2).real() > 0.0) ++last;
    const double a = out.At(kSide / 2 + last, kSide / 2).real();
    const double b = out.At(kSide / 2 + last + 1, kSide / 2).real();
    EXPECT_NEAR((last + a / (a - b)) * out.pitch_mm * 2.0, 1.2196699, 0.005);
}

TEST(SquareFourier, OfOneWaveIsOneElementAndComesBack) {
    ThreadPool one(1), two(2);
    constexpr int kSide = 64;
    std::vector<Complex> values;
    for (int j = 0; j < kSide; ++j) {
        for (int i = 0; i < kSide; ++i) {
            values.push_back(std::polar(1.0, 2.0 * kPi * (5 * i + 62 * j) / kSide));
        }
    }
    const SquareFourier fourier(kSide);
    std::vector<Complex> wave = values, other = values;
    fourier.Forward(wave, one);
    fourier.Forward(other, two);
    EXPECT_EQ(wave, other) << "the result depends on the number of threads";
    for (int n = 0; n < kSide * kSide; ++n) {
        EXPECT_NEAR(std::abs(wave[static_cast<std::size_t>(n)] -
                             (n == 62 * kSide + 5 ? 1.0 * kSide * kSide : 0.0)),
                    0.0, 1e-9);
    }
    fourier.Inverse(wave, two);
    for (std::size_t n = 0; n < values.size(); ++n) {
        EXPECT_NEAR(std::abs(wave[n] - values[n]), 0.0, 1e-12);
    }
}

TEST(Coverage, IsTheAreaInsideCellByCell) {
    // A triangle with a hole, against counting 64 x 64 points a cell.
    constexpr int kSide = 16;
    const Loop triangle = {{-6.3, -5.2}, {6.1, -3.4}, {-1.2, 7.1}};
    const Loop hole = {{-1.5, -1.0}, {-1.0, 1.5}, {1.3, 0.2}};
    ASSERT_GT(SignedArea(triangle), 0.0);
    ASSERT_LT(SignedArea(hole), 0.0);
    const std::vector<double> shares = Coverage({triangle, hole}, kSide, 1.0);
    const auto inside = [](const Loop& loop, Vec2d p) {
        bool in = false;
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Vec2d a = loop[i], b = loop[(i + 1) % loop.size()];
            if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) {
                in = !in;
            }
        }
        return in;
    };
    double sum = 0.0;
    for (int j = 0; j < kSide; ++j) {
        for (int i = 0; i < kSide; ++i) {
            int count = 0;
            for (int n = 0; n < 64 * 64; ++n) {
                const Vec2d p(i - kSide / 2 - 0.5 + (n % 64 + 0.5) / 64.0,
                              j - kSide / 2 - 0.5 + (n / 64 + 0.5) / 64.0);
                count += inside(triangle, p) && !inside(hole, p) ? 1 : 0;
            }
            const double share = shares[static_cast<std::size_t>(j * kSide + i)];
            EXPECT_NEAR(share, count / 4096.0, 0.02) << i << " " << j;
            sum += share;
        }
    }
    EXPECT_NEAR(sum, SignedArea(triangle) + SignedArea(hole), 1e-12);
}

}  // namespace
}  // namespace flare
