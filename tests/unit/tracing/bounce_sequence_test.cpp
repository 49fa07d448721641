// SPDX-License-Identifier: Apache-2.0
#include "core/tracing/bounce_sequence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/tracing/interaction_list.h"
#include "tests/support/lenses.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::BuildLens;
using testing::SeedLens;

TEST(TwoReflectionSequences, AreAllPairsOfRefractingSurfaces) {
    const auto lens = BuildLens(SeedLens());
    const std::vector<BounceSequence> all = TwoReflectionSequences(*lens);
    EXPECT_EQ(all.size(), 45U);  // 10 * 9 / 2
    int once = 0, thrice = 0;
    for (const BounceSequence& s : all) {
        ASSERT_EQ(s.size(), 2U);
        EXPECT_GT(s[0], s[1]);
        EXPECT_NE(s[0], 5);
        EXPECT_NE(s[1], 5);
        EXPECT_FALSE(CheckSequence(*lens, s).has_value());
        const int crossings = WriteOut(*lens, s, kLineD).stop_crossings;
        (crossings == 1 ? once : thrice) += 1;
        EXPECT_EQ(crossings, s[0] > 5 && s[1] < 5 ? 3 : 1);
    }
    // 5 surfaces in front of the stop, 5 behind: 10 + 10 cross it once, 25 three times.
    EXPECT_EQ(once, 20);
    EXPECT_EQ(thrice, 25);
    EXPECT_EQ(std::set<BounceSequence>(all.begin(), all.end()).size(), 45U);
    EXPECT_TRUE(std::is_sorted(all.begin(), all.end()));
}

TEST(CheckSequence, AcceptsWhatLightCanDo) {
    const auto lens = BuildLens(SeedLens());
    for (const BounceSequence& s :
         {BounceSequence{}, {1, 0}, {10, 9}, {10, 0}, {3, 1, 2, 0}, {9, 2, 10, 8}}) {
        EXPECT_FALSE(CheckSequence(*lens, s).has_value());
    }
}

TEST(CheckSequence, RefusesWhatItCannot) {
    const auto lens = BuildLens(SeedLens());
    for (const BounceSequence& s : {BounceSequence{4},  // an odd number comes out at the front
                                    {4, 4},
                                    {1, 4},
                                    {5, 2},
                                    {8, 5},
                                    {11, 2},
                                    {3, -1},
                                    {3, 1, 1, 0},
                                    {3, 1, 2, 2},
                                    {3, 1, 2},
                                    {1 << 30, 0}}) {
        const auto error = CheckSequence(*lens, s);
        ASSERT_TRUE(error.has_value());
        EXPECT_EQ(error->code, "bad_value");
        EXPECT_FALSE(error->message.empty());
    }
}

TEST(WriteOut, ListsTheSurfacesInTheOrderTheLightMeetsThem) {
    const auto lens = BuildLens(SeedLens());
    const InteractionList list = WriteOut(*lens, {3, 1}, kLineD);
    const std::vector<int> order{0, 1, 2, 3, 2, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
    ASSERT_EQ(list.steps.size(), order.size());
    for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(list.steps[i].surface, order[i]);
    EXPECT_EQ(list.steps[3].kind, InteractionKind::kReflect);
    EXPECT_TRUE(list.steps[3].forward);
    EXPECT_FALSE(list.steps[4].forward);
    EXPECT_EQ(list.steps[5].kind, InteractionKind::kReflect);
    EXPECT_FALSE(list.steps[5].forward);
    EXPECT_TRUE(list.steps[6].forward);
    EXPECT_EQ(list.steps[9].kind, InteractionKind::kStop);
    // The light is in the medium behind the last crossing: indices join from step to step.
    for (std::size_t i = 0; i + 1 < list.steps.size(); ++i) {
        const Interaction& a = list.steps[i];
        const double leaves = a.kind == InteractionKind::kReflect ? a.n_in : a.n_out;
        EXPECT_EQ(leaves, list.steps[i + 1].n_in) << i;
    }
    EXPECT_EQ(list.steps.front().n_in, 1.0);
    EXPECT_EQ(list.steps.back().n_out, 1.0);
}

TEST(ReflectionAt, TakesCoatingsFromTheRightSide) {
    const auto lens = BuildLens(SeedLens());
    const InteractionList list = WriteOut(*lens, {1, 0}, kLineD);
    // Surface 0 forwards (air to glass), then backwards from inside: the same share, by
    // reciprocity.
    const Interaction& in = list.steps[0];
    const Interaction& inside = list.steps[2];
    ASSERT_EQ(in.surface, 0);
    ASSERT_EQ(inside.surface, 0);
    ASSERT_FALSE(inside.forward);
    EXPECT_NEAR(ReflectionAt(*lens, in, 1.0, kLineD).reflectance,
                ReflectionAt(*lens, inside, 1.0, kLineD).reflectance, 1e-14);
    EXPECT_LT(ReflectionAt(*lens, in, 1.0, kLineD).reflectance, 0.01);
    // The stop lets everything through.
    EXPECT_EQ(ReflectionAt(*lens, WriteOut(*lens, {}, kLineD).steps[5], 0.3, kLineD).transmittance,
              1.0);
}

}  // namespace
}  // namespace flare
