// SPDX-License-Identifier: Apache-2.0
#include "server/warm_jobs.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>

#include "protocol/codec/json_writer.h"
#include "protocol/limits.h"

namespace flare {

bool WarmJobs::Job::Step() {
    bool more = false;
    try {
        more = task_.step(cancel_);
    } catch (const std::exception& problem) {
        spdlog::error("warming {} failed: {}", id_, problem.what());
        failed_ = true;
    }
    if (!more) over_ = true;
    return more;
}

std::string WarmJobs::Job::Json() const {
    const bool over = over_;  // before the progress, which then is the last
    const WarmProgress progress = task_.progress();
    const char* state = "running";
    if (over || cancel_.cancelled()) state = "cancelled";
    if (over && progress.lights_done == progress.lights) state = "done";
    if (failed_) state = "failed";
    wire::JsonWriter json(wire::JsonWriter::Style::kPretty);
    json.BeginObject().Member("id", id_).Member("state", state);
    json.Member("lights", progress.lights).Member("lights_done", progress.lights_done);
    json.Member("mesh_cache_hits", progress.mesh_hits);
    json.Member("mesh_disk_hits", progress.mesh_disk_hits);
    json.Member("mesh_cache_misses", progress.mesh_misses);
    json.Member("rays_traced", progress.rays_traced).End();
    return json.Take();
}

WarmJobs::JobPtr WarmJobs::Add(const std::string& id, WarmTask task) {
    auto job = std::make_shared<Job>(id, std::move(task));
    const std::lock_guard lock(mutex_);
    if (jobs_.size() >= limits::kWarmJobsKept) {
        const auto over = std::find_if(jobs_.begin(), jobs_.end(),
                                       [](const auto& entry) { return entry.second->over(); });
        if (over != jobs_.end()) jobs_.erase(over);
    }
    jobs_.emplace_back(id, job);
    return job;
}

void WarmJobs::Remove(const std::string& id) {
    const std::lock_guard lock(mutex_);
    std::erase_if(jobs_, [&](const auto& entry) { return entry.first == id; });
}

WarmJobs::JobPtr WarmJobs::Find(const std::string& id) const {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(jobs_.begin(), jobs_.end(),
                                    [&](const auto& entry) { return entry.first == id; });
    return found == jobs_.end() ? nullptr : found->second;
}

std::size_t WarmJobs::under_way() const {
    const std::lock_guard lock(mutex_);
    return static_cast<std::size_t>(std::count_if(
        jobs_.begin(), jobs_.end(), [](const auto& entry) { return !entry.second->over(); }));
}

}  // namespace flare
