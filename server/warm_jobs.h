// SPDX-License-Identifier: Apache-2.0
//
// The warming that was asked for, by id: for GET and DELETE /v1/warm/ID. The oldest that are over
// are forgotten when more come than are kept. Safe from any thread.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "core/base/cancel.h"
#include "server/warm_work.h"

namespace flare {

class WarmJobs {
  public:
    // Holds on to the task; a step of it is `Step`.
    class Job {
      public:
        Job(std::string id, WarmTask task) : id_(std::move(id)), task_(std::move(task)) {}

        const std::string& id() const { return id_; }
        const CancelToken& cancel() const { return cancel_; }
        // One step; true if more is left. Never throws.
        bool Step();
        bool over() const { return over_ || cancel_.cancelled(); }
        // {"id","state","lights",...}
        std::string Json() const;

      private:
        const std::string id_;
        const WarmTask task_;
        const CancelToken cancel_;
        std::atomic<bool> over_ = false, failed_ = false;
    };
    using JobPtr = std::shared_ptr<Job>;

    JobPtr Add(const std::string& id, WarmTask task);
    void Remove(const std::string& id);
    JobPtr Find(const std::string& id) const;  // null if there is none
    std::size_t under_way() const;

  private:
    mutable std::mutex mutex_;
    std::deque<std::pair<std::string, JobPtr>> jobs_;  // oldest first
};

}  // namespace flare
