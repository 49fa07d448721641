// SPDX-License-Identifier: Apache-2.0
//
// Workers take jobs from one queue under one lock. A watch thread looks at all admitted jobs every
// few milliseconds, but only while there are any: it takes out those whose client left or whose
// deadline passed, so that a dead job neither holds a place in the queue nor waits for a free
// worker to be told so. Functions of a job are always called without the lock.
#include "server/schedule/scheduler.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/check.h"

namespace flare {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kWatchPeriod{20};

struct Admitted {
    Job job;
    std::shared_ptr<JobTicket> ticket;
    Clock::time_point deadline;
};

struct Running {
    std::shared_ptr<JobTicket> ticket;
    Clock::time_point deadline;
};

Refusal ReasonOfCancel(const JobTicket& ticket) {
    if (ticket.cut_by_drain()) return Refusal::kDraining;
    return ticket.deadline_passed() ? Refusal::kDeadline : Refusal::kCancelled;
}

}  // namespace

struct Scheduler::State {
    explicit State(const ScheduleLimits& given) : limits(given) {}

    const ScheduleLimits limits;
    mutable std::mutex mutex;  // guards all below
    std::condition_variable work_came, watch_needed, became_idle;
    std::deque<Admitted> queue;
    std::vector<Running> running;
    std::uint64_t reserved_bytes = 0;
    double mean_run_seconds = 0.1;
    bool draining = false;
    bool stop = false;
    std::vector<std::thread> threads;

    std::deque<BackgroundWork> background;  // takes turns
    std::optional<CancelToken> in_step;     // of the background work that is being done

    bool idle() const { return queue.empty() && running.empty(); }
    bool may_step() const { return idle() && !background.empty() && !in_step; }
    void NoteIdle();
    void StepBackground(std::unique_lock<std::mutex>& lock);
    void DropBackground();

    void Work();
    void RunOne(Admitted& admitted, std::unique_lock<std::mutex>& lock);
    std::optional<Refusal> Reserve(std::uint64_t bytes);
    void Watch();
    void RefuseDeadJobs(std::unique_lock<std::mutex>& lock);
    void CutAll();
};

Scheduler::Scheduler(const ScheduleLimits& limits) : state_(std::make_unique<State>(limits)) {
    FLARE_CHECK(limits.workers >= 1);
    for (int i = 0; i < limits.workers; ++i) {
        state_->threads.emplace_back([state = state_.get()] { state->Work(); });
    }
    state_->threads.emplace_back([state = state_.get()] { state->Watch(); });
}

Scheduler::~Scheduler() {
    CutOff();
    {
        const std::lock_guard lock(state_->mutex);
        state_->stop = true;
    }
    state_->work_came.notify_all();
    state_->watch_needed.notify_all();
    for (std::thread& thread : state_->threads) thread.join();
}

std::optional<Refusal> Scheduler::Submit(Job job) {
    const std::lock_guard lock(state_->mutex);
    if (state_->draining) return Refusal::kDraining;
    if (state_->queue.size() >= state_->limits.queue) return Refusal::kQueueFull;
    auto ticket = std::make_shared<JobTicket>(job.cancel);
    state_->queue.push_back(
        {std::move(job), std::move(ticket), Clock::now() + state_->limits.deadline});
    state_->work_came.notify_one();
    state_->watch_needed.notify_one();
    return std::nullopt;
}

std::optional<Refusal> Scheduler::SubmitBackground(BackgroundWork work) {
    const std::lock_guard lock(state_->mutex);
    if (state_->draining) return Refusal::kDraining;
    std::erase_if(state_->background,
                  [](const BackgroundWork& other) { return other.cancel.cancelled(); });
    const std::size_t steps = state_->in_step ? 1 : 0;
    if (state_->background.size() + steps >= state_->limits.background) return Refusal::kQueueFull;
    state_->background.push_back(std::move(work));
    state_->work_came.notify_one();
    return std::nullopt;
}

std::size_t Scheduler::queued() const {
    const std::lock_guard lock(state_->mutex);
    return state_->queue.size();
}

int Scheduler::RetryAfterSeconds() const {
    const std::lock_guard lock(state_->mutex);
    const double jobs_ahead = static_cast<double>(state_->queue.size() + 1);
    const double seconds = jobs_ahead * state_->mean_run_seconds / state_->limits.workers;
    return static_cast<int>(std::clamp(std::ceil(seconds), 1.0, 60.0));
}

void Scheduler::StopAdmitting() {
    const std::lock_guard lock(state_->mutex);
    state_->draining = true;
    state_->DropBackground();
}

bool Scheduler::WaitUntilIdle(std::chrono::milliseconds bound) {
    std::unique_lock lock(state_->mutex);
    return state_->became_idle.wait_for(lock, bound, [this] { return state_->idle(); });
}

