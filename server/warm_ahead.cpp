// SPDX-License-Identifier: Apache-2.0
#include "server/warm_ahead.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "protocol/limits.h"
#include "server/translate/request_from_wire.h"

namespace flare {
namespace {

constexpr std::size_t kMostAhead = 4;

bool Contains(const std::vector<RingCell>& cells, RingCell cell) {
    return std::find(cells.begin(), cells.end(), cell) != cells.end();
}

// Where the ring stands, and the next cells on the straight line along `turn`.
std::vector<RingCell> PathFrom(RingCell cell, RingCell turn, std::size_t ahead) {
    std::vector<RingCell> path{cell};
    const double longest = static_cast<double>(std::max(std::abs(turn.focus), std::abs(turn.zoom)));
    for (std::size_t i = 1; i <= ahead && longest > 0.0; ++i) {
        const double share = static_cast<double>(i) / longest;
        const auto along = [&](std::int64_t from, std::int64_t by) {
            return from + std::llround(share * static_cast<double>(by));
        };
        // No ring goes past infinity.
        const RingCell next{std::max<std::int64_t>(0, along(cell.focus, turn.focus)),
                            along(cell.zoom, turn.zoom)};
        if (!Contains(path, next)) path.push_back(next);
    }
    return path;
}

// The request in another state. Fails only where the lens cannot be built in it.
Result<std::shared_ptr<WarmWork>> Plan(wire::FlareRequest request, const LensReading& reading,
                                       const LensLibrary& lenses) {
    if (const auto& focus = reading[LensAxis::kFocus]) {
        request.lens.focus_m =
            *focus <= limits::kMaxDistance_m ? std::optional(*focus) : std::nullopt;
    }
    if (const auto& zoom = reading[LensAxis::kZoom]) request.lens.zoom_mm = *zoom;
    Result<FlareRequest> translated = RequestFromWire(request, lenses);
    if (!translated) return translated.error();
    return WarmWork::PlanFor(std::move(*translated));
}

}  // namespace

std::optional<RingCell> WarmAhead::Ring::Next() const {
    for (const RingCell candidate : path) {
        if (!Contains(done, candidate)) return candidate;
    }
    return std::nullopt;
}

void WarmAhead::Note(const std::string& encoder, const wire::FlareRequest& request,
                     const LensReading& reading, double now_s) {
    if (!request.lens.name || request.lights.size() > kMostLights) return;
    if (!request.layers.ghosts || request.quality.photon) return;
    const auto lens = lenses_.Find(*request.lens.name);
    if (!lens) return;
    const RingSteps steps = RingSteps::For(**lens, request);
    const std::lock_guard lock(mutex_);
    if (!steps.any() && !rings_.contains(encoder)) return;
    Ring& ring = rings_[encoder];
    ring.request = request;
    ring.request.iris = {};  // of which no mesh depends, and a mask may be large
    ring.steps = steps;
    ring.asked_s = now_s;
    ++ring.asked;
    ring.done = {steps.CellOf(reading)};
    ring.work.reset();
}

bool WarmAhead::Look(double now_s) {
    const std::lock_guard lock(mutex_);
    bool any = false;
    for (auto& entry : rings_) {
        Ring& ring = entry.second;
        const EncoderTrack* const track = find_(entry.first);
        if (!track) continue;
        Follow(ring, *track, now_s);
        any = any || ring.Next();
    }
    return any;
}

void WarmAhead::Follow(Ring& ring, const EncoderTrack& track, double now_s) const {
    ring.path.clear();
    const std::optional<TimedReading> newest = track.Newest();
    if (!newest || !ring.steps.any() || now_s - ring.asked_s > kInterest_s) return;
    ring.reading = newest->reading;
    const RingCell cell = ring.steps.CellOf(ring.reading);
    if (ring.cell && *ring.cell != cell) {
        ring.turn = {cell.focus - ring.cell->focus, cell.zoom - ring.cell->zoom};
        ring.turned_s = now_s;
    }
    if (!ring.cell || now_s - ring.turned_s > kTurning_s) ring.turn = {};
    ring.cell = cell;
    std::size_t ahead = 0;
    if (ring.state_bytes > 0) {
        const std::size_t fit = budget_bytes_ / ring.state_bytes;
        ahead = std::min(kMostAhead, fit);
    }
    ring.path = PathFrom(cell, ring.turn, ahead);
    std::erase_if(ring.done, [&](RingCell other) { return !Contains(ring.path, other); });
    if (ring.work && !Contains(ring.path, ring.work_cell)) ring.work.reset();
}

// Rings take turns.
std::optional<WarmAhead::Task> WarmAhead::NextTask() {
    const std::lock_guard lock(mutex_);
    auto at = rings_.upper_bound(last_);
    for (std::size_t i = 0; i < rings_.size(); ++i, ++at) {
        if (at == rings_.end()) at = rings_.begin();
        const std::string& name = at->first;
        Ring& ring = at->second;
        const std::optional<RingCell> next = ring.Next();
        if (!next) continue;
        last_ = name;
        if (ring.work && ring.work_cell == *next)
            return Task{name, ring.asked, *next, ring.work, {}, {}};
        return Task{name,    ring.asked,   *next,
                    nullptr, ring.request, ring.steps.Put(*next, ring.reading)};
    }
    return std::nullopt;
}

bool WarmAhead::Step(ThreadPool& threads, MeshProvider& meshes) {
    std::optional<Task> task = NextTask();
    if (!task) return false;
    bool more = true;
    if (!task->work) {
        const auto planned = Plan(std::move(task->request), task->reading, lenses_);
        more = static_cast<bool>(planned);
        if (planned) task->work = *planned;
    } else {
        more = task->work->Step(threads, meshes, CancelToken()) &&
               task->work->progress().mesh_bytes < budget_bytes_;
    }
    return Finish(*task, more);
}

// True: there is more to do for some ring.
bool WarmAhead::Finish(const Task& task, bool more) {
    const std::lock_guard lock(mutex_);
    const auto found = rings_.find(task.encoder);
    if (found != rings_.end() && found->second.asked == task.asked) {
        Ring& ring = found->second;
        ring.work = more ? task.work : nullptr;
        ring.work_cell = task.cell;
        if (!more) ring.done.push_back(task.cell);
        if (!more && task.work) {
            const WarmProgress progress = task.work->progress();
            ring.state_bytes = std::max<std::size_t>(1, progress.mesh_bytes);
            if (progress.mesh_misses > 0) ++ring.states;
        }
    }
    return std::any_of(rings_.begin(), rings_.end(),
                       [](const auto& entry) { return entry.second.Next().has_value(); });
}

std::uint64_t WarmAhead::states(std::string_view encoder) const {
    const std::lock_guard lock(mutex_);
    const auto found = rings_.find(encoder);
    return found == rings_.end() ? 0 : found->second.states;
}

}  // namespace flare
