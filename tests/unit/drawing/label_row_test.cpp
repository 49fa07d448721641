// SPDX-License-Identifier: Apache-2.0
#include "core/drawing/label_row.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/random.h"

namespace flare {
namespace {

TEST(SpreadLabels, LeavesThoseThatFitWhereTheyWish) {
    const std::vector<double> x = SpreadLabels({{10.0, 8.0}, {60.0, 8.0}, {30.0, 8.0}}, 0.0, 100.0);
    EXPECT_EQ(x, (std::vector<double>{10.0, 60.0, 30.0}));
    EXPECT_TRUE(SpreadLabels({}, 0.0, 1.0).empty());
}

TEST(SpreadLabels, SharesTheWayEvenly) {
    const std::vector<double> x = SpreadLabels({{50.0, 10.0}, {50.0, 20.0}}, 0.0, 100.0);
    EXPECT_NEAR(x[1] - x[0], 15.0, 1e-12);
    EXPECT_NEAR(0.5 * (x[0] + x[1]), 50.0, 1e-12);
}

TEST(SpreadLabels, KeepsToTheEdgesIfThereIsRoom) {
    const std::vector<double> x =
        SpreadLabels({{0.0, 10.0}, {1.0, 10.0}, {99.0, 10.0}}, 0.0, 100.0);
    EXPECT_NEAR(x[0], 5.0, 1e-12);
    EXPECT_NEAR(x[1], 15.0, 1e-12);
    EXPECT_NEAR(x[2], 95.0, 1e-12);
}

TEST(SpreadLabels, NeverOverlapAndCannotBeBetteredByMovingOne) {
    testing::Random random(7);
    for (int round = 0; round < 200; ++round) {
        std::vector<RowLabel> labels(12);
        for (RowLabel& label : labels) {
            label = {random.Uniform(100.0, 900.0), random.Uniform(5.0, 60.0)};
        }
        const std::vector<double> x = SpreadLabels(labels, -2000.0, 3000.0);
        for (std::size_t i = 0; i < labels.size(); ++i) {
            for (std::size_t j = 0; j < i; ++j) {
                const double apart = 0.5 * (labels[i].width + labels[j].width);
                EXPECT_GE(std::abs(x[i] - x[j]), apart - 1e-9);
            }
            // A step towards its wish must run into a neighbour.
            const double step = labels[i].wish > x[i] ? 1e-3 : -1e-3;
            if (std::abs(labels[i].wish - x[i]) < 2e-3) continue;
            bool blocked = false;
            for (std::size_t j = 0; j < labels.size(); ++j) {
                const double apart = 0.5 * (labels[i].width + labels[j].width);
                blocked |= j != i && std::abs(x[i] + step - x[j]) < apart - 1e-6;
            }
            EXPECT_TRUE(blocked);
        }
    }
}

TEST(TextWidth, CountsCharactersNotBytes) {
    EXPECT_EQ(TextWidth("\xE2\x86\x92 5\xC2\xB0", 10.0), TextWidth("> 5o", 10.0));
}

}  // namespace
}  // namespace flare
