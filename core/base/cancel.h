// SPDX-License-Identifier: Apache-2.0
//
// A CancelToken lets the one who asked for work say that nobody waits for it any more (the client
// left, the deadline passed). Copies share one flag. Work polls it between units of a few
// milliseconds and returns Error{"cancelled"}. Safe from any thread.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <utility>

namespace flare {

class CancelToken {
  public:
    CancelToken() : flag_(std::make_shared<std::atomic<bool>>(false)) {}

    void Cancel() const { flag_->store(true, std::memory_order_relaxed); }
    bool cancelled() const {
        return flag_->load(std::memory_order_relaxed) || (too_late_ && too_late_());
    }

    // A copy that counts as cancelled as well when `too_late` says so; asked from any thread.
    CancelToken OrWhen(std::function<bool()> too_late) const {
        CancelToken token = *this;
        token.too_late_ = [before = too_late_, too_late = std::move(too_late)] {
            return too_late() || (before && before());
        };
        return token;
    }

  private:
    std::function<bool()> too_late_;
    std::shared_ptr<std::atomic<bool>> flag_;
};

}  // namespace flare
