// SPDX-License-Identifier: Apache-2.0
//
// POST /v1/warm: has the ghost meshes of some lights built before a picture asks for them, in small
// steps between which others may work. A step is as many meshes as there are threads. Steps come
// one at a time, from any thread; the progress can be asked for meanwhile.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/parallel.h"
#include "core/base/result.h"
#include "core/mesh/mesh_provider.h"
#include "core/render/light_meshes.h"
#include "server/lens_library.h"

namespace flare {

struct WarmProgress {
    std::uint64_t lights = 0, lights_done = 0;
    std::uint64_t mesh_hits = 0, mesh_disk_hits = 0, mesh_misses = 0;  // as in a picture's report
    std::uint64_t rays_traced = 0;
    std::uint64_t mesh_bytes = 0;
};

// What the daemon needs to know of it.
struct WarmTask {
    std::function<bool(const CancelToken&)> step;  // true: there is more to do
    std::function<WarmProgress()> progress;
};

class WarmWork {
  public:
    // Decodes and checks everything, so that no step fails for its input. Errors carry code,
    // message and `where`.
    static Result<std::shared_ptr<WarmWork>> Plan(std::string_view body, const LensLibrary& lenses);
    static Result<std::shared_ptr<WarmWork>> PlanFor(FlareRequest request);

    // True: there is more to do. Throws std::bad_alloc if a mesh does not fit into memory.
    bool Step(ThreadPool& threads, MeshProvider& meshes, const CancelToken& cancel);
    WarmProgress progress() const;

  private:
    WarmWork(FlareRequest request, std::vector<PlacedLight> lights);

    const FlareRequest request_;
    const std::vector<PlacedLight> lights_;
    std::vector<MeshSpec> specs_;  // of the light at hand
    std::size_t next_spec_ = 0;
    std::atomic<std::uint64_t> lights_done_ = 0;
    std::atomic<std::uint64_t> hits_ = 0, disk_hits_ = 0, misses_ = 0, rays_ = 0, bytes_ = 0;
};

}  // namespace flare