void Scheduler::CutOff() {
    std::unique_lock lock(state_->mutex);
    state_->draining = true;
    state_->DropBackground();
    state_->CutAll();
    state_->watch_needed.notify_one();
    state_->became_idle.wait(lock, [this] { return state_->idle(); });
}

// Cancels what waits and what runs.
void Scheduler::State::CutAll() {
    for (const Admitted& admitted : queue) {
        admitted.ticket->cut_by_drain_ = true;
        admitted.ticket->cancel().Cancel();
    }
    for (const Running& job : running) {
        job.ticket->cut_by_drain_ = true;
        job.ticket->cancel().Cancel();
    }
}

void Scheduler::State::Work() {
    std::unique_lock lock(mutex);
    for (;;) {
        work_came.wait(lock, [this] { return stop || !queue.empty() || may_step(); });
        if (queue.empty()) {
            if (stop) return;
            StepBackground(lock);
            continue;
        }
        Admitted admitted = std::move(queue.front());
        queue.pop_front();
        running.push_back({admitted.ticket, admitted.deadline});
        RunOne(admitted, lock);
        std::erase_if(running, [&ticket = admitted.ticket](const Running& job) {
            return job.ticket == ticket;
        });
        NoteIdle();
    }
}

void Scheduler::State::NoteIdle() {
    if (!idle()) return;
    became_idle.notify_all();
    if (may_step()) work_came.notify_one();
}

// Enters and leaves with the lock, and steps without it.
void Scheduler::State::StepBackground(std::unique_lock<std::mutex>& lock) {
    BackgroundWork work = std::move(background.front());
    background.pop_front();
    in_step = work.cancel;
    lock.unlock();
    const bool more = !work.cancel.cancelled() && work.step();
    lock.lock();
    in_step.reset();
    if (more && !draining && !work.cancel.cancelled()) background.push_back(std::move(work));
}

void Scheduler::State::DropBackground() {
    for (const BackgroundWork& work : background) work.cancel.Cancel();
    if (in_step) in_step->Cancel();
    background.clear();
}

// Enters and leaves with the lock, and calls the job's functions without it.
void Scheduler::State::RunOne(Admitted& admitted, std::unique_lock<std::mutex>& lock) {
    lock.unlock();
    const std::uint64_t bytes = admitted.job.picture_bytes ? admitted.job.picture_bytes() : 0;
    lock.lock();
    // The client may have left, or the drain's bound passed, since the watch thread last looked.
    const JobTicket& ticket = *admitted.ticket;
    const std::optional<Refusal> refusal =
        ticket.cancel().cancelled() ? ReasonOfCancel(ticket) : Reserve(bytes);
    lock.unlock();
    if (refusal) {
        admitted.job.refuse(*refusal);
        lock.lock();
        return;
    }
    const Clock::time_point start = Clock::now();
    admitted.job.run(*admitted.ticket);
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    lock.lock();
    reserved_bytes -= bytes;
    mean_run_seconds = 0.8 * mean_run_seconds + 0.2 * seconds;
}

std::optional<Refusal> Scheduler::State::Reserve(std::uint64_t bytes) {
    if (bytes > limits.picture_bytes) return Refusal::kTooLarge;
    if (bytes > limits.picture_bytes - reserved_bytes) return Refusal::kMemory;
    reserved_bytes += bytes;
    return std::nullopt;
}

void Scheduler::State::Watch() {
    std::unique_lock lock(mutex);
    while (!stop) {
        if (idle()) {
            watch_needed.wait(lock, [this] { return stop || !idle(); });
        } else {
            watch_needed.wait_for(lock, kWatchPeriod);
        }
        RefuseDeadJobs(lock);
    }
}

// Enters and leaves with the lock, and refuses without it. Jobs that are being refused count as
// running, so that a drain waits for their replies.
void Scheduler::State::RefuseDeadJobs(std::unique_lock<std::mutex>& lock) {
    const Clock::time_point now = Clock::now();
    for (const Running& job : running) {
        if (now < job.deadline || job.ticket->cancel().cancelled()) continue;
        job.ticket->deadline_passed_ = true;
        job.ticket->cancel().Cancel();
    }
    std::vector<std::pair<Admitted, Refusal>> dead;
    for (auto it = queue.begin(); it != queue.end();) {
        const bool cancelled = it->ticket->cancel().cancelled();
        if (!cancelled && now < it->deadline) {
            ++it;
            continue;
        }
        const Refusal reason = cancelled ? ReasonOfCancel(*it->ticket) : Refusal::kDeadline;
        running.push_back({it->ticket, it->deadline});
        dead.emplace_back(std::move(*it), reason);
        it = queue.erase(it);
    }
    if (dead.empty()) return;
    lock.unlock();
    for (auto& [admitted, reason] : dead) admitted.job.refuse(reason);
    lock.lock();
    for (const auto& [admitted, reason] : dead) {
        std::erase_if(running, [&ticket = admitted.ticket](const Running& job) {
            return job.ticket == ticket;
        });
    }
    NoteIdle();
}

}  // namespace flare
