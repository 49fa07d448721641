// SPDX-License-Identifier: Apache-2.0
//
// The sweep itself is a scenario; here are its parts that need no picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "server/tradeoff/chart.h"
#include "server/tradeoff/summary.h"

namespace flare {
namespace {

TradeoffRow Row(const std::string& knob, const std::string& value, double error, double ms) {
    TradeoffRow row;
    row.lens = "a \"quoted\", lens";
    row.truth = "ghosts";
    row.knob = knob;
    row.value = value;
    row.f_number = 5.6;
    row.rel_l1 = error;
    row.warm_cpu_ms = ms;
    row.runs = 3;
    return row;
}

TEST(TradeoffTable, ReadsBackWhatItWrote) {
    TradeoffRow row = Row("grid", "16", 0.1234567890123456789, 1.0 / 3.0);
    row.energy = -std::numeric_limits<double>::infinity();
    const Result<std::vector<TradeoffRow>> rows = RowsFromCsv(CsvHead() + CsvLine(row));
    ASSERT_TRUE(rows.ok());
    ASSERT_EQ(rows->size(), 1U);
    EXPECT_EQ(rows->front().Key(), row.Key());
    EXPECT_EQ(rows->front().lens, row.lens);
    EXPECT_EQ(rows->front().rel_l1, row.rel_l1);
    EXPECT_EQ(rows->front().energy, row.energy);
    EXPECT_EQ(rows->front().warm_cpu_ms, row.warm_cpu_ms);
    EXPECT_EQ(CsvLine(rows->front()), CsvLine(row));
}

TEST(TradeoffTable, DropsALineThatWasCutShortAndNamesABadOne) {
    const std::string whole = CsvHead() + CsvLine(Row("grid", "16", 0.1, 1.0));
    const std::string next = CsvLine(Row("grid", "32", 0.05, 2.0));
    for (std::size_t length = 0; length + 1 < next.size(); ++length) {
        const auto rows = RowsFromCsv(whole + next.substr(0, length));
        ASSERT_TRUE(rows.ok());
        EXPECT_EQ(rows->size(), 1U);
    }
    const auto bad = RowsFromCsv(whole + "1,2,3\n");
    ASSERT_FALSE(bad.ok());
    EXPECT_EQ(bad.error().where, "line 3");
    EXPECT_FALSE(RowsFromCsv("x,y\n").ok());
}

TEST(Trials, AreDifferentAndCanBePicked) {
    const Result<std::vector<Trial>> all = TrialsOf({});
    ASSERT_TRUE(all.ok());
    std::set<std::string> names, knobs;
    for (const Trial& trial : *all) {
        names.insert(trial.name());
        knobs.insert(trial.knob);
    }
    EXPECT_EQ(names.size(), all->size());
    EXPECT_EQ(knobs.size(), KnobNames().size());
    const auto picked = TrialsOf({"order", "grid=16"});
    ASSERT_TRUE(picked.ok());
    ASSERT_EQ(picked->size(), 3U);
    EXPECT_EQ(picked->front().name(), "grid 16");
    EXPECT_EQ(picked->front().settings.mesh_cells, 16);
    EXPECT_FALSE(picked->at(1).settings.cubic);
    EXPECT_FALSE(TrialsOf({"grid=17"}).ok());
    EXPECT_FALSE(TrialsOf({"angle-knots"}).ok());
}

// Every knob's values include that of the preset that it is moved away from.
TEST(Trials, TouchOneSettingOfFinalAlone) {
    const QualitySettings base = SettingsOf(Quality(QualityPreset::kFinal));
    const auto grid = TrialsOf({"grid"});
    ASSERT_TRUE(grid.ok());
    for (const Trial& trial : *grid) {
        EXPECT_EQ(std::to_string(trial.settings.mesh_cells), trial.value);
        EXPECT_EQ(trial.settings.colour_bands, base.colour_bands);
        EXPECT_EQ(trial.settings.tiles->light, base.tiles->light);
        EXPECT_EQ(trial.settings.patch_cells, base.patch_cells);
    }
}

TEST(Summary, TakesGeometricMeansAndFindsTheFront) {
    const auto trials = TrialsOf({"grid"});  // 8, 16, 32, 64, 128
    ASSERT_TRUE(trials.ok());
    std::vector<TradeoffRow> rows{Row("grid", "8", 0.4, 10.0), Row("grid", "8", 0.1, 1000.0),
                                  Row("grid", "16", 0.02, 50.0), Row("grid", "32", 0.03, 60.0),
                                  Row("grid", "64", 0.0, 200.0)};
    rows.push_back(Row("grid", "64", std::numeric_limits<double>::infinity(), 200.0));
    const std::vector<TrialSummary> found = Summarise(rows, *trials);
    ASSERT_EQ(found.size(), 4U);
    EXPECT_NEAR(found[0].rel_l1, 0.2, 1e-12);
    EXPECT_EQ(found[0].worst_rel_l1, 0.4);
    EXPECT_NEAR(found[0].warm_cpu_ms, 100.0, 1e-9);
    EXPECT_EQ(found[0].scenes, 2);
    EXPECT_FALSE(found[0].front) << "16 is better and faster";
    EXPECT_TRUE(found[1].front);
    EXPECT_FALSE(found[2].front) << "worse and slower than 16";
    EXPECT_NEAR(found[3].rel_l1, kLeastError, 1e-12);
    EXPECT_EQ(found[3].scenes, 1);
    EXPECT_TRUE(found[3].front);
}

TEST(Chart, PlacesADecadeEvenly) {
    Chart chart{"t", "x", "y", {{"a", {{1.0, 1.0, "p<1"}, {10.0, 0.1, ""}, {100.0, 0.01, ""}}}}};
    const std::string svg = ChartSvg(chart);
    EXPECT_NE(svg.find("p&lt;1"), std::string::npos);
    std::vector<double> xs;
    for (std::size_t at = svg.find("cx=\""); at != std::string::npos;
         at = svg.find("cx=\"", at + 1)) {
        xs.push_back(std::stod(svg.substr(at + 4)));
    }
    ASSERT_EQ(xs.size(), 3U);
    EXPECT_NEAR(xs[1] - xs[0], xs[2] - xs[1], 0.2);
    EXPECT_GT(xs[1], xs[0] + 100.0);
    EXPECT_NE(ChartSvg({"t", "x", "y", {}}).find("nothing measured"), std::string::npos);
}

}  // namespace
}  // namespace flare
