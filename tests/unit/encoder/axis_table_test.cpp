// SPDX-License-Identifier: Apache-2.0
//
// The marks of a real lens (a 50 mm T1.4 with marks from 0.45 m to infinity) round-trip.
#include "server/encoder/axis_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace flare {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

AxisMarks FocusMarks() {
    // 300 degrees of 10 counts each; engraved marks lie about evenly in 1/distance.
    return {{0, 310, 640, 950, 1250, 1530, 1800, 2080, 2330, 2520, 2660, 2820, 3000},
            {0.45, 0.5, 0.55, 0.6, 0.7, 0.8, 0.9, 1.2, 1.5, 2, 3, 5, kInfinity}};
}
AxisMarks IrisMarks() {
    return {{0, 50, 148, 251, 349, 452, 549, 651, 752}, {1.4, 2, 2.8, 4, 5.6, 8, 11, 16, 22}};
}

AxisTable Built(LensAxis axis, const AxisMarks& marks) {
    const Result<AxisTable> table = AxisTable::Build(axis, marks);
    EXPECT_TRUE(table.ok()) << table.error().where << table.error().message;
    return *table;
}

TEST(AxisTable, GivesTheMarksToTheLastBit) {
    const AxisMarks focus = FocusMarks(), iris = IrisMarks();
    const AxisTable focus_table = Built(LensAxis::kFocus, focus);
    const AxisTable iris_table = Built(LensAxis::kIris, iris);
    for (std::size_t i = 0; i < focus.raw.size(); ++i) {
        EXPECT_EQ(focus_table.Value(focus.raw[i]), focus.value[i]);
    }
    for (std::size_t i = 0; i < iris.raw.size(); ++i) {
        EXPECT_EQ(iris_table.Value(iris.raw[i]), iris.value[i]);
    }
}

TEST(AxisTable, IsMonotoneBetweenTheMarksAndHeldBeyond) {
    const AxisTable focus = Built(LensAxis::kFocus, FocusMarks());
    double last = 0.0;
    for (double count = -50.0; count <= 3050.0; count += 0.5) {
        const double value = focus.Value(count);
        EXPECT_GE(value, last) << count;
        if (count > 0.0 && count < 3000.0) {
            EXPECT_GT(value, last) << count;
        }
        last = value;
    }
    EXPECT_EQ(focus.Value(-1e9), 0.45);
    EXPECT_EQ(focus.Value(1e9), kInfinity);
}

// Where the ring is even in the variable of interpolation, two marks say everything.
TEST(AxisTable, InterpolatesInTheEvenVariable) {
    const AxisTable focus = Built(LensAxis::kFocus, {{0, 100}, {1.0, kInfinity}});
    EXPECT_NEAR(focus.Value(50), 2.0, 1e-12);
    EXPECT_NEAR(focus.Value(75), 4.0, 1e-12);
    const AxisTable iris = Built(LensAxis::kIris, {{0, 100}, {2.0, 8.0}});
    EXPECT_NEAR(iris.Value(50), 4.0, 1e-12);
    const AxisTable zoom = Built(LensAxis::kZoom, {{100, 0}, {24.0, 96.0}});
    EXPECT_NEAR(zoom.Value(50), 48.0, 1e-12);
}

TEST(AxisTable, TurnsRoundShiftsAndWraps) {
    AxisMarks marks{{0, 1000}, {2.0, 8.0}};
    marks.zero = 3900;
    marks.wrap = 4096;
    const AxisTable wrapped = Built(LensAxis::kIris, marks);
    EXPECT_EQ(wrapped.Value(3900), 2.0);
    EXPECT_EQ(wrapped.Value(3900 + 1000 - 4096), 8.0);  // past the encoder's own zero
    EXPECT_NEAR(wrapped.Value(3900 + 500 - 4096), 4.0, 1e-12);
    EXPECT_EQ(wrapped.Value(3900 + 2 * 4096), 2.0);
    marks.reverse = true;
    const AxisTable reversed = Built(LensAxis::kIris, marks);
    EXPECT_NEAR(reversed.Value(3900 - 500), 4.0, 1e-12);
    EXPECT_EQ(reversed.Value(3900 - 1000), 8.0);
}

TEST(AxisTable, RefusesWhatIsNoTable) {
    const struct {
        LensAxis axis;
        AxisMarks marks;
        const char* where;
    } kBad[] = {
        {LensAxis::kFocus, {{1}, {1}}, "raw"},
        {LensAxis::kFocus, {{1, 2}, {1}}, "value"},
        {LensAxis::kFocus, {{1, 1}, {1, 2}}, "raw"},
        {LensAxis::kFocus, {{1, std::nan("")}, {1, 2}}, "raw"},
        {LensAxis::kFocus, {{1, 2}, {0, 2}}, "value"},
        {LensAxis::kFocus, {{1, 2, 3}, {1, 3, 2}}, "value"},
        {LensAxis::kFocus, {{1, 2, 3}, {1, kInfinity, kInfinity}}, "value"},
        {LensAxis::kIris, {{1, 2}, {1, kInfinity}}, "value"},
        {LensAxis::kIris, {{1, 2}, {2, 2}}, "value"},
        {LensAxis::kIris, {{1, 900}, {2, 4}, 0, false, 800}, "wrap"},
        {LensAxis::kIris, {{1, 2}, {2, 4}, 0, false, -1}, "wrap"},
    };
    for (const auto& row : kBad) {
        const auto table = AxisTable::Build(row.axis, row.marks);
        ASSERT_FALSE(table.ok()) << &row - kBad;
        EXPECT_EQ(table.error().where, row.where) << &row - kBad << table.error().message;
    }
}

}  // namespace
}  // namespace flare
