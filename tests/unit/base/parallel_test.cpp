// SPDX-License-Identifier: Apache-2.0
#include "core/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <thread>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/result.h"

namespace flare {
namespace {

TEST(ThreadPool, RunsEveryItemOnce) {
    for (const int threads : {1, 2, 4}) {
        ThreadPool pool(threads);
        EXPECT_EQ(pool.threads(), threads);
        for (const int count : {0, 1, 2, 3, 1000}) {
            std::vector<std::atomic<int>> runs(static_cast<std::size_t>(count));
            pool.For(count, [&](int i) { ++runs[static_cast<std::size_t>(i)]; });
            for (const std::atomic<int>& n : runs) EXPECT_EQ(n.load(), 1);
        }
        pool.For(-3, [](int) { FAIL(); });
    }
}

TEST(ThreadPool, IsDoneWhenForReturns) {
    ThreadPool pool(4);
    for (int round = 0; round < 200; ++round) {
        std::vector<int> values(64, 0);
        pool.For(64, [&](int i) { values[static_cast<std::size_t>(i)] = i; });
        int sum = 0;
        for (const int v : values) sum += v;
        ASSERT_EQ(sum, 63 * 64 / 2);
    }
}

TEST(ThreadPool, LoopsMayNest) {
    for (const int threads : {1, 2, 3}) {
        ThreadPool pool(threads);
        std::atomic<int> leaves{0};
        pool.For(8, [&](int) { pool.For(8, [&](int) { pool.For(8, [&](int) { ++leaves; }); }); });
        EXPECT_EQ(leaves.load(), 512);
    }
}

TEST(ThreadPool, ServesManyCallersAtOnce) {
    ThreadPool pool(2);
    constexpr int kCallers = 8;
    std::vector<long> sums(kCallers, 0);
    std::vector<std::thread> callers;
    for (int c = 0; c < kCallers; ++c) {
        callers.emplace_back([&, c] {
            for (int round = 0; round < 50; ++round) {
                std::vector<long> part(40, 0);
                pool.For(40, [&](int i) { part[static_cast<std::size_t>(i)] = c * 1000 + i; });
                for (const long p : part) sums[static_cast<std::size_t>(c)] += p;
            }
        });
    }
    for (std::thread& caller : callers) caller.join();
    for (int c = 0; c < kCallers; ++c) {
        EXPECT_EQ(sums[static_cast<std::size_t>(c)], 50L * (40L * c * 1000 + 780));
    }
}

TEST(ThreadPool, OfOneWorksInTheCaller) {
    ThreadPool pool(1);
    std::set<std::thread::id> ids;
    pool.For(10, [&](int) { ids.insert(std::this_thread::get_id()); });
    EXPECT_EQ(ids, std::set<std::thread::id>{std::this_thread::get_id()});
}

TEST(ThreadPool, ThreadsWorkTogether) {
    ThreadPool pool(2);
    // Each item waits for the other: one thread alone would never end.
    std::atomic<int> arrived{0};
    pool.For(2, [&](int) {
        ++arrived;
        while (arrived.load() < 2) std::this_thread::yield();
    });
    EXPECT_EQ(arrived.load(), 2);
}

TEST(CancelToken, CopiesShareOneFlag) {
    const CancelToken token;
    const CancelToken copy = token;
    const CancelToken other;
    EXPECT_FALSE(token.cancelled());
    copy.Cancel();
    EXPECT_TRUE(token.cancelled());
    EXPECT_FALSE(other.cancelled());
}

TEST(Result, HoldsAValueOrAnError) {
    const Result<int> good = 7;
    EXPECT_TRUE(good.ok());
    EXPECT_EQ(*good, 7);
    const Result<int> bad = Error{"bad_value", "too large", "/width"};
    EXPECT_FALSE(bad);
    EXPECT_EQ(bad.error().where, "/width");
    EXPECT_DEATH(static_cast<void>(bad.value()), "check failed");
    EXPECT_DEATH(static_cast<void>(good.error()), "check failed");
}

}  // namespace
}  // namespace flare
