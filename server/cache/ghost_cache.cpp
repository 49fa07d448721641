// SPDX-License-Identifier: Apache-2.0
#include "server/cache/ghost_cache.h"

#include <utility>

namespace flare {

std::shared_ptr<const KeptGhost> GhostCache::Find(const Fingerprint& key) {
    const std::lock_guard lock(mutex_);
    std::shared_ptr<const KeptGhost> found = ghosts_.Find(key);
    ++(found ? hits_ : misses_);
    return found;
}

void GhostCache::Keep(const Fingerprint& key, std::shared_ptr<const KeptGhost> ghost) {
    const std::size_t bytes = ghost->bytes();
    const std::lock_guard lock(mutex_);
    ghosts_.Keep(key, std::move(ghost), bytes);
}

std::shared_ptr<const SeenGhosts> GhostCache::FindSeen(const Fingerprint& key) {
    const std::lock_guard lock(mutex_);
    return seen_.Find(key);
}

void GhostCache::KeepSeen(const Fingerprint& key, std::shared_ptr<const SeenGhosts> ghosts) {
    const std::size_t bytes = ghosts->bytes();
    const std::lock_guard lock(mutex_);
    seen_.Keep(key, std::move(ghosts), bytes);
}

CacheStats GhostCache::stats() const {
    const std::lock_guard lock(mutex_);
    return {hits_, misses_, ghosts_.evictions(), ghosts_.bytes() + seen_.bytes(),
            ghosts_.entries()};
}

}  // namespace flare
