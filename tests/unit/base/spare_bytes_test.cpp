// SPDX-License-Identifier: Apache-2.0
#include "core/base/spare_bytes.h"

#include <gtest/gtest.h>

#include <utility>

namespace flare {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;

TEST(SpareBytes, GivesBackTheSameMemoryRoomiestFirst) {
    SpareBytes spare;
    EXPECT_TRUE(spare.Take().empty());
    std::string small(kMiB, 'a'), large(3 * kMiB, 'b');
    const char* const small_at = small.data();
    const char* const large_at = large.data();
    spare.Keep(std::move(small));
    spare.Keep(std::move(large));
    const std::string first = spare.Take(), second = spare.Take();
    EXPECT_EQ(first.data(), large_at);
    EXPECT_EQ(second.data(), small_at);
    EXPECT_EQ(spare.Take().capacity(), std::string().capacity());
}

TEST(SpareBytes, HoldsNoMoreThanItsBounds) {
    SpareBytes spare(2, 5 * kMiB);
    spare.Keep(std::string(3 * kMiB, 'a'));
    spare.Keep(std::string(4 * kMiB, 'b'));  // seven in all
    spare.Keep(std::string(kMiB, 'c'));
    spare.Keep(std::string(kMiB / 2, 'd'));  // a third
    spare.Keep("too small to matter");
    EXPECT_EQ(spare.Take()[0], 'a');
    EXPECT_EQ(spare.Take()[0], 'c');
    EXPECT_TRUE(spare.Take().empty());
}

}  // namespace
}  // namespace flare
