// SPDX-License-Identifier: Apache-2.0
//
// Curves over two logarithmic axes, as SVG with a legend. Equal charts give equal bytes.
#pragma once

#include <string>
#include <vector>

namespace flare {

struct ChartPoint {
    double x = 1.0, y = 1.0;  // above 0
    std::string label;
};

struct ChartCurve {
    std::string name;
    std::vector<ChartPoint> points;
    bool dashed = false;  // a line without marks and labels
    bool joined = true;   // false: marks alone
};

struct Chart {
    std::string title, x_title, y_title;
    std::vector<ChartCurve> curves;
};

// A chart without points says so.
std::string ChartSvg(const Chart& chart);

}  // namespace flare
