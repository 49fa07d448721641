// SPDX-License-Identifier: Apache-2.0
//
// The rows of a sweep as a CSV file that grows by a line a measurement, so that a sweep that is
// broken off goes on where it was. A line that was cut short is dropped when the file is read.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "server/tradeoff/scene.h"

namespace flare {

struct TradeoffRow {
    // What was measured.
    std::string lens, coatings, lens_hash;
    double f_number = 0.0, field_deg = 0.0;
    int width = 0, height = 0;
    std::string truth, knob, value;
    // What came out: against the reference picture (compare.h), as the report had estimated, and in
    // milliseconds: with nothing cached, and the median of `runs` with all meshes at hand. `_cpu`
    // is the processor time of all threads, which other programs disturb less.
    double rel_l1 = 0.0, energy = 0.0, rel_l2_blur2 = 0.0;
    double stops_mean = 0.0, stops_p99 = 0.0, p999_ratio = 0.0;
    double estimated = 0.0;
    double cold_ms = 0.0, warm_ms = 0.0, cold_cpu_ms = 0.0, warm_cpu_ms = 0.0;
    int runs = 0, threads = 0;
    double rays = 0.0, pieces = 0.0;

    // Of scene and trial.
    std::string Key() const;
};

// With the names of what is measured filled in.
TradeoffRow RowFor(const TradeoffScene& scene, const Trial& trial);

std::string CsvHead();
std::string CsvLine(const TradeoffRow& row);
// Error "bad_value" where the head is not CsvHead, or a whole line is no row; with its number.
Result<std::vector<TradeoffRow>> RowsFromCsv(std::string_view text);

}  // namespace flare
