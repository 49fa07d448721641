// SPDX-License-Identifier: Apache-2.0
//
// The daemon's ghost meshes: in memory (see single_flight_cache.h for what is promised), and behind
// that, if it is given one, on disk. What memory does not have is read from disk or else traced, by
// one caller for all; what was traced is written to disk afterwards, in the background. `max_bytes`
// bounds the meshes that are kept in memory, not those that renders in flight still hold.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/mesh/mesh_provider.h"
#include "server/cache/disk_cache.h"
#include "server/cache/single_flight_cache.h"

namespace flare {

// What to do with a mesh that was traced.
enum class MeshKeeping { kMemoryAndDisk, kMemory };

class MeshCache final : public MeshProvider {
  public:
    // `disk` may be null; it outlives the cache.
    explicit MeshCache(std::size_t max_bytes, DiskCache* disk = nullptr);

    Result<Found> Get(const Fingerprint& key, const Build& build,
                      const CancelToken& cancel) override {
        return Get(key, build, cancel, MeshKeeping::kMemoryAndDisk);
    }
    Result<Found> Get(const Fingerprint& key, const Build& build, const CancelToken& cancel,
                      MeshKeeping keeping);
    CacheStats stats() const { return cache_.stats(); }
    // For all meshes that were ever built, also for requests that were given up later.
    std::uint64_t rays_traced() const { return rays_traced_; }

  private:
    DiskCache* const disk_;
    std::atomic<std::uint64_t> rays_traced_ = 0;
    SingleFlightCache<GhostMesh> cache_;
};

// The cache for work whose meshes may never be asked for: no file is written for them.
class MeshesInMemory final : public MeshProvider {
  public:
    explicit MeshesInMemory(MeshCache& cache) : cache_(cache) {}

    Result<Found> Get(const Fingerprint& key, const Build& build,
                      const CancelToken& cancel) override {
        return cache_.Get(key, build, cancel, MeshKeeping::kMemory);
    }

  private:
    MeshCache& cache_;
};

}  // namespace flare
