// SPDX-License-Identifier: Apache-2.0
//
// Rows of many scenes as one number a trial: geometric means of errors and times, and the worst
// error. Scenes whose reference picture is black, or in which a trial made no error at all, have no
// place in a geometric mean: an error below kLeastError counts as that, an infinite one is left
// out.
#pragma once

#include <string>
#include <vector>

#include "server/tradeoff/table.h"

namespace flare {

inline constexpr double kLeastError = 1e-6;

struct TrialSummary {
    std::string knob, value;
    Truth truth = Truth::kGhosts;
    bool whole = false;
    int scenes = 0;
    double rel_l1 = 0.0, worst_rel_l1 = 0.0, estimated = 0.0;
    double energy = 0.0;  // arithmetic mean
    double rel_l2_blur2 = 0.0, stops_mean = 0.0;
    double cold_ms = 0.0, warm_ms = 0.0, cold_cpu_ms = 0.0, warm_cpu_ms = 0.0;
    // No other trial on plain ghosts has less error in less processor time, meshes at hand.
    bool front = false;
};

// In the order of the trials; those without rows are left out.
std::vector<TrialSummary> Summarise(const std::vector<TradeoffRow>& rows,
                                    const std::vector<Trial>& trials);

}  // namespace flare
