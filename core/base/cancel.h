// SPDX-License-Identifier: Apache-2.0
//
// A CancelToken lets the one who asked for work say that nobody waits for it any more (the client
// left, the deadline passed). Copies share one flag. Work polls it between units of a few
// milliseconds and returns Error{"cancelled"}. Safe from any thread.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <optional>

namespace flare {

class CancelToken {
  public:
    CancelToken() : flag_(std::make_shared<std::atomic<bool>>(false)) {}

    void Cancel() const { flag_->store(true, std::memory_order_relaxed); }
    bool cancelled() const {
        return flag_->load(std::memory_order_relaxed) ||
               (deadline_ && std::chrono::steady_clock::now() >= *deadline_);
    }

    // A copy that counts as cancelled from the deadline on as well.
    CancelToken Until(std::chrono::steady_clock::time_point deadline) const {
        CancelToken token = *this;
        token.deadline_ = deadline_ ? std::min(*deadline_, deadline) : deadline;
        return token;
    }

  private:
    std::optional<std::chrono::steady_clock::time_point> deadline_;
    std::shared_ptr<std::atomic<bool>> flag_;
};

}  // namespace flare
