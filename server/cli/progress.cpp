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

ProgressBar::ProgressBar() : watched_(isatty(STDERR_FILENO) != 0) {}

ProgressBar::~ProgressBar() {
    if (watched_) std::fputs("\r\033[K", stderr);
}

void ProgressBar::Show(int done, int all, const std::string& what) const {
    constexpr int kMarks = 24;
    if (!watched_ || all <= 0) return;
    const auto marks = static_cast<std::size_t>(static_cast<long long>(kMarks) * done / all);
    const std::string bar = std::string(marks, '#') + std::string(kMarks - marks, '.');
    std::fprintf(stderr, "\r\033[K[%s] %d/%d %s", bar.c_str(), done, all, what.c_str());
    std::fflush(stderr);
}

}  // namespace flare::cli
