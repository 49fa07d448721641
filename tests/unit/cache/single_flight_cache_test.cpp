// SPDX-License-Identifier: Apache-2.0
#include "server/cache/single_flight_cache.h"

#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

namespace flare {
namespace {

using namespace std::chrono_literals;

struct Block {
    std::uint64_t name = 0;
    std::size_t bytes = 0;
};
using Cache = SingleFlightCache<Block>;

Cache MakeCache(std::size_t max_bytes) {
    return Cache(max_bytes, [](const Block& block) { return block.bytes; });
}

Fingerprint Key(std::uint64_t name) {
    return {name * 0x9E3779B97F4A7C15U, name};
}

// Asks for a block and says whether it had to be built.
bool Builds(Cache& cache, std::uint64_t name, std::size_t bytes) {
    const auto found = cache.Get(Key(name), [&] { return Block{name, bytes}; }, {});
    EXPECT_TRUE(found.ok());
    EXPECT_EQ(found->value->name, name);
    return !found->hit;
}

TEST(SingleFlightCache, KeepsWhatFitsAndCountsHits) {
    Cache cache = MakeCache(100);
    EXPECT_TRUE(Builds(cache, 1, 40));
    EXPECT_TRUE(Builds(cache, 2, 60));
    EXPECT_FALSE(Builds(cache, 1, 40));
    EXPECT_FALSE(Builds(cache, 2, 60));
    const CacheStats stats = cache.stats();
    EXPECT_EQ(stats.hits, 2U);
    EXPECT_EQ(stats.misses, 2U);
    EXPECT_EQ(stats.evictions, 0U);
    EXPECT_EQ(stats.bytes, 100U);
    EXPECT_EQ(stats.entries, 2U);
}

TEST(SingleFlightCache, TheLeastRecentlyUsedGoesFirst) {
    Cache cache = MakeCache(100);
    Builds(cache, 1, 40);
    Builds(cache, 2, 40);
    EXPECT_FALSE(Builds(cache, 1, 40));  // now 2 is the oldest
    EXPECT_TRUE(Builds(cache, 3, 40));
    EXPECT_FALSE(Builds(cache, 1, 40));
    EXPECT_FALSE(Builds(cache, 3, 40));
    EXPECT_TRUE(Builds(cache, 2, 40));
    EXPECT_EQ(cache.stats().evictions, 2U);
    EXPECT_EQ(cache.stats().bytes, 80U);
}

TEST(SingleFlightCache, OneLargeValuePushesOutSeveralSmallOnes) {
    Cache cache = MakeCache(100);
    for (std::uint64_t name = 0; name < 10; ++name) Builds(cache, name, 10);
    Builds(cache, 50, 95);
    EXPECT_EQ(cache.stats().evictions, 10U);
    EXPECT_EQ(cache.stats().bytes, 95U);
    EXPECT_EQ(cache.stats().entries, 1U);
}

TEST(SingleFlightCache, AValueLargerThanTheBoundIsGivenButNotKept) {
    Cache cache = MakeCache(100);
    Builds(cache, 1, 100);
    EXPECT_TRUE(Builds(cache, 2, 101));
    EXPECT_TRUE(Builds(cache, 2, 101));
    EXPECT_FALSE(Builds(cache, 1, 100)) << "it must not push others out on its way through";
    EXPECT_EQ(cache.stats().bytes, 100U);
}

TEST(SingleFlightCache, ABoundOfZeroKeepsNothing) {
    Cache cache = MakeCache(0);
    EXPECT_TRUE(Builds(cache, 1, 1));
    EXPECT_TRUE(Builds(cache, 1, 1));
    EXPECT_EQ(cache.stats().bytes, 0U);
}

TEST(SingleFlightCache, EqualKeysInFlightAreBuiltOnce) {
    Cache cache = MakeCache(100);
    std::atomic<int> builds = 0, hits = 0;
    std::vector<std::jthread> callers;
    for (int i = 0; i < 16; ++i) {
        callers.emplace_back([&] {
            const auto found = cache.Get(Key(1),
                                         [&] {
                                             ++builds;
                                             std::this_thread::sleep_for(50ms);
                                             return Block{1, 10};
                                         },
                                         {});
            ASSERT_TRUE(found.ok());
            EXPECT_EQ(found->value->name, 1U);
            if (found->hit) ++hits;
        });
    }
    callers.clear();
    EXPECT_EQ(builds, 1);
    EXPECT_EQ(hits, 15);
    EXPECT_EQ(cache.stats().misses, 1U);
    EXPECT_EQ(cache.stats().hits, 15U);
}

TEST(SingleFlightCache, WaitersShareAValueTooLargeToKeep) {
    Cache cache = MakeCache(1);
    std::atomic<int> builds = 0;
    std::atomic<bool> started = false;
    const auto build = [&] {
        ++builds;
        started = true;
        std::this_thread::sleep_for(100ms);
        return Block{1, 1000};
    };
    std::jthread builder([&] { ASSERT_TRUE(cache.Get(Key(1), build, {}).ok()); });
    while (!started) std::this_thread::yield();
    const auto found = cache.Get(Key(1), build, {});
    ASSERT_TRUE(found.ok());
    EXPECT_EQ(found->value->bytes, 1000U);
    EXPECT_EQ(builds, 1);
}

TEST(SingleFlightCache, ACancelledWaiterLeavesAndTheBuilderGoesOn) {
    Cache cache = MakeCache(100);
    std::atomic<bool> started = false, finish = false;
    std::jthread builder([&] {
        const auto found = cache.Get(Key(1),
                                     [&] {
                                         started = true;
                                         while (!finish) std::this_thread::sleep_for(1ms);
                                         return Block{1, 10};
                                     },
                                     {});
        EXPECT_TRUE(found.ok());
    });
    while (!started) std::this_thread::yield();
    CancelToken token;
    std::jthread leaver([&] {
        std::this_thread::sleep_for(20ms);
        token.Cancel();
    });
    const auto found = cache.Get(
        Key(1),
        [] {
            return Block{2, 10};
        },
        token);
    ASSERT_FALSE(found.ok());
    EXPECT_EQ(found.error().code, "cancelled");
    finish = true;
    builder.join();
    EXPECT_FALSE(Builds(cache, 1, 10));
}

TEST(SingleFlightCache, AKeyBeingBuiltDoesNotHoldUpOthers) {
    Cache cache = MakeCache(100);
    const auto outer = cache.Get(Key(1),
                                 [&] {
                                     EXPECT_TRUE(Builds(cache, 2, 10));
                                     return Block{1, 10};
                                 },
                                 {});
    ASSERT_TRUE(outer.ok());
    EXPECT_EQ(cache.stats().entries, 2U);
}

TEST(SingleFlightCache, AValueThatWasPushedOutLivesForItsHolders) {
    Cache cache = MakeCache(10);
    const auto found = cache.Get(Key(1), [] { return Block{1, 10}; }, {});
    Builds(cache, 2, 10);
    EXPECT_EQ(found->value->name, 1U);
    EXPECT_EQ(found->value.use_count(), 1);
}

TEST(SingleFlightCache, ABuildThatThrowsLeavesNoOneWaiting) {
    Cache cache = MakeCache(100);
    std::atomic<bool> started = false;
    std::jthread thrower([&] {
        EXPECT_THROW(static_cast<void>(cache.Get(Key(1),
                                                 [&]() -> Block {
                                                     started = true;
                                                     std::this_thread::sleep_for(50ms);
                                                     throw std::bad_alloc();
                                                 },
                                                 {})),
                     std::bad_alloc);
    });
    while (!started) std::this_thread::yield();
    EXPECT_TRUE(Builds(cache, 1, 10)) << "the waiter becomes the next builder";
}

TEST(SingleFlightCache, StaysSoundUnderManyThreads) {
    constexpr std::uint64_t kNames = 64;
    constexpr std::size_t kBound = 900;
    Cache cache = MakeCache(kBound);
    std::atomic<std::uint64_t> calls = 0, built = 0;
    std::vector<std::jthread> callers;
    for (unsigned seed = 0; seed < 8; ++seed) {
        callers.emplace_back([&, seed] {
            std::mt19937 random(seed);
            for (int i = 0; i < 3000; ++i) {
                const std::uint64_t name = random() % kNames;
                const auto found = cache.Get(Key(name),
                                             [&] {
                                                 ++built;
                                                 return Block{name, 10 + name};
                                             },
                                             {});
                ++calls;
                ASSERT_TRUE(found.ok());
                ASSERT_EQ(found->value->name, name);
                ASSERT_LE(cache.stats().bytes, kBound);
            }
        });
    }
    callers.clear();
    const CacheStats stats = cache.stats();
    EXPECT_EQ(stats.hits + stats.misses, calls);
    EXPECT_EQ(stats.misses, built);
    EXPECT_EQ(stats.misses - stats.evictions, stats.entries);
    EXPECT_GT(stats.evictions, 0U);
    EXPECT_GT(stats.hits, 0U);
}

}  // namespace
}  // namespace flare
