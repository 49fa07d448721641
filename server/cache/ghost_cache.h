// SPDX-License-Identifier: Apache-2.0
//
// The daemon's kept ghosts, in memory alone; `max_bytes` bounds them, not those that renders in
// flight still hold. Two pictures that make the same ghost at once both make it. Safe from any
// thread.
#pragma once

#include <cstddef>
#include <mutex>

#include "core/render/kept_ghost.h"
#include "server/cache/recent_values.h"

namespace flare {

class GhostCache final : public GhostKeeper {
  public:
    // A sixteenth of the bytes is for what ghosts are chosen by.
    explicit GhostCache(std::size_t max_bytes)
        : ghosts_(max_bytes - max_bytes / 16), seen_(max_bytes / 16) {}

    std::shared_ptr<const KeptGhost> Find(const Fingerprint& key) override;
    void Keep(const Fingerprint& key, std::shared_ptr<const KeptGhost> ghost) override;
    std::shared_ptr<const SeenGhosts> FindSeen(const Fingerprint& key) override;
    void KeepSeen(const Fingerprint& key, std::shared_ptr<const SeenGhosts> ghosts) override;
    // Hits and misses are those of ghosts.
    CacheStats stats() const;

  private:
    mutable std::mutex mutex_;  // guards all below
    RecentValues<KeptGhost> ghosts_;
    RecentValues<SeenGhosts> seen_;
    std::uint64_t hits_ = 0, misses_ = 0;
};

}  // namespace flare
