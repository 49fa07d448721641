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
    explicit GhostCache(std::size_t max_bytes) : values_(max_bytes) {}

    std::shared_ptr<const KeptGhost> Find(const Fingerprint& key) override;
    void Keep(const Fingerprint& key, std::shared_ptr<const KeptGhost> ghost) override;
    CacheStats stats() const;

  private:
    mutable std::mutex mutex_;  // guards all below
    RecentValues<KeptGhost> values_;
    std::uint64_t hits_ = 0, misses_ = 0;
};

}  // namespace flare
