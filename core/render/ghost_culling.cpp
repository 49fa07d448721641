// SPDX-License-Identifier: Apache-2.0
//
// Were the faintest ghosts taken in order until the budget is used up, two that change places would
// pop. So one threshold of light is set for all, such that the lost light, dimming included, is the
// budget: the threshold is continuous in every ghost's light, and so is every weight.
#include "core/render/ghost_culling.h"

#include <algorithm>
#include <cstddef>

namespace flare {
namespace {

constexpr double kFade = 1.5;  // times the limit: from here on a ghost is drawn as it is
constexpr int kHalvings = 60;

// 0 up to 1, 1 from kFade on, smooth between them.
double Fade(double over_limit) {
    const double x = std::clamp((over_limit - 1.0) / (kFade - 1.0), 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

}  // namespace

std::vector<double> CullByLight(const std::vector<GhostSample>& samples, const CullLimits& limits) {
    std::vector<double> weights(samples.size(), 1.0);
    if (limits.lost_share <= 0.0) return weights;
    double all = 0.0;
    for (const GhostSample& sample : samples) all += sample.frame_light;
    const double budget = limits.lost_share * all;
    const auto weight = [&](const GhostSample& sample, double threshold) {
        if (sample.frame_light <= 0.0) return 0.0;
        const double by_peak = limits.peak > 0.0 ? Fade(sample.peak / limits.peak) : 1.0;
        return std::max(by_peak, Fade(sample.frame_light / threshold));
    };
    const auto lost = [&](double threshold) {
        double sum = 0.0;
        for (const GhostSample& sample : samples) {
            sum += sample.frame_light * (1.0 - weight(sample, threshold));
        }
        return sum;
    };
    // A ghost of more light than the budget is never dimmed: that would save nothing.
    double hi = budget / kFade;
    double lo = 0.0;
    if (lost(hi) > budget) {
        for (int i = 0; i < kHalvings; ++i) {
            const double middle = 0.5 * (lo + hi);
            (lost(middle) > budget ? hi : lo) = middle;
        }
    } else {
        lo = hi;
    }
    // Where no sample meets the frame, nothing is known, and all are drawn.
    for (std::size_t i = 0; i < samples.size(); ++i) {
        weights[i] = lo > 0.0 ? weight(samples[i], lo) : 1.0;
    }
    return weights;
}

std::vector<double> CullByOldRules(const std::vector<GhostSample>& samples,
                                   const std::vector<int>& stop_crossings, double frame_px2,
                                   CullingRule rule) {
    const bool by_size = rule != CullingRule::kReportCrossings;
    const bool by_crossings = rule != CullingRule::kReportSize;
    std::vector<double> weights(samples.size(), 1.0);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const double box_px2 = samples[i].box_width_px * samples[i].box_height_px;
        if (by_crossings && stop_crossings[i] >= 3) weights[i] = 0.0;
        if (by_size && box_px2 > 0.5 * frame_px2) weights[i] = 0.0;
    }
    return weights;
}

}  // namespace flare
