// SPDX-License-Identifier: Apache-2.0
#include "server/tradeoff/page.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/drawing/svg_writer.h"
#include "server/tradeoff/chart.h"
#include "server/tradeoff/number_text.h"

namespace flare {
namespace {

constexpr double kLeastTime_ms = 1e-3;

// The presets that are tolerances.
const std::map<std::string, std::string>& PresetNames() {
    static const std::map<std::string, std::string> names{
        {"0.05", "draft"}, {"0.02", "preview"}, {"0.005", "final"}};
    return names;
}

ChartPoint PointOf(const TrialSummary& summary, double time_ms) {
    const bool tolerance = summary.knob == kBaseKnob;
    const auto preset = PresetNames().find(summary.value);
    const bool named = tolerance && preset != PresetNames().end();
    return {std::max(time_ms, kLeastTime_ms), std::max(summary.rel_l1, kLeastError),
            named ? preset->second : summary.value};
}

// One curve a knob, of those that are whole methods or of the others.
Chart ChartOf(const std::vector<TrialSummary>& summaries, bool whole, bool warm,
              const std::string& title) {
    Chart chart{
        title,
        warm ? "ms of processor time, meshes at hand" : "ms of processor time, nothing cached",
        "rel_l1",
        {}};
    for (const TrialSummary& summary : summaries) {
        if (summary.whole != whole) continue;
        if (chart.curves.empty() || chart.curves.back().name != summary.knob) {
            chart.curves.push_back({summary.knob, {}});
        }
        chart.curves.back().points.push_back(
            PointOf(summary, warm ? summary.warm_cpu_ms : summary.cold_cpu_ms));
    }
    return chart;
}

// What nothing else beats in both, from fast to slow.
ChartCurve FrontOf(const std::vector<TrialSummary>& summaries) {
    ChartCurve front{"Pareto front", {}, true};
    for (const TrialSummary& summary : summaries) {
        if (summary.front) front.points.push_back(PointOf(summary, summary.warm_cpu_ms));
    }
    std::sort(front.points.begin(), front.points.end(),
              [](const ChartPoint& a, const ChartPoint& b) { return a.x < b.x; });
    return front;
}

// What the reports had estimated against what was measured, each picture a mark; on the dashed line
// both are equal, below it the estimate was too large.
Chart CalibrationOf(const std::vector<TradeoffRow>& rows, const std::vector<Trial>& trials) {
    Chart chart{"Error measured over error estimated", "estimated rel_l1", "rel_l1", {}};
    double least = 1.0, most = kLeastError;
    for (const Trial& trial : trials) {
        if (trial.knob != kBaseKnob) continue;
        ChartCurve marks{"tolerance " + trial.value, {}, false, false};
        for (const TradeoffRow& row : rows) {
            const bool sound = row.rel_l1 > kLeastError && row.estimated > kLeastError &&
                               std::isfinite(row.rel_l1);
            if (row.knob != trial.knob || row.value != trial.value || !sound) continue;
            marks.points.push_back({row.estimated, row.rel_l1, ""});
            least = std::min({least, row.estimated, row.rel_l1});
            most = std::max({most, row.estimated, row.rel_l1});
        }
        if (!marks.points.empty()) chart.curves.push_back(std::move(marks));
    }
    if (!chart.curves.empty()) {
        chart.curves.push_back({"equal", {{least, least, ""}, {most, most, ""}}, true});
    }
    return chart;
}

std::string Lens(const TradeoffRow& row) {
    return row.lens + (row.coatings == "own" ? "" : " (" + row.coatings + ")");
}

std::vector<std::string> LensesOf(const std::vector<TradeoffRow>& rows) {
    std::vector<std::string> lenses;
    for (const TradeoffRow& row : rows) {
        if (std::find(lenses.begin(), lenses.end(), Lens(row)) == lenses.end()) {
            lenses.push_back(Lens(row));
        }
    }
    return lenses;
}

std::vector<TradeoffRow> RowsOf(const std::vector<TradeoffRow>& rows, const std::string& lens) {
    std::vector<TradeoffRow> found;
    for (const TradeoffRow& row : rows) {
        if (Lens(row) == lens) found.push_back(row);
    }
    return found;
}

std::string Percent(double share) {
    return NumberText(100.0 * share, 3);
}

class Html {
  public:
    void Add(std::string_view tag, std::string_view text) {
        text_.append("<").append(tag).append(">").append(EscapedXml(text));
        text_.append("</").append(tag).append(">\n");
    }
    void Raw(std::string_view markup) { text_ += markup; }

    void Table(const std::vector<std::string>& heads,
               const std::vector<std::vector<std::string>>& rows) {
        Raw("<table>\n");
        Row("th", heads);
        for (const std::vector<std::string>& row : rows) Row("td", row);
        Raw("</table>\n");
    }
    std::string Take() { return std::move(text_); }

