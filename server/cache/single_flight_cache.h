// SPDX-License-Identifier: Apache-2.0
//
// A bounded map from fingerprints to shared, immutable values, charged in bytes, in which equal
// keys that are asked for at once are built once: the first caller builds in its own thread, the
// others wait for it. The least recently used values go first; a value larger than the whole bound
// is given to its callers and not kept. A value that left the cache lives on for those who still
// hold it. A waiter whose token is cancelled leaves with Error "cancelled" within kCancelPoll; the
// builder goes on. Safe from any thread. `Charge` says how many bytes a value holds.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <utility>

#include "core/base/cancel.h"
#include "core/base/fingerprint.h"
#include "core/base/result.h"
#include "server/cache/recent_values.h"

namespace flare {

template <class Value>
class SingleFlightCache {
  public:
    using Build = std::function<Value()>;
    using Charge = std::function<std::size_t(const Value&)>;
    struct Found {
        std::shared_ptr<const Value> value;
        bool hit = false;
    };

    static constexpr std::chrono::milliseconds kCancelPoll{10};

    SingleFlightCache(std::size_t max_bytes, Charge charge)
        : charge_(std::move(charge)), kept_(max_bytes) {}

    Result<Found> Get(const Fingerprint& key, const Build& build, const CancelToken& cancel) {
        std::unique_lock lock(mutex_);
        for (;;) {
            if (std::shared_ptr<const Value> kept = kept_.Find(key)) {
                ++hits_;
                return Found{std::move(kept), true};
            }
            const auto flight = flights_.find(key);
            if (flight == flights_.end()) break;
            const std::shared_ptr<Flight> shared = flight->second;
            if (!Wait(lock, *shared, cancel)) {
                return Error{"cancelled", "the caller no longer waits for this", ""};
            }
            if (shared->value) {
                ++hits_;
                return Found{shared->value, true};
            }
            // The builder ran out of memory: start over, perhaps as the next builder.
        }
        return BuildNow(lock, key, build);
    }

    CacheStats stats() const {
        const std::lock_guard lock(mutex_);
        return {hits_, misses_, kept_.evictions(), kept_.bytes(), kept_.entries()};
    }

  private:
    struct Flight {
        std::condition_variable landed;
        bool done = false;
        std::shared_ptr<const Value> value;
    };

    bool Wait(std::unique_lock<std::mutex>& lock, Flight& flight, const CancelToken& cancel) {
        while (!flight.done) {
            if (cancel.cancelled()) return false;
            flight.landed.wait_for(lock, kCancelPoll);
        }
        return true;
    }

    // Builds without the lock; enters and leaves with it.
    Result<Found> BuildNow(std::unique_lock<std::mutex>& lock, const Fingerprint& key,
                           const Build& build) {
        ++misses_;
        const auto flight = std::make_shared<Flight>();
        flights_.emplace(key, flight);
        lock.unlock();
        std::shared_ptr<const Value> value;
        std::size_t bytes = 0;
        std::exception_ptr failure;  // out of memory: the waiters must not hang for it
        try {
            value = std::make_shared<const Value>(build());
            bytes = charge_(*value);
        } catch (...) {
            value = nullptr;
            failure = std::current_exception();
        }
        lock.lock();
        flights_.erase(key);
        flight->done = true;
        flight->value = value;
        flight->landed.notify_all();
        if (failure) std::rethrow_exception(failure);
        kept_.Keep(key, value, bytes);
        return Found{value, false};
    }

    const Charge charge_;
    mutable std::mutex mutex_;  // guards all below
    RecentValues<Value> kept_;
    // A caller that waited for another's build is a hit: nothing was built for it.
    std::uint64_t hits_ = 0, misses_ = 0;
    std::unordered_map<Fingerprint, std::shared_ptr<Flight>> flights_;
};

}  // namespace flare
