// SPDX-License-Identifier: Apache-2.0
//
// Where the renderer gets ghost meshes from. The core traces them afresh (TracingMeshProvider); the
// daemon puts a cache in between. A mesh depends on its key alone: whoever builds it, the values
// are the same to the last bit.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "core/base/cancel.h"
#include "core/base/fingerprint.h"
#include "core/base/result.h"
#include "core/mesh/ghost_mesh.h"

namespace flare {

class MeshProvider {
  public:
    using Build = std::function<GhostMesh()>;

    virtual ~MeshProvider() = default;

    // The mesh named `key`. Calls `build` in this thread if nobody has it; may wait for another
    // thread that is building the same key. Called from several threads at once. Fails only with
    // code "cancelled". `hit` tells whether no ray had to be traced for this call, `from_disk`
    // whether the mesh was read from a file for it instead.
    struct Found {
        std::shared_ptr<const GhostMesh> mesh;
        bool hit = false;
        bool from_disk = false;
    };
    virtual Result<Found> Get(const Fingerprint& key, const Build& build,
                              const CancelToken& cancel) = 0;
};

// No cache: every call traces.
class TracingMeshProvider final : public MeshProvider {
  public:
    Result<Found> Get(const Fingerprint& key, const Build& build,
                      const CancelToken& cancel) override;
};

}  // namespace flare