  private:
    void Row(std::string_view tag, const std::vector<std::string>& cells) {
        Raw("<tr>");
        for (const std::string& cell : cells) Add(tag, cell);
        Raw("</tr>\n");
    }
    std::string text_;
};

void WriteChoice(const std::vector<TrialSummary>& summaries, Html& html) {
    std::vector<std::vector<std::string>> rows;
    for (const TrialSummary& summary : summaries) {
        if (summary.knob != kBaseKnob) continue;
        const auto preset = PresetNames().find(summary.value);
        rows.push_back({summary.value, preset == PresetNames().end() ? "" : preset->second,
                        Percent(summary.rel_l1), Percent(summary.worst_rel_l1),
                        Percent(summary.estimated), Percent(summary.energy),
                        NumberText(summary.cold_cpu_ms, 3), NumberText(summary.warm_cpu_ms, 3),
                        NumberText(summary.warm_ms, 3)});
    }
    if (rows.empty()) return;
    html.Add("h2", "What to choose");
    html.Add("p", "Ask for a preset, or for \"max_error\". Means over all scenes.");
    html.Table({"tolerance", "preset", "rel_l1, %", "worst, %", "estimated, %", "energy, %",
                "cold, CPU ms", "warm, CPU ms", "warm, ms"},
               rows);
}

void WriteTrials(const std::vector<TrialSummary>& summaries, Html& html) {
    html.Add("h2", "Every knob");
    html.Add("p",
             "A knob that is no method of its own is moved alone; all else is as in final "
             "(tolerance 0.005). Errors are geometric means over the scenes, times too.");
    std::vector<std::vector<std::string>> rows;
    for (const TrialSummary& summary : summaries) {
        rows.push_back({summary.knob, summary.value, TruthName(summary.truth),
                        std::to_string(summary.scenes), Percent(summary.rel_l1),
                        Percent(summary.worst_rel_l1), Percent(summary.energy),
                        Percent(summary.rel_l2_blur2), NumberText(summary.stops_mean, 3),
                        NumberText(summary.cold_cpu_ms, 3), NumberText(summary.warm_cpu_ms, 3),
                        NumberText(summary.warm_ms, 3), summary.front ? "yes" : ""});
    }
    html.Table(
        {"knob", "value", "against", "scenes", "rel_l1, %", "worst, %", "energy, %",
         "blurred L2, %", "stops", "cold, CPU ms", "warm, CPU ms", "warm, ms", "on the front"},
        rows);
    std::vector<std::vector<std::string>> words;
    for (const TrialSummary& summary : summaries) {
        if (words.empty() || words.back().front() != summary.knob) {
            words.push_back({summary.knob, KnobWords(summary.knob)});
        }
    }
    html.Table({"knob", "what it is"}, words);
}

void WriteScenes(const std::vector<TradeoffRow>& rows, Html& html) {
    std::vector<std::vector<std::string>> cells;
    for (const TradeoffRow& row : rows) {
        if (row.knob != kBaseKnob || !PresetNames().contains(row.value)) continue;
        cells.push_back({Lens(row), NumberText(row.f_number), NumberText(row.field_deg),
                         PresetNames().at(row.value), Percent(row.rel_l1), Percent(row.estimated),
                         Percent(row.energy), NumberText(row.stops_p99, 3),
                         NumberText(row.cold_cpu_ms, 3), NumberText(row.warm_cpu_ms, 3),
                         NumberText(row.warm_ms, 3)});
    }
    if (cells.empty()) return;
    html.Add("h2", "The presets, scene by scene");
    html.Table({"lens", "f-number", "field, deg", "preset", "rel_l1, %", "estimated, %",
                "energy, %", "stops, p99", "cold, CPU ms", "warm, CPU ms", "warm, ms"},
               cells);
}

constexpr std::string_view kHead = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8"/>
<title>flare tradeoff</title>
<style>
body { font: 15px/1.5 sans-serif; max-width: 64em; margin: 2em auto; color: #22303c; }
table { border-collapse: collapse; margin: 1em 0; font-size: 13px; }
th, td { border: 1px solid #c9d1d8; padding: 2px 8px; text-align: right; }
th:first-child, td:first-child { text-align: left; }
svg { width: 100%; }
</style>
</head>
<body>
)";

}  // namespace

std::vector<NamedSvg> TradeoffCharts(const std::vector<TradeoffRow>& rows,
                                     const std::vector<Trial>& trials) {
    const std::vector<TrialSummary> all = Summarise(rows, trials);
    Chart warm = ChartOf(all, true, true, "Error over time, methods");
    warm.curves.push_back(FrontOf(all));
    std::vector<NamedSvg> charts{
        {"methods_warm.svg", ChartSvg(warm)},
        {"methods_cold.svg", ChartSvg(ChartOf(all, true, false, "Error over time, methods"))},
        {"knobs.svg", ChartSvg(ChartOf(all, false, false, "One setting of final moved alone"))},
        {"estimate.svg", ChartSvg(CalibrationOf(rows, trials))}};
    int number = 0;
    for (const std::string& lens : LensesOf(rows)) {
        const std::vector<TrialSummary> summaries = Summarise(RowsOf(rows, lens), trials);
        charts.push_back({"lens_" + std::to_string(++number) + ".svg",
                          ChartSvg(ChartOf(summaries, true, true, lens))});
    }
    return charts;
}

std::string TradeoffPage(const std::vector<TradeoffRow>& rows, const std::vector<Trial>& trials,
                         const std::vector<NamedSvg>& charts) {
    const std::vector<TrialSummary> summaries = Summarise(rows, trials);
    Html html;
    html.Raw(kHead);
    html.Add("h1", "Error against time");
    std::set<std::string> sizes;
    int threads = 0;
    for (const TradeoffRow& row : rows) {
        sizes.insert(std::to_string(row.width) + " x " + std::to_string(row.height));
        threads = std::max(threads, row.threads);
    }
    std::string size;
    for (const std::string& one : sizes) size += (size.empty() ? "" : ", ") + one;
    html.Add("p", std::to_string(rows.size()) + " measurements of pictures of " + size +
                      " pixels on " + std::to_string(threads) +
                      " thread(s). rel_l1 is the sum of |E - Er| over that of Er, against the "
                      "picture of the preset reference; times are those of this machine, and of "
                      "whatever else it did.");
    WriteChoice(summaries, html);
    for (const NamedSvg& chart : charts) html.Raw(chart.svg);
    WriteTrials(summaries, html);
    WriteScenes(rows, html);
    html.Raw("</body>\n</html>\n");
    return html.Take();
}

}  // namespace flare
