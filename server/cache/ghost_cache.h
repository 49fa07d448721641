// SPDX-License-Identifier: Apache-2.0
//
// What the daemon keeps of pictures for the next ones, in memory alone: ghosts as they were drawn,
// what they were chosen by, tables of lenses. `max_bytes` bounds all of it, not what renders in
// flight still hold. Two pictures that make the same value at once both make it. Safe from any
// thread.
#pragma once

#include <cstddef>
#include <mutex>

#include "core/render/render_keeper.h"
#include "server/cache/recent_values.h"

namespace flare {

class GhostCache final : public RenderKeeper {
  public:
    explicit GhostCache(std::size_t max_bytes) : values_(max_bytes) {}

    // Hits and misses are those of ghosts.
    CacheStats stats() const;

  private:
    std::shared_ptr<const void> FindValue(KeptKind kind, const Fingerprint& key) override;
    void KeepValue(const Fingerprint& key, std::shared_ptr<const void> value,
                   std::size_t bytes) override;

    mutable std::mutex mutex_;  // guards all below
    RecentValues<void> values_;
    std::uint64_t hits_ = 0, misses_ = 0;
};

}  // namespace flare
