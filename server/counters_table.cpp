// SPDX-License-Identifier: Apache-2.0
//
// What is counted here lives in prometheus-cpp's registry; what others count already (the cache,
// the queue) is read when the text is made, so that no number is kept twice.
#include "server/counters_table.h"

#include <prometheus/counter.h>
#include <prometheus/histogram.h>
#include <prometheus/metric_family.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <vector>

namespace flare {
namespace {

using prometheus::MetricFamily;
using prometheus::MetricType;

const prometheus::Histogram::BucketBoundaries kSecondsBuckets{
    0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30, 60, 300};

MetricFamily Single(const char* name, const char* help, MetricType type, double value) {
    MetricFamily family{name, help, type, {}};
    prometheus::ClientMetric metric;
    if (type == MetricType::Counter) {
        metric.counter.value = value;
    } else {
        metric.gauge.value = value;
    }
    family.metric.push_back(metric);
    return family;
}

// Families that hold one number each.
class SingleFamilies {
  public:
    explicit SingleFamilies(std::vector<MetricFamily>& families) : families_(families) {}

    void Count(const char* name, const char* help, std::uint64_t value) {
        families_.push_back(Single(name, help, MetricType::Counter, static_cast<double>(value)));
    }
    void Gauge(const char* name, const char* help, std::uint64_t value) {
        families_.push_back(Single(name, help, MetricType::Gauge, static_cast<double>(value)));
    }

