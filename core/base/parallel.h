// SPDX-License-Identifier: Apache-2.0
//
// A pool of threads for loops whose items do not depend on each other. Results must not depend on
// which thread ran which item or in what order: an item writes only what it owns, and sums are made
// afterwards in index order. Then a program gives the same bytes on any number of threads.
#pragma once

#include <functional>
#include <memory>

namespace flare {

class ThreadPool {
  public:
    // `threads` counts the caller of For: 1 runs everything in the caller.
    explicit ThreadPool(int threads);
    ~ThreadPool();
    ThreadPool(const ThreadPool&) = delete;
    ThreadPool& operator=(const ThreadPool&) = delete;

    // Runs body(0) ... body(count - 1), each once, and returns when all are done. The caller works
    // too, so calls may nest and may come from several threads at once without deadlock. The body
    // must not throw.
    void For(int count, const std::function<void(int)>& body);

    int threads() const;

  private:
    struct State;
    std::shared_ptr<State> state_;
};

}  // namespace flare
