// SPDX-License-Identifier: Apache-2.0
#include "server/cache/mesh_cache.h"

#include <optional>
#include <utility>

namespace flare {

MeshCache::MeshCache(std::size_t max_bytes, DiskCache* disk)
    : disk_(disk), cache_(max_bytes, [](const GhostMesh& mesh) { return mesh.bytes(); }) {}

Result<MeshProvider::Found> MeshCache::Get(const Fingerprint& key, const Build& build,
                                           const CancelToken& cancel, MeshKeeping keeping) {
    bool traced = false, from_disk = false;
    const auto make = [&] {
        if (disk_) {
            if (std::optional<GhostMesh> kept = disk_->Read(key)) {
                from_disk = true;
                return std::move(*kept);
            }
        }
        GhostMesh mesh = build();
        rays_traced_ += mesh.rays_traced;
        traced = true;
        return mesh;
    };
    auto found = cache_.Get(key, make, cancel);
    if (!found) return found.error();
    if (disk_ && traced && keeping == MeshKeeping::kMemoryAndDisk) disk_->Write(key, found->value);
    return Found{std::move(found->value), found->hit || from_disk, from_disk};
}

}  // namespace flare
