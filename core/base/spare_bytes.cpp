// SPDX-License-Identifier: Apache-2.0
#include "core/base/spare_bytes.h"

#include <algorithm>
#include <utility>

namespace flare {
namespace {

constexpr std::size_t kWorthKeeping = std::size_t{1} << 16;

bool Smaller(const std::string& a, const std::string& b) {
    return a.capacity() < b.capacity();
}

}  // namespace

std::string SpareBytes::Take() {
    const std::lock_guard lock(mutex_);
    if (spare_.empty()) return {};
    const auto roomiest = std::max_element(spare_.begin(), spare_.end(), Smaller);
    std::string bytes = std::move(*roomiest);
    spare_.erase(roomiest);
    return bytes;
}

void SpareBytes::Keep(std::string bytes) {
    if (bytes.capacity() < kWorthKeeping) return;
    const std::lock_guard lock(mutex_);
    std::size_t held = bytes.capacity();
    for (const std::string& other : spare_) held += other.capacity();
    if (spare_.size() >= most_strings_ || held > most_bytes_) return;
    spare_.push_back(std::move(bytes));
}

}  // namespace flare
