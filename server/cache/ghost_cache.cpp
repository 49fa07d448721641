// SPDX-License-Identifier: Apache-2.0
#include "server/cache/ghost_cache.h"

#include <utility>

namespace flare {

std::shared_ptr<const KeptGhost> GhostCache::Find(const Fingerprint& key) {
    const std::lock_guard lock(mutex_);
    std::shared_ptr<const KeptGhost> found = values_.Find(key);
    ++(found ? hits_ : misses_);
    return found;
}

void GhostCache::Keep(const Fingerprint& key, std::shared_ptr<const KeptGhost> ghost) {
    const std::size_t bytes = ghost->bytes();
    const std::lock_guard lock(mutex_);
    values_.Keep(key, std::move(ghost), bytes);
}

CacheStats GhostCache::stats() const {
    const std::lock_guard lock(mutex_);
    return {hits_, misses_, values_.evictions(), values_.bytes(), values_.entries()};
}

}  // namespace flare
