// SPDX-License-Identifier: Apache-2.0
#include "server/tradeoff/chart.h"

#include <algorithm>
#include <cmath>

#include "core/drawing/svg_writer.h"
#include "server/tradeoff/number_text.h"

namespace flare {
namespace {

constexpr double kWidth = 860.0, kHeight = 460.0;
constexpr double kLeft = 70.0, kRight = 660.0, kTop = 44.0, kBottom = 404.0;
constexpr double kLegendRow = 18.0;
const char* const kInk[] = {"#1b6ca8", "#c0392b", "#2e8b57", "#8e44ad", "#b9770e",
                            "#34495e", "#16a085", "#d35400", "#7f8c8d", "#6d4c41"};

struct Axis {
    double low = 0.0, high = 1.0;   // decimal logarithms
    double start = 0.0, end = 1.0;  // on paper
    double Place(double value) const {
        return start + (std::log10(value) - low) / (high - low) * (end - start);
    }
};

// Of the values, with a margin, a decade at least.
Axis AxisOver(std::vector<double> values, double start, double end) {
    for (double& value : values) value = std::log10(value);
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    Axis axis{*least - 0.1, *most + 0.1, start, end};
    const double missing = 1.0 - (axis.high - axis.low);
    if (missing > 0.0) {
        axis.low -= 0.5 * missing;
        axis.high += 0.5 * missing;
    }
    return axis;
}

// 1, 2, 5, 10, ... within the axis; decades alone where they are many.
std::vector<double> Ticks(const Axis& axis) {
    std::vector<double> ticks;
    const bool decades = axis.high - axis.low > 2.5;
    for (int power = static_cast<int>(std::floor(axis.low)); power <= axis.high; ++power) {
        for (const double digit : {1.0, 2.0, 5.0}) {
            const double value = digit * std::pow(10.0, power);
            const double place = std::log10(value);
            if (decades && digit != 1.0) continue;
            if (place >= axis.low && place <= axis.high) ticks.push_back(value);
        }
    }
    return ticks;
}

std::string At(double value) {
    return SvgWriter::Number(value, 1);
}

void Line(SvgWriter& svg, double x1, double y1, double x2, double y2, const char* ink) {
    svg.Empty("line",
              {{"x1", At(x1)}, {"y1", At(y1)}, {"x2", At(x2)}, {"y2", At(y2)}, {"stroke", ink}});
}

void Label(SvgWriter& svg, double x, double y, const char* anchor, const std::string& text,
           const char* ink = "#22303c", const char* size = "12") {
    svg.Text(
        "text",
        {{"x", At(x)}, {"y", At(y)}, {"text-anchor", anchor}, {"fill", ink}, {"font-size", size}},
        text);
}

void WriteAxes(const Chart& chart, const Axis& x, const Axis& y, SvgWriter& svg) {
    for (const double tick : Ticks(x)) {
        Line(svg, x.Place(tick), kTop, x.Place(tick), kBottom, "#e3e8ec");
        Label(svg, x.Place(tick), kBottom + 16.0, "middle", NumberText(tick, 3));
    }
    for (const double tick : Ticks(y)) {
        Line(svg, kLeft, y.Place(tick), kRight, y.Place(tick), "#e3e8ec");
        Label(svg, kLeft - 6.0, y.Place(tick) + 4.0, "end", NumberText(tick, 3));
    }
    Line(svg, kLeft, kBottom, kRight, kBottom, "#33475b");
    Line(svg, kLeft, kTop, kLeft, kBottom, "#33475b");
    Label(svg, 0.5 * (kLeft + kRight), kBottom + 38.0, "middle", chart.x_title);
    Label(svg, kLeft, kTop - 8.0, "middle", chart.y_title);
}

void WriteCurve(const ChartCurve& curve, const Axis& x, const Axis& y, const char* ink,
                SvgWriter& svg) {
    std::vector<Vec2d> places;
    for (const ChartPoint& point : curve.points) {
        places.emplace_back(x.Place(point.x), y.Place(point.y));
    }
    if (curve.joined) {
        svg.Empty("polyline", {{"points", SvgWriter::Points(places)},
                               {"fill", "none"},
                               {"stroke", ink},
                               {"stroke-dasharray", curve.dashed ? "5 4" : "none"}});
    }
    if (curve.dashed) return;
    for (std::size_t i = 0; i < places.size(); ++i) {
        svg.Empty("circle",
                  {{"cx", At(places[i].x)}, {"cy", At(places[i].y)}, {"r", "3"}, {"fill", ink}});
        Label(svg, places[i].x + 5.0, places[i].y - 4.0, "start", curve.points[i].label, ink, "9");
    }
}

}  // namespace

std::string ChartSvg(const Chart& chart) {
    SvgWriter svg;
    svg.Open("svg", {{"xmlns", "http://www.w3.org/2000/svg"},
                     {"viewBox", "0 0 " + At(kWidth) + " " + At(kHeight)},
                     {"font-family", "sans-serif"}});
    svg.Empty("rect", {{"width", At(kWidth)}, {"height", At(kHeight)}, {"fill", "#ffffff"}});
    Label(svg, 0.5 * (kLeft + kRight), 18.0, "middle", chart.title, "#22303c", "14");
    std::vector<double> xs, ys;
    for (const ChartCurve& curve : chart.curves) {
        for (const ChartPoint& point : curve.points) {
            xs.push_back(point.x);
            ys.push_back(point.y);
        }
    }
    if (xs.empty()) {
        Label(svg, 0.5 * (kLeft + kRight), 0.5 * (kTop + kBottom), "middle", "nothing measured");
    } else {
        const Axis x = AxisOver(std::move(xs), kLeft, kRight);
        const Axis y = AxisOver(std::move(ys), kBottom, kTop);
        WriteAxes(chart, x, y, svg);
        double row = kTop + 6.0;
        std::size_t n = 0;
        for (const ChartCurve& curve : chart.curves) {
            const char* const ink = curve.dashed ? "#9aa7b2" : kInk[n++ % std::size(kInk)];
            WriteCurve(curve, x, y, ink, svg);
            Line(svg, kRight + 16.0, row - 4.0, kRight + 34.0, row - 4.0, ink);
            Label(svg, kRight + 40.0, row, "start", curve.name);
            row += kLegendRow;
        }
    }
    svg.Close();
    return svg.text();
}

}  // namespace flare
