// SPDX-License-Identifier: Apache-2.0
#include "server/warm_work.h"

#include <algorithm>
#include <new>
#include <utility>

#include "server/translate/warm_from_wire.h"

namespace flare {

Result<std::shared_ptr<WarmWork>> WarmWork::Plan(std::string_view body, const LensLibrary& lenses) {
    Result<FlareRequest> request = WarmFromWire(body, lenses);
    if (!request) return request.error();
    return PlanFor(std::move(*request));
}

Result<std::shared_ptr<WarmWork>> WarmWork::PlanFor(FlareRequest request) {
    std::vector<PlacedLight> lights;
    for (std::size_t i = 0; i < request.lights.size(); ++i) {
        const Result<PlacedLight> light = PlaceLight(request, i);
        if (!light) return light.error();
        lights.push_back(*light);
    }
    return std::shared_ptr<WarmWork>(new WarmWork(std::move(request), std::move(lights)));
}

WarmWork::WarmWork(FlareRequest request, std::vector<PlacedLight> lights)
    : request_(std::move(request)), lights_(std::move(lights)) {}

bool WarmWork::Step(ThreadPool& threads, MeshProvider& meshes, const CancelToken& cancel) {
    if (lights_done_ == lights_.size()) return false;
    if (next_spec_ == specs_.size()) {
        specs_ = MeshSpecsFor(request_, lights_[lights_done_]);
        next_spec_ = 0;
    }
    const Lens& lens = *request_.lens;
    const auto batch = static_cast<int>(
        std::min(static_cast<std::size_t>(threads.threads()), specs_.size() - next_spec_));
    std::atomic<bool> out_of_memory = false;
    threads.For(batch, [&](int i) {
        const MeshSpec& spec = specs_[next_spec_ + static_cast<std::size_t>(i)];
        try {
            const auto found = meshes.Get(
                MeshKey(lens, spec), [&] { return BuildMesh(lens, spec); }, cancel);
            if (!found) return;  // cancelled
            ++(found->hit ? hits_ : misses_);
            if (found->from_disk) ++disk_hits_;
            if (!found->hit) rays_ += found->mesh->rays_traced;
            bytes_ += found->mesh->bytes();
        } catch (const std::bad_alloc&) {
            out_of_memory = true;
        }
    });
    if (out_of_memory) throw std::bad_alloc();
    if (cancel.cancelled()) return false;
    next_spec_ += static_cast<std::size_t>(batch);
    if (next_spec_ == specs_.size()) ++lights_done_;
    return lights_done_ < lights_.size();
}

WarmProgress WarmWork::progress() const {
    WarmProgress progress;
    progress.lights = lights_.size();
    progress.lights_done = lights_done_;
    progress.mesh_hits = hits_;
    progress.mesh_disk_hits = disk_hits_;
    progress.mesh_misses = misses_;
    progress.rays_traced = rays_;
    progress.mesh_bytes = bytes_;
    return progress;
}

}  // namespace flare
