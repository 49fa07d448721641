// SPDX-License-Identifier: Apache-2.0
//
// One queue of loops. Every loop is a shared counter; a worker takes the newest loop that still has
// items and runs items until the counter passes the end. A caller takes items of its own loop only,
// so a nested loop never waits for work that waits for it.
#include "core/base/parallel.h"

#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "core/base/check.h"

namespace flare {
namespace {

struct Loop {
    const std::function<void(int)>* body = nullptr;
    int count = 0;
    std::atomic<int> next{0};
    std::atomic<int> done{0};
    std::mutex mutex;
    std::condition_variable finished;

    bool exhausted() const { return next.load() >= count; }

    void RunItems() {
        for (int i = next.fetch_add(1); i < count; i = next.fetch_add(1)) {
            (*body)(i);
            if (done.fetch_add(1) + 1 == count) {
                const std::lock_guard lock(mutex);
                finished.notify_all();
            }
        }
    }
};

}  // namespace

struct ThreadPool::State {
    std::mutex mutex;
    std::condition_variable wake;
    std::deque<std::shared_ptr<Loop>> loops;
    bool stop = false;
    std::vector<std::thread> workers;

    std::shared_ptr<Loop> TakeLoop() {
        std::unique_lock lock(mutex);
        for (;;) {
            while (!loops.empty() && loops.back()->exhausted()) loops.pop_back();
            if (!loops.empty()) return loops.back();
            if (stop) return nullptr;
            wake.wait(lock);
        }
    }
};

ThreadPool::ThreadPool(int threads) : state_(std::make_shared<State>()) {
    FLARE_CHECK(threads >= 1);
    for (int i = 1; i < threads; ++i) {
        state_->workers.emplace_back([state = state_.get()] {
            while (const std::shared_ptr<Loop> loop = state->TakeLoop()) loop->RunItems();
        });
    }
}

ThreadPool::~ThreadPool() {
    {
        const std::lock_guard lock(state_->mutex);
        state_->stop = true;
    }
    state_->wake.notify_all();
    for (std::thread& worker : state_->workers) worker.join();
}

int ThreadPool::threads() const {
    return static_cast<int>(state_->workers.size()) + 1;
}

void ThreadPool::For(int count, const std::function<void(int)>& body) {
    if (count <= 0) return;
    if (count == 1 || state_->workers.empty()) {
        for (int i = 0; i < count; ++i) body(i);
        return;
    }
    const auto loop = std::make_shared<Loop>();
    loop->body = &body;
    loop->count = count;
    {
        const std::lock_guard lock(state_->mutex);
        state_->loops.push_back(loop);
    }
    state_->wake.notify_all();
    loop->RunItems();
    std::unique_lock lock(loop->mutex);
    loop->finished.wait(lock, [&] { return loop->done.load() == loop->count; });
}

}  // namespace flare
