// SPDX-License-Identifier: Apache-2.0
//
// Has the ghost meshes of the states traced that a turning lens ring is about to pass through, for
// the request that last named its encoder: the step where the ring stands (RingSteps), and a few
// more in the direction in which it last went from one step to the next. What is no longer on the
// way is given up between two meshes: the ring turned round, stands still, or another request
// came. A ring of which meshes do not depend (the iris; focus of a lens that focuses as a whole,
// with lights given by direction) is not followed, nor is a request with a prescription of its own
// or with more than kMostLights lights.
//
// The states ahead hold no more than `budget_bytes` of meshes for each encoder; one that alone is
// larger is left when it has come to that, lest it drive out what pictures use. Nothing is done by
// itself: somebody calls Look a few times in a while, and Step, in the background, while there is
// work. One thread at a time calls Step; all else is safe from any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/wire/flare_request.h"
#include "server/encoder/encoder_track.h"
#include "server/translate/ring_steps.h"
#include "server/warm_work.h"

namespace flare {

class WarmAhead {
  public:
    using FindTrack = std::function<const EncoderTrack*(std::string_view)>;

    // How long after its last request an encoder is followed, and how long a ring that has gone a
    // step counts as turning.
    static constexpr double kInterest_s = 10.0;
    static constexpr double kTurning_s = 2.0;
    static constexpr std::size_t kMostLights = 64;

    WarmAhead(const LensLibrary& lenses, FindTrack find, std::size_t budget_bytes)
        : lenses_(lenses), find_(std::move(find)), budget_bytes_(budget_bytes) {}

    // What was just rendered with the newest state of an encoder, its numbers put in, and that
    // state, which needs no more.
    void Note(const std::string& encoder, const wire::FlareRequest& request,
              const LensReading& reading, double now_s);
    // Looks at the rings. True: there is something to trace.
    bool Look(double now_s);
    // Some milliseconds of work; true: there is more. Throws std::bad_alloc.
    bool Step(ThreadPool& threads, MeshProvider& meshes);

    // States of which a mesh was traced by Step.
    std::uint64_t states(std::string_view encoder) const;

  private:
    // One encoder that requests name.
    struct Ring {
        wire::FlareRequest request;
        RingSteps steps;
        double asked_s = 0.0;
        std::uint64_t asked = 0;  // counts requests

        LensReading reading;  // the newest
        std::optional<RingCell> cell;
        RingCell turn;  // from the cell before to this one
        double turned_s = 0.0;

        std::vector<RingCell> path, done;
        std::shared_ptr<WarmWork> work;
        RingCell work_cell;
        std::size_t state_bytes = 0;  // of the meshes of one state; 0: not known yet
        std::uint64_t states = 0;

        std::optional<RingCell> Next() const;  // of the path, the first that is not done
    };
    // What a step is about, so that it can be done without the lock.
    struct Task {
        std::string encoder;
        std::uint64_t asked = 0;
        RingCell cell;
        std::shared_ptr<WarmWork> work;  // null: to be planned
        wire::FlareRequest request;
        LensReading reading;
    };

    void Follow(Ring& ring, const EncoderTrack& track, double now_s) const;
    std::optional<Task> NextTask();
    bool Finish(const Task& task, bool more);

    const LensLibrary& lenses_;
    const FindTrack find_;
    const std::size_t budget_bytes_;
    mutable std::mutex mutex_;  // guards what follows
    std::map<std::string, Ring, std::less<>> rings_;
    std::string last_;  // whose turn it was
};

}  // namespace flare
