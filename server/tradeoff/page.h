// SPDX-License-Identifier: Apache-2.0
//
// A sweep for people: charts of error over time, and one HTML page with charts and tables that
// needs nothing beside it.
#pragma once

#include <string>
#include <vector>

#include "server/tradeoff/summary.h"

namespace flare {

struct NamedSvg {
    std::string file;  // "methods_warm.svg"
    std::string svg;
};

// Methods with meshes at hand and with nothing cached, single settings, the estimate against the
// error, and the methods lens by lens.
std::vector<NamedSvg> TradeoffCharts(const std::vector<TradeoffRow>& rows,
                                     const std::vector<Trial>& trials);

std::string TradeoffPage(const std::vector<TradeoffRow>& rows, const std::vector<Trial>& trials,
                         const std::vector<NamedSvg>& charts);

}  // namespace flare
