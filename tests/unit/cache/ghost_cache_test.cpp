// SPDX-License-Identifier: Apache-2.0
#include "server/cache/ghost_cache.h"

#include <gtest/gtest.h>

#include "core/render/kept_ghost.h"

namespace flare {
namespace {

std::shared_ptr<const KeptGhost> GhostOf(std::size_t tiles) {
    auto kept = std::make_shared<KeptGhost>();
    auto made = std::make_shared<GhostTiles>();
    made->smooth.resize(tiles);
    kept->tiles = std::move(made);
    return kept;
}

TEST(GhostCache, GivesBackWhatItKeeps) {
    GhostCache cache(1 << 20);
    const Fingerprint key{1, 2};
    EXPECT_EQ(cache.Find<KeptGhost>(key), nullptr);
    const auto ghost = GhostOf(10);
    cache.Keep(key, ghost);
    EXPECT_EQ(cache.Find<KeptGhost>(key), ghost);
    const CacheStats stats = cache.stats();
    EXPECT_EQ(stats.hits, 1U);
    EXPECT_EQ(stats.misses, 1U);
    EXPECT_EQ(stats.entries, 1U);
    EXPECT_GT(stats.bytes, 10 * sizeof(SmoothTile));
}

TEST(GhostCache, ForgetsTheLeastRecentlyUsedBeyondItsBound) {
    GhostCache cache(200'000);
    const std::size_t tiles = 60'000 / sizeof(SmoothTile);
    for (std::uint64_t n = 0; n < 3; ++n) cache.Keep({n, n}, GhostOf(tiles));
    EXPECT_NE(cache.Find<KeptGhost>({0, 0}), nullptr);
    cache.Keep({3, 3}, GhostOf(tiles));
    EXPECT_NE(cache.Find<KeptGhost>({0, 0}), nullptr);
    EXPECT_EQ(cache.Find<KeptGhost>({1, 1}), nullptr);
    EXPECT_LE(cache.stats().bytes, 200'000U);
    EXPECT_EQ(cache.stats().evictions, 1U);
    cache.Keep({4, 4}, GhostOf(10 * tiles));  // larger than all of it
    EXPECT_EQ(cache.Find<KeptGhost>({4, 4}), nullptr);
    EXPECT_NE(cache.Find<KeptGhost>({0, 0}), nullptr);
}

TEST(GhostCache, KeepsNothingInNoRoom) {
    GhostCache cache(0);
    cache.Keep({1, 1}, GhostOf(1));
    cache.Keep<SeenGhosts>({2, 2}, std::make_shared<const SeenGhosts>());
    EXPECT_EQ(cache.Find<KeptGhost>({1, 1}), nullptr);
    EXPECT_EQ(cache.Find<SeenGhosts>({2, 2}), nullptr);
}

}  // namespace
}  // namespace flare
