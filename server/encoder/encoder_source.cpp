// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/encoder_source.h"

#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>

namespace flare {

bool GoBeforeRequests() {
    pthread_setname_np(pthread_self(), "encoder");
    const sched_param lowest{sched_get_priority_min(SCHED_RR)};
    return pthread_setschedparam(pthread_self(), SCHED_RR, &lowest) == 0;
}

bool MayGoBeforeRequests() {
    bool may = false;
    std::thread([&may] { may = GoBeforeRequests(); }).join();
    return may;
}

StopSignal::StopSignal() : fd_(eventfd(0, EFD_CLOEXEC)) {
    FLARE_CHECK(fd_ >= 0);
}

StopSignal::~StopSignal() {
    close(fd_);
}

void StopSignal::Set() {
    FLARE_CHECK(eventfd_write(fd_, 1) == 0);
}

bool StopSignal::WaitFor_ms(double ms) const {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point end =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(
                           std::chrono::duration<double, std::milli>(std::clamp(ms, 0.0, 1e9)));
    for (;;) {
        const auto left = std::max(end - Clock::now(), Clock::duration::zero());
        const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(left);
        const timespec wait{seconds.count(), std::chrono::nanoseconds(left - seconds).count()};
        pollfd poll_fd{fd_, POLLIN, 0};
        if (ppoll(&poll_fd, 1, &wait, nullptr) > 0) return true;
        if (Clock::now() >= end) return false;
    }
}

}  // namespace flare
