// SPDX-License-Identifier: Apache-2.0
//
// Meshes remembered, and of all ghosts only one handed out: the renderer then draws that ghost
// alone. For what holds ghost by ghost.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "core/mesh/mesh_provider.h"

namespace flare::testing {

class OneGhostMeshes final : public MeshProvider {
  public:
    // From now on only this ghost has a mesh; nullopt: every ghost. Not while something is
    // rendered.
    void Show(std::optional<BounceSequence> sequence) { shown_ = std::move(sequence); }

    Result<Found> Get(const Fingerprint& key, const Build& build, const CancelToken&) override {
        std::shared_ptr<const GhostMesh> mesh;
        {
            const std::lock_guard lock(mutex_);
            const auto known = meshes_.find(key);
            if (known != meshes_.end()) mesh = known->second;
        }
        const bool hit = mesh != nullptr;
        if (!hit) {
            mesh = std::make_shared<const GhostMesh>(build());
            const std::lock_guard lock(mutex_);
            meshes_[key] = mesh;
        }
        if (shown_ && mesh->sequence != *shown_) {
            auto nothing = std::make_shared<GhostMesh>();
            nothing->sequence = mesh->sequence;
            nothing->stop_crossings = mesh->stop_crossings;
            nothing->interactions = mesh->interactions;
            return Found{nothing, hit};
        }
        return Found{mesh, hit};
    }

    void Forget() { meshes_.clear(); }

  private:
    std::optional<BounceSequence> shown_;
    std::mutex mutex_;
    std::map<Fingerprint, std::shared_ptr<const GhostMesh>> meshes_;
};

}  // namespace flare::testing
