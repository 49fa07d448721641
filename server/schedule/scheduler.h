// SPDX-License-Identifier: Apache-2.0
//
// Decides which work runs, when, and which is refused. A fixed number of workers takes jobs from a
// bounded queue, first come first served. A job is admitted by the queue's length when it comes and
// by its bytes of picture when it starts; it is given up when its deadline passes, counted from
// admission, or when its token is cancelled. Every admitted job gets exactly one call, of `run` or
// of `refuse`. Safe from any thread.
//
// Background work is done in steps, one at a time and only while no job waits or runs; a job that
// comes waits for a worker for one step at the longest. It has no deadline, and the end of
// admission is its end.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "core/base/cancel.h"

namespace flare {

enum class Refusal {
    kQueueFull,  // as many jobs wait as may wait
    kDraining,   // the daemon is going down
    kMemory,     // the pictures now in work leave no room for this one
    kTooLarge,   // there is never room for a picture of this size
    kDeadline,   // it waited too long
    kCancelled,  // nobody waits for it any more
};

struct ScheduleLimits {
    int workers = 1;
    std::size_t queue = 64;
    std::uint64_t picture_bytes = std::uint64_t{1} << 30;  // of all running jobs together
    std::chrono::milliseconds deadline{300'000};
    std::size_t background = 16;  // pieces of background work at once
};

// What a running job may ask about itself.
class JobTicket {
  public:
    explicit JobTicket(CancelToken cancel) : cancel_(std::move(cancel)) {}

    // Set when the deadline passes, when the client leaves, and at the end of a drain.
    const CancelToken& cancel() const { return cancel_; }
    bool deadline_passed() const { return deadline_passed_.load(); }
    bool cut_by_drain() const { return cut_by_drain_.load(); }

  private:
    friend class Scheduler;
    CancelToken cancel_;
    std::atomic<bool> deadline_passed_ = false;
    std::atomic<bool> cut_by_drain_ = false;
};

struct Job {
    CancelToken cancel;
    std::function<std::uint64_t()> picture_bytes;  // estimate, made in the worker before `run`
    std::function<void(const JobTicket&)> run;
    std::function<void(Refusal)> refuse;
};

// Once its token is set `step` is not called again.
struct BackgroundWork {
    CancelToken cancel;
    std::function<bool()> step;  // some milliseconds of work; true: there is more
};

class Scheduler {
  public:
    explicit Scheduler(const ScheduleLimits& limits);
    ~Scheduler();  // cancels what is left
    Scheduler(const Scheduler&) = delete;
    Scheduler& operator=(const Scheduler&) = delete;

    // A refusal (kQueueFull or kDraining) means that the job was not taken: none of its functions
    // is called. Otherwise they are called from another thread, perhaps before this returns.
    std::optional<Refusal> Submit(Job job);

    // Takes turns with other background work. A refusal (kQueueFull or kDraining) as above. When
    // the scheduler stops admitting, the tokens of what is left are set.
    std::optional<Refusal> SubmitBackground(BackgroundWork work);

    std::size_t queued() const;
    // A guess, from how long jobs take of late, at when a refused caller may find room: 1 to 60.
    int RetryAfterSeconds() const;

    void StopAdmitting();
    // Waits until no job waits or runs; false if `bound` passed before.
    bool WaitUntilIdle(std::chrono::milliseconds bound);
    // Refuses the jobs that wait, cancels those that run, and waits for them to end.
    void CutOff();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace flare
