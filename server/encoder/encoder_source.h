// SPDX-License-Identifier: Apache-2.0
//
// What feeds a track: a file, a port, a device. A source runs a thread of its own from construction
// until it is destroyed; nothing that happens to its device ends it.
#pragma once

#include <functional>
#include <memory>
#include <thread>

#include "core/base/result.h"
#include "server/encoder/encoder_track.h"

namespace flare {

class EncoderSource {
  public:
    virtual ~EncoderSource() = default;
};

// How a source's thread learns that it is to end: an eventfd, so that it can be waited for together
// with sockets.
class StopSignal {
  public:
    StopSignal();
    ~StopSignal();
    StopSignal(const StopSignal&) = delete;
    StopSignal& operator=(const StopSignal&) = delete;

    void Set();
    int fd() const { return fd_; }  // readable once it is set
    bool set() const { return WaitFor_ms(0.0); }
    // True as soon as it is set, false after the time.
    bool WaitFor_ms(double ms) const;

  private:
    int fd_;
};

// Lets the calling thread go before all ordinary ones (SCHED_RR at its lowest priority), so that
// requests that keep every core busy do not make a reading late. False where that is not allowed:
// the thread stays as it is. For threads whose work is bounded by the speed of a wire.
bool GoBeforeRequests();
// Whether a thread that is started now may; asks in one of its own.
bool MayGoBeforeRequests();

// A thread that ends when its owner does. It is the last member of a source.
class SourceThread {
  public:
    explicit SourceThread(std::function<void(const StopSignal&)> body)
        : thread_([this, run = std::move(body)] { run(stop_); }) {}
    ~SourceThread() {
        stop_.Set();
        thread_.join();
    }
    SourceThread(const SourceThread&) = delete;
    SourceThread& operator=(const SourceThread&) = delete;

  private:
    StopSignal stop_;
    std::thread thread_;
};

}  // namespace flare
