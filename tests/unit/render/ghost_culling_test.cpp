// SPDX-License-Identifier: Apache-2.0
#include "core/render/ghost_culling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace flare {
namespace {

GhostSample Sample(double frame_light, double peak) {
    GhostSample sample;
    sample.frame_light = frame_light;
    sample.peak = peak;
    return sample;
}

double Lost(const std::vector<GhostSample>& samples, const std::vector<double>& weights) {
    double lost = 0.0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        lost += (1.0 - weights[i]) * samples[i].frame_light;
    }
    return lost;
}

// Ghosts whose light spans nine powers of ten.
std::vector<GhostSample> ManyGhosts() {
    std::vector<GhostSample> samples;
    for (int i = 0; i < 200; ++i) samples.push_back(Sample(std::pow(10.0, -0.045 * i), 0.0));
    return samples;
}

TEST(CullByLight, LosesNoMoreThanTheBudgetAndUsesItUp) {
    const std::vector<GhostSample> samples = ManyGhosts();
    const double all = Lost(samples, std::vector<double>(samples.size(), 0.0));
    for (const double share : {0.0125, 0.005, 0.00125}) {
        const std::vector<double> weights = CullByLight(samples, {share, 1.0});
        EXPECT_LE(Lost(samples, weights), share * all * (1.0 + 1e-9));
        EXPECT_GT(Lost(samples, weights), 0.99 * share * all);
        EXPECT_EQ(weights.front(), 1.0);
        EXPECT_EQ(weights.back(), 0.0);
        for (std::size_t i = 1; i < weights.size(); ++i) EXPECT_LE(weights[i], weights[i - 1]);
    }
}

TEST(CullByLight, CullsNothingWithoutABudget) {
    for (const double weight : CullByLight(ManyGhosts(), {0.0, 1.0})) EXPECT_EQ(weight, 1.0);
}

TEST(CullByLight, KeepsWhatIsFaintButBright) {
    std::vector<GhostSample> samples = ManyGhosts();
    samples.back().peak = 2.0;
    samples[samples.size() - 2].peak = 0.5;
    const std::vector<double> weights = CullByLight(samples, {0.005, 1.0});
    EXPECT_EQ(weights.back(), 1.0);
    EXPECT_EQ(weights[weights.size() - 2], 0.0);
}

TEST(CullByLight, LeavesOutWhatMissesTheFrameAtNoCost) {
    const std::vector<GhostSample> samples = {Sample(1.0, 1.0), Sample(0.0, 0.0)};
    const std::vector<double> weights = CullByLight(samples, {0.005, 0.1});
    EXPECT_EQ(weights, (std::vector<double>{1.0, 0.0}));
}

// A few ghosts that all matter: dimming one would lose light and save nothing.
TEST(CullByLight, NeverDimsAGhostOfMoreLightThanTheBudget) {
    const std::vector<GhostSample> samples = {Sample(1.0, 0.0), Sample(0.9, 0.0), Sample(0.1, 0.0)};
    for (const double weight : CullByLight(samples, {0.02, 1.0})) EXPECT_EQ(weight, 1.0);
}

TEST(CullByLight, IsTheSameInAnyOrder) {
    std::vector<GhostSample> samples = ManyGhosts();
    const std::vector<double> weights = CullByLight(samples, {0.005, 1.0});
    std::vector<GhostSample> turned(samples.rbegin(), samples.rend());
    std::vector<double> back = CullByLight(turned, {0.005, 1.0});
    for (std::size_t i = 0; i < weights.size(); ++i) {
        EXPECT_NEAR(back[weights.size() - 1 - i], weights[i], 1e-6);
    }
}

// While every ghost's light drifts and ghosts change places, the light left changes no faster than
// the ghosts themselves do: nothing pops.
TEST(CullByLight, WeightsGoContinuouslyWithTheLight) {
    std::vector<GhostSample> samples = ManyGhosts();
    constexpr int kSteps = 2000;
    std::vector<double> before;
    double largest = 0.0;
    int faded = 0;
    for (int step = 0; step <= kSteps; ++step) {
        const double t = static_cast<double>(step) / kSteps;
        std::vector<GhostSample> now = samples;
        for (std::size_t i = 0; i < now.size(); ++i) {
            const double phase = static_cast<double>(i);
            now[i].frame_light *= std::exp(2.0 * std::sin(6.0 * t + phase));
            now[i].peak = 0.8 * std::exp(std::cos(4.0 * t + phase));
        }
        const std::vector<double> weights = CullByLight(now, {0.01, 1.0});
        if (!before.empty()) {
            for (std::size_t i = 0; i < weights.size(); ++i) {
                largest = std::max(largest, std::abs(weights[i] - before[i]));
                faded += weights[i] > 0.0 && weights[i] < 1.0 ? 1 : 0;
            }
        }
        before = weights;
    }
    // A step changes lights by 0.6 % at most; a fade over a factor of 1.5 is up to 4.5 times that.
    EXPECT_LT(largest, 0.05);
    EXPECT_GT(faded, 100);
}

TEST(CullByOldRules, GoByCrossingsAndSize) {
    std::vector<GhostSample> samples(3, Sample(1.0, 1.0));
    samples[1].box_width_px = 80.0;
    samples[1].box_height_px = 70.0;
    EXPECT_EQ(CullByOldRules(samples, {3, 1, 1}, 1e4), (std::vector<double>{0.0, 0.0, 1.0}));
    EXPECT_EQ(CullByOldRules(samples, {3, 1, 1}, 1e4, CullingRule::kReportSize),
              (std::vector<double>{1.0, 0.0, 1.0}));
    EXPECT_EQ(CullByOldRules(samples, {3, 1, 1}, 1e4, CullingRule::kReportCrossings),
              (std::vector<double>{0.0, 1.0, 1.0}));
}

}  // namespace
}  // namespace flare