  private:
    std::vector<MetricFamily>& families_;
};

void AddDisk(const DiskCacheStats& disk, SingleFamilies& single) {
    single.Count("flared_mesh_disk_hits_total", "Meshes read from disk", disk.hits);
    single.Count("flared_mesh_disk_misses_total", "Meshes that were not on disk", disk.misses);
    single.Count("flared_mesh_disk_discarded_total", "Mesh files that were torn or foreign",
                 disk.discarded);
    single.Count("flared_mesh_disk_read_bytes_total", "Bytes of the meshes read from disk",
                 disk.read_bytes);
    single.Count("flared_mesh_disk_writes_total", "Meshes written to disk", disk.writes);
    single.Count("flared_mesh_disk_written_bytes_total", "Bytes of the meshes written to disk",
                 disk.written_bytes);
    single.Count("flared_mesh_disk_dropped_total", "Meshes not written because too many waited",
                 disk.dropped);
    single.Count("flared_mesh_disk_failed_total", "Meshes that could not be written", disk.failed);
    single.Count("flared_mesh_disk_evictions_total", "Mesh files removed to make room",
                 disk.evictions);
    single.Gauge("flared_mesh_disk_bytes", "Bytes of the mesh files", disk.file_bytes);
    single.Gauge("flared_mesh_disk_files", "Mesh files", disk.files);
    single.Gauge("flared_mesh_disk_queue_bytes", "Bytes of the meshes that wait to be written",
                 disk.queue_bytes);
}

void AddEncoders(const std::vector<EncoderCounts>& encoders, std::vector<MetricFamily>& families) {
    if (encoders.empty()) return;
    MetricFamily connected{
        "flared_encoder_connected", "1 while the encoder's device is there", MetricType::Gauge, {}};
    MetricFamily samples{"flared_encoder_samples_total",
                         "Lens states read from the encoder",
                         MetricType::Counter,
                         {}};
    MetricFamily faults{"flared_encoder_faults_total",
                        "What went wrong with the encoder, by kind",
                        MetricType::Counter,
                        {}};
    MetricFamily warmed{"flared_encoder_states_warmed_total",
                        "Lens states whose meshes were traced ahead of the ring",
                        MetricType::Counter,
                        {}};
    for (const EncoderCounts& encoder : encoders) {
        prometheus::ClientMetric metric;
        metric.label = {{"name", encoder.name}};
        metric.gauge.value = encoder.connected ? 1.0 : 0.0;
        connected.metric.push_back(metric);
        metric.counter.value = static_cast<double>(encoder.samples);
        samples.metric.push_back(metric);
        metric.counter.value = static_cast<double>(encoder.states_warmed);
        warmed.metric.push_back(metric);
        for (const auto& [kind, count] : encoder.faults) {
            metric.label = {{"name", encoder.name}, {"kind", kind}};
            metric.counter.value = static_cast<double>(count);
            faults.metric.push_back(metric);
        }
    }
    families.insert(families.end(), {connected, samples, faults, warmed});
}

}  // namespace

struct CountersTable::State {
    prometheus::Registry registry;
    prometheus::Family<prometheus::Counter>& requests =
        prometheus::BuildCounter()
            .Name("flared_requests_total")
            .Help("Requests answered, by route and HTTP status; 499: the client left")
            .Register(registry);
    prometheus::Family<prometheus::Histogram>& seconds =
        prometheus::BuildHistogram()
            .Name("flared_request_seconds")
            .Help("Time from the end of a request to its reply, by route")
            .Register(registry);
    prometheus::Family<prometheus::Counter>& rejected =
        prometheus::BuildCounter()
            .Name("flared_requests_rejected_total")
            .Help("Requests turned away for want of room or time, by reason")
            .Register(registry);
};

CountersTable::CountersTable(const std::string& version) : state_(std::make_unique<State>()) {
    prometheus::BuildGauge()
        .Name("flared_build_info")
        .Help("1, with the program's version")
        .Register(state_->registry)
        .Add({{"version", version}})
        .Set(1.0);
    // Reasons that never occurred are shown as 0, so that an alert on them can be written.
    for (const char* reason :
         {"queue_full", "memory", "deadline", "draining", "connections", "slow_client"}) {
        state_->rejected.Add({{"reason", reason}});
    }
}

CountersTable::~CountersTable() = default;

void CountersTable::CountRequest(const std::string& route, int code, double seconds) {
    state_->requests.Add({{"route", route}, {"code", std::to_string(code)}}).Increment();
    state_->seconds.Add({{"route", route}}, kSecondsBuckets).Observe(seconds);
}

void CountersTable::CountRejection(const std::string& reason) {
    state_->rejected.Add({{"reason", reason}}).Increment();
}

std::string CountersTable::Text(const GaugeReadings& readings) const {
    std::vector<MetricFamily> families = state_->registry.Collect();
    SingleFamilies single(families);
    const CacheStats& cache = readings.cache.meshes;
    single.Count("flared_rays_traced_total", "Rays traced through lenses for ghost meshes",
                 readings.cache.rays_traced);
    // As in a picture's report: a ghost that was kept needs no mesh, and no ray was traced.
    const CacheStats& ghosts = readings.cache.ghosts;
    single.Count("flared_mesh_cache_hits_total",
                 "Meshes had from memory, or not needed for a kept ghost",
                 cache.hits + ghosts.hits);
    single.Count("flared_mesh_cache_misses_total", "Meshes read from disk or traced", cache.misses);
    single.Count("flared_mesh_cache_evictions_total", "Meshes dropped to make room",
                 cache.evictions);
    single.Gauge("flared_mesh_cache_bytes", "Bytes of the meshes kept", cache.bytes);
    single.Gauge("flared_mesh_cache_entries", "Meshes kept", cache.entries);
    single.Count("flared_ghost_cache_hits_total", "Ghosts drawn again as they were kept",
                 ghosts.hits);
    single.Count("flared_ghost_cache_misses_total", "Ghosts made from their meshes", ghosts.misses);
    single.Count("flared_ghost_cache_evictions_total", "Ghosts dropped to make room",
                 ghosts.evictions);
    single.Gauge("flared_ghost_cache_bytes", "Bytes of the ghosts kept", ghosts.bytes);
    single.Gauge("flared_ghost_cache_entries", "Ghosts kept", ghosts.entries);
    AddDisk(readings.cache.disk, single);
    AddEncoders(readings.encoders, families);
    single.Gauge("flared_queue_depth", "Requests that wait for a worker", readings.queue_depth);
    single.Gauge("flared_warm_jobs", "Warming that is under way", readings.warm_jobs);
    single.Gauge("flared_connections", "Open connections", readings.connections);
    single.Gauge("flared_draining", "1 while the daemon is going down", readings.draining ? 1 : 0);
    return prometheus::TextSerializer().Serialize(families);
}

}  // namespace flare
