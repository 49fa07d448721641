// SPDX-License-Identifier: Apache-2.0
//
// What a state table can get wrong: one fault each, named with its place.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <ostream>

#include "core/optics/lens_state.h"
#include "tests/support/zoom_lens.h"

namespace flare {
namespace {

using testing::InnerFocusing;
using testing::Zoom;

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct BadTable {
    const char* what;
    std::function<void(StateTable&)> spoil;
    const char* where;
    const char* says;
};

void PrintTo(const BadTable& table, std::ostream* out) {
    *out << table.what;
}

class RefusedStates : public ::testing::TestWithParam<BadTable> {};

TEST_P(RefusedStates, AreNamedAndStopTheLens) {
    Prescription zoom = Zoom();
    zoom.states.where = "#states";
    GetParam().spoil(zoom.states);
    const std::vector<StateFault> faults = FindStateFaults(zoom);
    ASSERT_EQ(faults.size(), 1U);
    EXPECT_EQ(faults[0].where, GetParam().where);
    EXPECT_NE(faults[0].message.find(GetParam().says), std::string::npos) << faults[0].message;
    const auto lens = Lens::Build(zoom);
    ASSERT_FALSE(lens.ok());
    EXPECT_EQ(lens.error().code, "bad_lens");
    EXPECT_EQ(lens.error().where, GetParam().where);
}

INSTANTIATE_TEST_SUITE_P(
    Table, RefusedStates,
    ::testing::Values(
        BadTable{"no axis",
                 [](StateTable& table) {
                     table.focal_mm.clear();
                     table.f_number.clear();
                 },
                 "#states", "needs an axis"},
        BadTable{"f-numbers alone",
                 [](StateTable& table) {
                     table = {};
                     table.f_number = {2.8};
                     table.where = "#states";
                 },
                 "#states", "needs an axis"},
        BadTable{"one position",
                 [](StateTable& table) {
                     table.focal_mm = {45.0};
                     table.f_number.clear();
                 },
                 "#states", "2 to 64 positions, not 1"},
        BadTable{"too many positions",
                 [](StateTable& table) {
                     table.f_number.clear();
                     table.focal_mm.clear();
                     for (int i = 0; i < 65; ++i) table.focal_mm.push_back(45.0 + i);
                 },
                 "#states", "2 to 64 positions, not 65"},
        BadTable{"focal lengths that fall",
                 [](StateTable& table) { std::swap(table.focal_mm[1], table.focal_mm[2]); },
                 "#states", "focal_mm must rise"},
        BadTable{"equal focal lengths", [](StateTable& table) { table.focal_mm[1] = 45.0; },
                 "#states", "focal_mm must rise"},
        BadTable{"a focal length of 0", [](StateTable& table) { table.focal_mm[0] = 0.0; },
                 "#states", "focal_mm must rise from above 0"},
        BadTable{"a focal length that is none", [](StateTable& table) { table.focal_mm[3] = kNan; },
                 "#states", "focal_mm must rise"},
        BadTable{"an endless focal length", [](StateTable& table) { table.focal_mm[3] = kInf; },
                 "#states", "focal_mm must rise"},
        BadTable{"focus that does not begin at infinity",
                 [](StateTable& table) {
                     table.focus_m = {3.0, 2.0};
                 },
                 "#states", "begin with inf"},
        BadTable{"focus that rises",
                 [](StateTable& table) {
                     table.focus_m = {kInf, 2.0, 3.0};
                 },
                 "#states", "focus_m must begin with inf and fall"},
        BadTable{"focus at 0",
                 [](StateTable& table) {
                     table.focus_m = {kInf, 0.0};
                 },
                 "#states", "above 0"},
        BadTable{"an f-number too few", [](StateTable& table) { table.f_number.pop_back(); },
                 "#states", "one value for each zoom position"},
        BadTable{"an f-number of 0", [](StateTable& table) { table.f_number[2] = 0.0; }, "#states",
                 "f_number must be above 0"},
        BadTable{"an endless f-number", [](StateTable& table) { table.f_number[2] = kInf; },
                 "#states", "f_number must be above 0"},
        BadTable{"a surface that the lens has not",
                 [](StateTable& table) { table.gaps[1].surface = 5; }, "#s",
                 "surface 5, which the lens has not"},
        BadTable{"a surface before the first",
                 [](StateTable& table) { table.gaps[1].surface = -1; }, "#s", "surface -1"},
        BadTable{"a value too many", [](StateTable& table) { table.gaps[0].values.push_back(1.0); },
                 "#d", "surface 1 needs 4 values, not 5"},
        BadTable{"values for one axis of two",
                 [](StateTable& table) {
                     table.gaps = {table.gaps[0]};
                     table.semi_diameters.clear();
                     table.focus_m = {kInf, 1.0};
                 },
                 "#d", "surface 1 needs 8 values, not 4"},
        BadTable{"a negative gap", [](StateTable& table) { table.gaps[0].values[2] = -0.1; }, "#d",
                 "-0.1 mm of surface 1 is not within 0 .. 100000 mm"},
        BadTable{"a gap that is none", [](StateTable& table) { table.gaps[0].values[2] = kNan; },
                 "#d", "nan mm of surface 1"},
        BadTable{"a rim of 0", [](StateTable& table) { table.semi_diameters[0].values[1] = 0.0; },
                 "#r", "0 mm of surface 2 is not within 1e-06 .. 10000 mm"},
        BadTable{"a first gap that is not the surface's",
                 [](StateTable& table) { table.gaps[1].values[0] += 0.001; }, "#s",
                 "but the surface itself has"},
        BadTable{"a first rim that is not the surface's",
                 [](StateTable& table) { table.semi_diameters[0].values[0] = 6.5; }, "#r",
                 "begin with 6.5 mm but the surface itself has 6 mm"}));

TEST(StateFaults, NameASurfaceGivenTwiceAtBothPlaces) {
    Prescription zoom = Zoom();
    zoom.states.gaps.push_back(zoom.states.gaps[0]);
    zoom.states.gaps.back().where = "#again";
    const std::vector<StateFault> faults = FindStateFaults(zoom);
    ASSERT_EQ(faults.size(), 2U);
    EXPECT_EQ(faults[0].where, "#d");
    EXPECT_EQ(faults[1].where, "#again");
    EXPECT_NE(faults[1].message.find("surface 1 twice"), std::string::npos);
}

TEST(StateFaults, AskForASensorDistanceWhereTheTableMovesTheSensor) {
    Prescription zoom = Zoom();
    zoom.surfaces.back().gap_given = false;
    const std::vector<StateFault> faults = FindStateFaults(zoom);
    ASSERT_EQ(faults.size(), 1U);
    EXPECT_NE(faults[0].message.find("the surface itself has none"), std::string::npos);
}

TEST(StateFaults, OfAGoodTableAreNone) {
    for (const Prescription& lens : {Zoom(), InnerFocusing(), testing::SeedLens()}) {
        for (const StateFault& fault : FindStateFaults(lens)) ADD_FAILURE() << fault.message;
    }
}

}  // namespace
}  // namespace flare
