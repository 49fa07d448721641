// SPDX-License-Identifier: Apache-2.0
//
// Every number the daemon publishes at GET /metrics, in Prometheus' text format. The names are a
// contract with dashboards: docs/daemon.md lists them. Safe from any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/cache/disk_cache.h"
#include "server/cache/single_flight_cache.h"

namespace flare {

struct CacheReadings {
    CacheStats meshes;
    std::uint64_t rays_traced = 0;  // for all meshes that were ever built
    DiskCacheStats disk{};          // zeros where there is none
    CacheStats ghosts{};            // kept as they were drawn
};

struct EncoderCounts {
    std::string name;
    bool connected = false;
    std::uint64_t samples = 0;
    std::vector<std::pair<std::string, std::uint64_t>> faults;  // by kind
    std::uint64_t states_warmed = 0;
};

// What is read at the moment somebody asks.
struct GaugeReadings {
    CacheReadings cache;
    std::vector<EncoderCounts> encoders;
    std::size_t queue_depth = 0;
    std::size_t connections = 0;
    std::size_t warm_jobs = 0;
    bool draining = false;
};

class CountersTable {
  public:
    explicit CountersTable(const std::string& version);
    ~CountersTable();

    // `route` is the pattern of the contract ("/v1/lenses/NAME"), never what the client wrote: the
    // number of time series must not grow with the clients' inventions.
    void CountRequest(const std::string& route, int code, double seconds);
    void CountRejection(const std::string& reason);

    std::string Text(const GaugeReadings& readings) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace flare
