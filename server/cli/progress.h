// SPDX-License-Identifier: Apache-2.0
//
// Says on standard error that something goes on, once it has taken a second, if a person watches (a
// terminal). The line is gone when the object is.
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace flare::cli {

class Progress {
  public:
    explicit Progress(std::string what);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

  private:
    void Watch();

    std::string what_;
    std::mutex mutex_;
    std::condition_variable ended_;
    bool done_ = false;
    std::thread watcher_;
};

// A bar for work in counted steps, if a person watches. The line is gone when the object is.
class ProgressBar {
  public:
    ProgressBar();
    ~ProgressBar();
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    // `done` of `all`, and what is being done now.
    void Show(int done, int all, const std::string& what) const;

  private:
    bool watched_;
};

}  // namespace flare::cli
