// SPDX-License-Identifier: Apache-2.0
#include "server/cache/mesh_cache.h"

#include <utility>

namespace flare {

MeshCache::MeshCache(std::size_t max_bytes)
    : cache_(max_bytes, [](const GhostMesh& mesh) { return mesh.bytes(); }) {}

Result<MeshProvider::Found> MeshCache::Get(const Fingerprint& key, const Build& build,
                                           const CancelToken& cancel) {
    const auto counted = [&] {
        GhostMesh mesh = build();
        rays_traced_ += mesh.rays_traced;
        return mesh;
    };
    auto found = cache_.Get(key, counted, cancel);
    if (!found) return found.error();
    return Found{std::move(found->value), found->hit};
}

}  // namespace flare
