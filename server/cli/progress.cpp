// SPDX-License-Identifier: Apache-2.0
#include "server/cli/progress.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>

namespace flare::cli {

Progress::Progress(std::string what) : what_(std::move(what)) {
    if (isatty(STDERR_FILENO)) watcher_ = std::thread([this] { Watch(); });
}

Progress::~Progress() {
    if (!watcher_.joinable()) return;
    {
        const std::lock_guard lock(mutex_);
        done_ = true;
    }
    ended_.notify_one();
    watcher_.join();
}

void Progress::Watch() {
    constexpr auto kStep = std::chrono::seconds(1);
    std::unique_lock lock(mutex_);
    int seconds = 0;
    while (!ended_.wait_for(lock, kStep, [this] { return done_; })) {
        ++seconds;
        std::fprintf(stderr, "\r%s: %d s", what_.c_str(), seconds);
    }
    if (seconds > 0) std::fputs("\r\033[K", stderr);
}

}  // namespace flare::cli
