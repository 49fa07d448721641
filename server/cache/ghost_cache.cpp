// SPDX-License-Identifier: Apache-2.0
#include "server/cache/ghost_cache.h"

#include <utility>

namespace flare {

std::shared_ptr<const void> GhostCache::FindValue(KeptKind kind, const Fingerprint& key) {
    const std::lock_guard lock(mutex_);
    std::shared_ptr<const void> found = values_.Find(key);
    if (kind == KeptKind::kGhost) ++(found ? hits_ : misses_);
    return found;
}

void GhostCache::KeepValue(const Fingerprint& key, std::shared_ptr<const void> value,
                           std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    values_.Keep(key, std::move(value), bytes);
}

CacheStats GhostCache::stats() const {
    const std::lock_guard lock(mutex_);
    return {hits_, misses_, values_.evictions(), values_.bytes(), values_.entries()};
}

}  // namespace flare
