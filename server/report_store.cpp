// SPDX-License-Identifier: Apache-2.0
#include "server/report_store.h"

#include <cstdio>
#include <random>
#include <utility>

namespace flare {

ReportStore::ReportStore() {
    std::random_device random;
    char text[16] = {};
    std::snprintf(text, sizeof(text), "%08x", static_cast<unsigned>(random()));
    run_ = text;
}

std::string ReportStore::NewId() {
    const std::lock_guard lock(mutex_);
    return run_ + "-" + std::to_string(next_++);
}

void ReportStore::Put(const std::string& id, std::string report) {
    const std::lock_guard lock(mutex_);
    if (order_.size() >= kKept) {
        reports_.erase(order_.front());
        order_.pop_front();
    }
    order_.push_back(id);
    reports_[id] = std::move(report);
}

std::optional<std::string> ReportStore::Get(const std::string& id) const {
    const std::lock_guard lock(mutex_);
    const auto found = reports_.find(id);
    if (found == reports_.end()) return std::nullopt;
    return found->second;
}

}  // namespace flare
