// SPDX-License-Identifier: Apache-2.0
//
// Shared, immutable values by fingerprint, charged in bytes; the least recently used go first. A
// value larger than the whole bound is not kept. Of one thread at a time: its owners lock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <unordered_map>

#include "core/base/fingerprint.h"

namespace flare {

// Counts since the start, but for bytes and entries, which are now.
struct CacheStats {
    std::uint64_t hits = 0, misses = 0, evictions = 0;
    std::uint64_t bytes = 0, entries = 0;
};

template <class Value>
class RecentValues {
  public:
    explicit RecentValues(std::size_t max_bytes) : max_bytes_(max_bytes) {}

    // Null if it is not here. Counts nothing.
    std::shared_ptr<const Value> Find(const Fingerprint& key) {
        const auto kept = kept_.find(key);
        if (kept == kept_.end()) return nullptr;
        order_.splice(order_.begin(), order_, kept->second);
        return kept->second->value;
    }

    // A key that is here already keeps its value: equal keys have equal values.
    void Keep(const Fingerprint& key, std::shared_ptr<const Value> value, std::size_t bytes) {
        if (bytes > max_bytes_ || kept_.contains(key)) return;
        while (bytes_ + bytes > max_bytes_) {
            const Entry& oldest = order_.back();
            bytes_ -= oldest.bytes;
            ++evictions_;
            kept_.erase(oldest.key);
            order_.pop_back();
        }
        order_.push_front({key, std::move(value), bytes});
        kept_[key] = order_.begin();
        bytes_ += bytes;
    }

    std::uint64_t evictions() const { return evictions_; }
    std::uint64_t bytes() const { return bytes_; }
    std::uint64_t entries() const { return order_.size(); }

  private:
    struct Entry {
        Fingerprint key;
        std::shared_ptr<const Value> value;
        std::size_t bytes;
    };
    using Order = std::list<Entry>;  // most recently used first

    const std::size_t max_bytes_;
    std::uint64_t bytes_ = 0, evictions_ = 0;
    Order order_;
    std::unordered_map<Fingerprint, typename Order::iterator> kept_;
};

}  // namespace flare
