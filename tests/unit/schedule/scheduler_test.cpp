// SPDX-License-Identifier: Apache-2.0
#include "server/schedule/scheduler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace flare {
namespace {

using namespace std::chrono_literals;

// A door that jobs wait at until the test opens it.
class Gate {
  public:
    void Wait() {
        std::unique_lock lock(mutex_);
        opened_.wait(lock, [this] { return open_; });
    }
    void Open() {
        const std::lock_guard lock(mutex_);
        open_ = true;
        opened_.notify_all();
    }

  private:
    std::mutex mutex_;
    std::condition_variable opened_;
    bool open_ = false;
};

// What became of the jobs of a test.
class Log {
  public:
    void Add(const std::string& line) {
        const std::lock_guard lock(mutex_);
        lines_.push_back(line);
        added_.notify_all();
    }
    // Waits for `count` lines (10 s at most) and gives them all.
    std::vector<std::string> Await(std::size_t count) {
        std::unique_lock lock(mutex_);
        added_.wait_for(lock, 10s, [&] { return lines_.size() >= count; });
        return lines_;
    }

  private:
    std::mutex mutex_;
    std::condition_variable added_;
    std::vector<std::string> lines_;
};

std::string NameOf(Refusal refusal) {
    switch (refusal) {
        case Refusal::kQueueFull:
            return "queue_full";
        case Refusal::kDraining:
            return "draining";
        case Refusal::kMemory:
            return "memory";
        case Refusal::kTooLarge:
            return "too_large";
        case Refusal::kDeadline:
            return "deadline";
        case Refusal::kCancelled:
            return "cancelled";
    }
    return "";
}

Job MakeJob(Log& log, const std::string& name, std::function<void(const JobTicket&)> body = {},
            std::uint64_t bytes = 0) {
    Job job;
    job.picture_bytes = [bytes] { return bytes; };
    job.run = [&log, name, body](const JobTicket& ticket) {
        if (body) body(ticket);
        log.Add(name + " ran");
    };
    job.refuse = [&log, name](Refusal reason) { log.Add(name + " " + NameOf(reason)); };
    return job;
}

// Blocks the single worker until the gate opens.
void Occupy(Scheduler& scheduler, Log& log, Gate& gate, std::uint64_t bytes = 0) {
    Gate started;
    ASSERT_FALSE(scheduler.Submit(MakeJob(
        log, "occupant",
        [&](const JobTicket&) {
            started.Open();
            gate.Wait();
        },
        bytes)));
    started.Wait();
}

using Lines = std::vector<std::string>;

TEST(Scheduler, RunsJobsInTheOrderTheyCame) {
    Log log;
    Gate gate;
    Scheduler scheduler({.workers = 1});
    Occupy(scheduler, log, gate);
    for (const char* name : {"a", "b", "c"}) EXPECT_FALSE(scheduler.Submit(MakeJob(log, name)));
    EXPECT_EQ(scheduler.queued(), 3U);
    gate.Open();
    EXPECT_EQ(log.Await(4), (Lines{"occupant ran", "a ran", "b ran", "c ran"}));
}

TEST(Scheduler, RefusesWhenTheQueueIsFullAndTakesAgainWhenItIsNot) {
    Log log;
    Gate gate;
    Scheduler scheduler({.workers = 1, .queue = 2});
    Occupy(scheduler, log, gate);
    EXPECT_FALSE(scheduler.Submit(MakeJob(log, "a")));
    EXPECT_FALSE(scheduler.Submit(MakeJob(log, "b")));
    EXPECT_EQ(scheduler.Submit(MakeJob(log, "c")), Refusal::kQueueFull);
    EXPECT_GE(scheduler.RetryAfterSeconds(), 1);
    gate.Open();
    EXPECT_EQ(log.Await(3), (Lines{"occupant ran", "a ran", "b ran"}));
    EXPECT_FALSE(scheduler.Submit(MakeJob(log, "d")));
    EXPECT_EQ(log.Await(4).back(), "d ran");
}

TEST(Scheduler, RunsAsManyJobsAtOnceAsItHasWorkers) {
    Log log;
    Scheduler scheduler({.workers = 3});
    Gate all_here;
    std::atomic<int> here = 0;
    for (int i = 0; i < 3; ++i) {
        EXPECT_FALSE(scheduler.Submit(MakeJob(log, "job", [&](const JobTicket&) {
            if (++here == 3) all_here.Open();
            all_here.Wait();  // hangs unless all three run at once
        })));
    }
    EXPECT_EQ(log.Await(3).size(), 3U);
}

TEST(Scheduler, PicturesInWorkAreBoundedInBytes) {
    Log log;
    Gate gate;
    Scheduler scheduler({.workers = 2, .picture_bytes = 100});
    Occupy(scheduler, log, gate, 60);
    EXPECT_FALSE(scheduler.Submit(MakeJob(log, "a", {}, 41)));
    EXPECT_EQ(log.Await(1), (Lines{"a memory"}));
    EXPECT_FALSE(scheduler.Submit(MakeJob(log, "b", {}, 40)));
    EXPECT_EQ(log.Await(2).back(), "b ran");
    EXPECT_FALSE(scheduler.Submit(MakeJob(log, "c", {}, 101)));
    EXPECT_EQ(log.Await(3).back(), "c too_large");
    gate.Open();
    EXPECT_EQ(log.Await(4).back(), "occupant ran");
    EXPECT_TRUE(scheduler.WaitUntilIdle(10s));
    EXPECT_FALSE(scheduler.Submit(MakeJob(log, "d", {}, 100)));
    EXPECT_EQ(log.Await(5).back(), "d ran") << "finished pictures give their bytes back";
}

TEST(Scheduler, ADeadlineCutsAJobThatWaitsEvenWhileAllWorkersAreBusy) {
    Log log;
    Gate gate;
    Scheduler scheduler({.workers = 1, .deadline = 50ms});
    Occupy(scheduler, log, gate);
    EXPECT_FALSE(scheduler.Submit(MakeJob(log, "a")));
    EXPECT_EQ(log.Await(1), (Lines{"a deadline"}));
    EXPECT_EQ(scheduler.queued(), 0U);
    gate.Open();
}

TEST(Scheduler, ADeadlineCancelsAJobThatRunsAndSaysWhy) {
    Log log;
    Scheduler scheduler({.workers = 1, .deadline = 50ms});
    EXPECT_FALSE(scheduler.Submit(MakeJob(log, "a", [&](const JobTicket& ticket) {
        while (!ticket.cancel().cancelled()) std::this_thread::sleep_for(1ms);
        log.Add(ticket.deadline_passed() ? "deadline" : "something else");
    })));
    EXPECT_EQ(log.Await(2), (Lines{"deadline", "a ran"}));
}

TEST(Scheduler, AClientThatLeavesGivesItsPlaceInTheQueueBack) {
    Log log;
    Gate gate;
    Scheduler scheduler({.workers = 1, .queue = 1});
    Occupy(scheduler, log, gate);
    Job job = MakeJob(log, "a");
    const CancelToken token = job.cancel;
    EXPECT_FALSE(scheduler.Submit(std::move(job)));
    EXPECT_EQ(scheduler.Submit(MakeJob(log, "b")), Refusal::kQueueFull);
    token.Cancel();
    EXPECT_EQ(log.Await(1), (Lines{"a cancelled"}));
    EXPECT_FALSE(scheduler.Submit(MakeJob(log, "c")));
    gate.Open();
    EXPECT_EQ(log.Await(3).back(), "c ran");
}

TEST(Scheduler, CancellingOneJobLeavesTheOthersAlone) {
    Log log;
    Gate gate;
    Scheduler scheduler({.workers = 1});
    Occupy(scheduler, log, gate);
    Job job = MakeJob(log, "a");
    const CancelToken token = job.cancel;
    EXPECT_FALSE(scheduler.Submit(std::move(job)));
    EXPECT_FALSE(scheduler.Submit(MakeJob(log, "b")));
    token.Cancel();
    log.Await(1);
    gate.Open();
    EXPECT_EQ(log.Await(3), (Lines{"a cancelled", "occupant ran", "b ran"}));
}

TEST(Scheduler, ADrainFinishesWhatWasAdmittedAndAdmitsNothingMore) {
    Log log;
    Gate gate;
    Scheduler scheduler({.workers = 1});
    Occupy(scheduler, log, gate);
    EXPECT_FALSE(scheduler.Submit(MakeJob(log, "a")));
    scheduler.StopAdmitting();
    EXPECT_EQ(scheduler.Submit(MakeJob(log, "late")), Refusal::kDraining);
    EXPECT_FALSE(scheduler.WaitUntilIdle(10ms));
    gate.Open();
    EXPECT_TRUE(scheduler.WaitUntilIdle(10s));
    EXPECT_EQ(log.Await(2), (Lines{"occupant ran", "a ran"}));
}

TEST(Scheduler, ACutOffAnswersEveryJobBeforeItReturns) {
    Log log;
    Scheduler scheduler({.workers = 1});
    Gate started;
    EXPECT_FALSE(scheduler.Submit(MakeJob(log, "endless", [&](const JobTicket& ticket) {
        started.Open();
        while (!ticket.cancel().cancelled()) std::this_thread::sleep_for(1ms);
        if (ticket.cut_by_drain()) log.Add("told so");
        std::this_thread::sleep_for(100ms);
    })));
    started.Wait();
    EXPECT_FALSE(scheduler.Submit(MakeJob(log, "waiting")));
    scheduler.CutOff();
    const Lines lines = log.Await(3);
    ASSERT_EQ(lines.size(), 3U) << "it returns after the last reply, not before";
    EXPECT_EQ(std::count(lines.begin(), lines.end(), "told so"), 1);
    EXPECT_EQ(std::count(lines.begin(), lines.end(), "waiting draining"), 1);
    EXPECT_EQ(lines.back(), "endless ran");
}

// Steps until `steps` are done; each adds its name to the log.
BackgroundWork Steps(Log& log, const std::string& name, int steps) {
    const auto left = std::make_shared<std::atomic<int>>(steps);
    return {{}, [&log, name, left] {
                log.Add(name);
                return --*left > 0;
            }};
}

TEST(Scheduler, BackgroundWorkTakesTurnsStepByStep) {
    Log log;
    Scheduler scheduler({.workers = 3});
    Gate gate, started;
    Job blocking;
    blocking.run = [&](const JobTicket&) {
        started.Open();
        gate.Wait();
    };
    blocking.refuse = [](Refusal) {};
    EXPECT_FALSE(scheduler.Submit(std::move(blocking)));
    started.Wait();
    EXPECT_FALSE(scheduler.SubmitBackground(Steps(log, "a", 3)));
    EXPECT_FALSE(scheduler.SubmitBackground(Steps(log, "b", 2)));
    std::this_thread::sleep_for(50ms);
    EXPECT_EQ(log.Await(0).size(), 0U) << "not while a job runs, though workers are free";
    gate.Open();
    const std::vector<std::string> expected{"a", "b", "a", "b", "a"};
    EXPECT_EQ(log.Await(5), expected);
    EXPECT_TRUE(scheduler.WaitUntilIdle(10s));
}

TEST(Scheduler, AJobWaitsForOneBackgroundStepAtTheLongest) {
    Log log;
    Scheduler scheduler({.workers = 1});
    Gate gate, started;
    const auto step = [&] {
        started.Open();
        gate.Wait();
        log.Add("step");
        return true;  // for ever
    };
    const BackgroundWork endless{{}, step};
    EXPECT_FALSE(scheduler.SubmitBackground(endless));
    started.Wait();
    Job job;
    job.run = [&](const JobTicket&) {
        log.Add("job");
        endless.cancel.Cancel();
    };
    job.refuse = [](Refusal) {};
    EXPECT_FALSE(scheduler.Submit(std::move(job)));
    gate.Open();
    const std::vector<std::string> expected{"step", "job"};
    EXPECT_EQ(log.Await(2), expected);
    std::this_thread::sleep_for(50ms);
    EXPECT_EQ(log.Await(2), expected) << "its token ends it";
}

TEST(Scheduler, BackgroundWorkIsBoundedAndEndsWithAdmission) {
    Log log;
    Gate gate, started;
    Scheduler scheduler({.workers = 1, .background = 2});
    const BackgroundWork running{{}, [&] {
                                     started.Open();
                                     gate.Wait();
                                     return true;
                                 }};
    EXPECT_FALSE(scheduler.SubmitBackground(running));
    started.Wait();
    const BackgroundWork waiting = Steps(log, "waiting", 1);
    EXPECT_FALSE(scheduler.SubmitBackground(waiting));
    EXPECT_EQ(scheduler.SubmitBackground(Steps(log, "third", 1)), Refusal::kQueueFull);
    waiting.cancel.Cancel();
    const BackgroundWork fourth = Steps(log, "fourth", 1);
    EXPECT_FALSE(scheduler.SubmitBackground(fourth)) << "what was called off makes room";
    EXPECT_FALSE(running.cancel.cancelled());
    scheduler.StopAdmitting();
    EXPECT_TRUE(running.cancel.cancelled());
    EXPECT_TRUE(fourth.cancel.cancelled());
    EXPECT_EQ(scheduler.SubmitBackground(Steps(log, "late", 1)), Refusal::kDraining);
    EXPECT_TRUE(scheduler.WaitUntilIdle(10s)) << "a drain does not wait for it";
    gate.Open();
    std::this_thread::sleep_for(50ms);
    EXPECT_EQ(log.Await(0).size(), 0U);
}

TEST(Scheduler, EveryAdmittedJobIsAnsweredExactlyOnce) {
    std::atomic<int> answered = 0, admitted = 0;
    {
        Scheduler scheduler({.workers = 3, .queue = 8, .picture_bytes = 20, .deadline = 30ms});
        std::vector<std::jthread> clients;
        for (int c = 0; c < 4; ++c) {
            clients.emplace_back([&, c] {
                for (int i = 0; i < 300; ++i) {
                    Job job;
                    job.picture_bytes = [i] { return static_cast<std::uint64_t>(i % 22); };
                    job.run = [&](const JobTicket&) {
                        std::this_thread::sleep_for(200us);
                        ++answered;
                    };
                    job.refuse = [&](Refusal) { ++answered; };
                    const CancelToken token = job.cancel;
                    if (!scheduler.Submit(std::move(job))) ++admitted;
                    if ((i + c) % 5 == 0) token.Cancel();
                    if (i % 3 == 0) std::this_thread::sleep_for(300us);
                }
            });
        }
    }
    EXPECT_EQ(answered, admitted);
    EXPECT_GT(admitted, 100);
}

}  // namespace
}  // namespace flare
