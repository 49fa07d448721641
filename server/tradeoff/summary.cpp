// SPDX-License-Identifier: Apache-2.0
#include "server/tradeoff/summary.h"

#include <algorithm>
#include <cmath>

namespace flare {
namespace {

class GeometricMean {
  public:
    void Add(double value) {
        if (!std::isfinite(value)) return;
        sum_ += std::log(std::max(value, kLeastError));
        ++count_;
    }
    int count() const { return count_; }
    double value() const { return count_ > 0 ? std::exp(sum_ / count_) : 0.0; }

  private:
    double sum_ = 0.0;
    int count_ = 0;
};

TrialSummary SummaryOf(const std::vector<TradeoffRow>& rows, const Trial& trial) {
    TrialSummary summary;
    summary.knob = trial.knob;
    summary.value = trial.value;
    summary.truth = trial.truth;
    summary.whole = trial.whole;
    GeometricMean error, estimated, blurred, stops, cold, warm, cold_cpu, warm_cpu;
    for (const TradeoffRow& row : rows) {
        if (row.knob != trial.knob || row.value != trial.value) continue;
        if (!std::isfinite(row.rel_l1) || !std::isfinite(row.energy)) continue;
        error.Add(row.rel_l1);
        estimated.Add(row.estimated);
        blurred.Add(row.rel_l2_blur2);
        stops.Add(row.stops_mean);
        cold.Add(row.cold_ms);
        warm.Add(row.warm_ms);
        cold_cpu.Add(row.cold_cpu_ms);
        warm_cpu.Add(row.warm_cpu_ms);
        summary.energy += row.energy;
        summary.worst_rel_l1 = std::max(summary.worst_rel_l1, row.rel_l1);
    }
    summary.scenes = error.count();
    if (summary.scenes > 0) summary.energy /= summary.scenes;
    summary.rel_l1 = error.value();
    summary.estimated = estimated.value();
    summary.rel_l2_blur2 = blurred.value();
    summary.stops_mean = stops.value();
    summary.cold_ms = cold.value();
    summary.warm_ms = warm.value();
    summary.cold_cpu_ms = cold_cpu.value();
    summary.warm_cpu_ms = warm_cpu.value();
    return summary;
}

}  // namespace

std::vector<TrialSummary> Summarise(const std::vector<TradeoffRow>& rows,
                                    const std::vector<Trial>& trials) {
    std::vector<TrialSummary> summaries;
    for (const Trial& trial : trials) {
        TrialSummary summary = SummaryOf(rows, trial);
        if (summary.scenes > 0) summaries.push_back(std::move(summary));
    }
    for (TrialSummary& a : summaries) {
        a.front = a.truth == Truth::kGhosts &&
                  std::none_of(summaries.begin(), summaries.end(), [&](const TrialSummary& b) {
                      return b.truth == Truth::kGhosts && b.rel_l1 <= a.rel_l1 &&
                             b.warm_cpu_ms <= a.warm_cpu_ms &&
                             (b.rel_l1 < a.rel_l1 || b.warm_cpu_ms < a.warm_cpu_ms);
                  });
    }
    return summaries;
}

}  // namespace flare
