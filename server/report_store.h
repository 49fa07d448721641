// SPDX-License-Identifier: Apache-2.0
//
// The reports of the last requests, by id. The oldest goes when one more comes than is kept. Safe
// from any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace flare {

class ReportStore {
  public:
    static constexpr std::size_t kKept = 1'024;

    ReportStore();

    // Never the same twice, and not the same in another run of the daemon.
    std::string NewId();
    void Put(const std::string& id, std::string report);
    std::optional<std::string> Get(const std::string& id) const;

  private:
    mutable std::mutex mutex_;  // guards all below
    std::string run_;
    std::uint64_t next_ = 1;
    std::deque<std::string> order_;  // oldest first
    std::map<std::string, std::string> reports_;
};

}  // namespace flare
