// SPDX-License-Identifier: Apache-2.0
#include "core/render/compare.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/image/channel_name.h"

namespace flare {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

FlareImage Flat(int width, int height, const std::vector<std::pair<std::string, float>>& planes) {
    FlareImage image;
    image.full = image.data = {0, 0, width, height};
    for (const auto& [name, value] : planes) {
        image.planes.push_back({name, std::vector<float>(image.data.pixels(), value)});
    }
    return image;
}

FlareImage Impulse(int x, int y, float value) {
    FlareImage image = Flat(64, 64, {{"R", 0.0f}});
    image.planes[0].values[static_cast<std::size_t>(64 * y + x)] = value;
    return image;
}

ErrorMetrics Metrics(const FlareImage& image, const FlareImage& reference) {
    const Result<Comparison> comparison = Compare(image, reference);
    EXPECT_TRUE(comparison.ok());
    return comparison.ok() ? comparison->all : ErrorMetrics{};
}

TEST(Compare, EqualPicturesHaveNoError) {
    const ErrorMetrics m = Metrics(Impulse(20, 30, 2.0f), Impulse(20, 30, 2.0f));
    EXPECT_EQ(m.rel_l1, 0.0);
    EXPECT_EQ(m.energy, 0.0);
    EXPECT_EQ(m.rel_l2_blur2, 0.0);
    EXPECT_EQ(m.log_error_stops_mean, 0.0);
    EXPECT_EQ(m.log_error_stops_p99, 0.0);
    EXPECT_EQ(m.p999_ratio, 1.0);
    EXPECT_EQ(m.max_abs, 0.0);
}

TEST(Compare, AScaledPictureErrsByTheScaleInEveryMetric) {
    const ErrorMetrics m =
        Metrics(Flat(40, 30, {{"R", 3.0f}, {"G", 6.0f}}), Flat(40, 30, {{"R", 2.0f}, {"G", 4.0f}}));
    EXPECT_DOUBLE_EQ(m.rel_l1, 0.5);
    EXPECT_DOUBLE_EQ(m.energy, 0.5);
    EXPECT_NEAR(m.rel_l2_blur2, 0.5, 1e-12);
    EXPECT_DOUBLE_EQ(m.p999_ratio, 1.5);
    EXPECT_DOUBLE_EQ(m.max_abs, 2.0);
    EXPECT_DOUBLE_EQ(m.log_error_epsilon, 4e-4);
    EXPECT_NEAR(m.log_error_stops_mean, std::log2(1.5), 2e-4);
    EXPECT_NEAR(m.log_error_stops_p99, std::log2(1.5), 2e-4);
}

TEST(Compare, LightInAnotherPlaceIsAllWrongButLosesNoEnergy) {
    const ErrorMetrics m = Metrics(Impulse(20, 30, 2.0f), Impulse(40, 30, 2.0f));
    EXPECT_DOUBLE_EQ(m.rel_l1, 2.0);
    EXPECT_DOUBLE_EQ(m.energy, 0.0);
    EXPECT_NEAR(m.rel_l2_blur2, std::sqrt(2.0), 1e-6);  // blurs that do not overlap
    EXPECT_DOUBLE_EQ(m.max_abs, 2.0);
}

// Two unit impulses d apart: |G a - G b|^2 / |G b|^2 = 2 - 2 exp(-d^2 / (4 sigma^2)), because a
// Gaussian's autocorrelation is a Gaussian of sqrt(2) the width.
TEST(Compare, AShiftIsForgivenAsFarAsTheBlurReaches) {
    for (const int d : {1, 2, 4}) {
        const double expected = std::sqrt(2.0 - 2.0 * std::exp(-d * d / 16.0));
        EXPECT_NEAR(Metrics(Impulse(30 + d, 30, 1.0f), Impulse(30, 30, 1.0f)).rel_l2_blur2,
                    expected, 1e-3)
            << d;
        EXPECT_NEAR(Metrics(Impulse(30, 30 + d, 1.0f), Impulse(30, 30, 1.0f)).rel_l2_blur2,
                    expected, 1e-3)
            << d;
    }
}

// The light of one pixel spread evenly over 17 x 17. The inner product of two blurred pixels is
// their Gaussian autocorrelation, so the metric is a sum of those, which parts into x and y.
TEST(Compare, TheBlurSpreadsAnImpulseByItsGaussian) {
    FlareImage reference = Flat(101, 101, {{"R", 0.0f}});
    reference.planes[0].values[50 * 101 + 50] = 1.0f;
    FlareImage image = Flat(101, 101, {{"R", 0.0f}});
    for (std::size_t y = 42; y <= 58; ++y) {
        for (std::size_t x = 42; x <= 58; ++x) image.planes[0].values[y * 101 + x] = 1.0f / 289.0f;
    }
    const auto autocorrelation = [](double d) {
        return std::exp(-d * d / 16.0) / std::sqrt(16.0 * std::acos(-1.0));
    };
    double square = 0.0, cross = 0.0;
    for (int i = -8; i <= 8; ++i) {
        cross += autocorrelation(i) / 17.0;
        for (int j = -8; j <= 8; ++j) square += autocorrelation(i - j) / 289.0;
    }
    const double one = autocorrelation(0.0);
    const double expected =
        std::sqrt((square * square - 2.0 * cross * cross + one * one) / (one * one));
    EXPECT_NEAR(Metrics(image, reference).rel_l2_blur2, expected, 1e-3);
}

TEST(Compare, LogErrorIsInStopsAndForgivesWhatIsFarBelowTheBrightest) {
    // 1000 pixels at 1, of which 20 are two stops too bright in the image: p99 sees them.
    FlareImage reference = Flat(1000, 1, {{"R", 1.0f}});
    FlareImage image = reference;
    for (std::size_t i = 0; i < 20; ++i) image.planes[0].values[i] = 4.0f;
    ErrorMetrics m = Metrics(image, reference);
    EXPECT_NEAR(m.log_error_stops_p99, 2.0, 2e-4);
    EXPECT_NEAR(m.log_error_stops_mean, 0.04, 1e-5);
    EXPECT_DOUBLE_EQ(m.p999_ratio, 4.0);

    // Nine of a thousand lie beyond the 99th percentile.
    image = reference;
    for (std::size_t i = 0; i < 9; ++i) image.planes[0].values[i] = 4.0f;
    EXPECT_EQ(Metrics(image, reference).log_error_stops_p99, 0.0);

    // A difference of a millionth in the dark is 1 % of epsilon: log2(1.01) stops.
    FlareImage dark = Flat(1000, 1, {{"R", 0.0f}});
    for (std::size_t i = 0; i < 500; ++i) dark.planes[0].values[i] = 1.0f;
    image = dark;
    for (std::size_t i = 500; i < 1000; ++i) image.planes[0].values[i] = 1e-6f;
    EXPECT_NEAR(Metrics(image, dark).log_error_stops_mean, 0.5 * std::log2(1.01), 1e-6);
}

TEST(Compare, EpsilonFallsBackOnTheLargestValueOfASparseReference) {
    const ErrorMetrics m = Metrics(Impulse(20, 30, 2.0f), Impulse(20, 30, 1.0f));
    EXPECT_DOUBLE_EQ(m.log_error_epsilon, 1e-4);
    EXPECT_NEAR(m.log_error_stops_mean * 4096.0, 1.0, 2e-4);
    EXPECT_EQ(m.p999_ratio, 1.0);  // both percentiles are 0
}

TEST(Compare, BlackReferenceGivesTheDocumentedValues) {
    const FlareImage black = Flat(8, 8, {{"R", 0.0f}});
    const ErrorMetrics same = Metrics(black, black);
    EXPECT_EQ(same.rel_l1, 0.0);
    EXPECT_EQ(same.energy, 0.0);
    EXPECT_EQ(same.rel_l2_blur2, 0.0);
    EXPECT_EQ(same.log_error_stops_mean, 0.0);
    EXPECT_EQ(same.p999_ratio, 1.0);

    const ErrorMetrics lit = Metrics(Flat(8, 8, {{"R", 1.0f}}), black);
    EXPECT_EQ(lit.rel_l1, kInfinity);
    EXPECT_EQ(lit.energy, kInfinity);
    EXPECT_EQ(lit.rel_l2_blur2, kInfinity);
    EXPECT_EQ(lit.log_error_stops_mean, kInfinity);
    EXPECT_EQ(lit.log_error_stops_p99, kInfinity);
    EXPECT_EQ(lit.p999_ratio, kInfinity);
    EXPECT_EQ(lit.max_abs, 1.0);
}

TEST(Compare, LayersAreMeasuredApart) {
    const FlareImage reference = Flat(16, 16,
                                      {{"R", 1.0f},
                                       {"ghosts.R", 2.0f},
                                       {"ghosts.G", 2.0f},
                                       {"S0.587,5618nm", 1.0f},
                                       {"ghosts.S0.587,5618nm", 2.0f}});
    FlareImage image = reference;
    for (float& value : image.planes[2].values) value = 3.0f;
    std::swap(image.planes[0], image.planes[3]);  // the order of channels does not matter
    const Result<Comparison> comparison = Compare(image, reference);
    ASSERT_TRUE(comparison.ok());
    ASSERT_EQ(comparison->layers.size(), 2u);
    EXPECT_EQ(comparison->layers[0].layer, "");
    EXPECT_EQ(comparison->layers[0].metrics.rel_l1, 0.0);
    EXPECT_EQ(comparison->layers[1].layer, "ghosts");
    EXPECT_DOUBLE_EQ(comparison->layers[1].metrics.rel_l1, 1.0 / 6.0);
    EXPECT_DOUBLE_EQ(comparison->all.rel_l1, 1.0 / 8.0);
}

// A picture by photons says how noisy it is; one by meshes has nothing to hold that against.
TEST(Compare, PassesOverTheNoiseOfPhotons) {
    const FlareImage reference = Flat(8, 8, {{"R", 1.0f}, {"ghosts.R", 1.0f}});
    const FlareImage photons =
        Flat(8, 8, {{"photon_error.R", 9.0f}, {"R", 1.0f}, {"ghosts.R", 1.5f}});
    for (const FlareImage* truth : {&reference, &photons}) {
        const Result<Comparison> comparison =
            Compare(truth == &reference ? photons : reference, *truth);
        ASSERT_TRUE(comparison.ok());
        ASSERT_EQ(comparison->layers.size(), 2u);
        EXPECT_EQ(comparison->layers[0].metrics.rel_l1, 0.0);
        EXPECT_EQ(comparison->layers[1].layer, "ghosts");
        EXPECT_GT(comparison->layers[1].metrics.rel_l1, 0.3);
    }
    EXPECT_FALSE(
        Compare(Flat(8, 8, {{"photon_error.R", 1.0f}}), Flat(8, 8, {{"photon_error.R", 1.0f}}))
            .ok());
}

TEST(Compare, RefusesWhatCannotBeCompared) {
    const FlareImage reference = Flat(8, 8, {{"R", 1.0f}});
    FlareImage shifted = reference, framed = reference, broken = reference;
    shifted.data.x = 1;
    framed.full.width = 9;
    broken.planes[0].values[3] = std::numeric_limits<float>::quiet_NaN();
    for (const FlareImage& image :
         {shifted, framed, broken, Flat(8, 4, {{"R", 1.0f}}), Flat(8, 8, {{"G", 1.0f}}),
          Flat(8, 8, {{"R", 1.0f}, {"G", 1.0f}}), Flat(8, 8, {{"R", 1.0f}, {"R", 1.0f}})}) {
        for (const auto& [a, b] : {std::pair{&image, &reference}, std::pair{&reference, &image}}) {
            const Result<Comparison> comparison = Compare(*a, *b);
            ASSERT_FALSE(comparison.ok());
            EXPECT_EQ(comparison.error().code, "bad_image");
            EXPECT_NE(comparison.error().message, "");
        }
    }
    EXPECT_FALSE(Compare(Flat(8, 8, {}), Flat(8, 8, {})).ok());
}

TEST(LayerOfChannel, ADotInsideASpectralNamePartsNothing) {
    EXPECT_EQ(LayerOfChannel("R"), "");
    EXPECT_EQ(LayerOfChannel("ghosts.R"), "ghosts");
    EXPECT_EQ(LayerOfChannel("left.ghosts.R"), "left.ghosts");
    EXPECT_EQ(LayerOfChannel("S0.587,5618nm"), "");
    EXPECT_EQ(LayerOfChannel("ghosts.S0.587,5618nm"), "ghosts");
}

}  // namespace
}  // namespace flare
