// SPDX-License-Identifier: Apache-2.0
//
// The ghost meshes that outlive the daemon: files in a folder (cache_folder.h, mesh_file.h) that
// one background thread writes. Reading happens in the caller's thread. A file that is torn,
// foreign or another's is removed and counts as not there. A disk that is full or a folder that may
// not be written costs a line in the log, once, and the cache goes on without. Safe from any
// thread.
//
// A mesh's name on disk is its key together with the program's identity (program_identity.h): what
// another build or another machine's arithmetic made is never taken for this one's.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/base/fingerprint.h"
#include "core/mesh/ghost_mesh.h"
#include "server/cache/cache_folder.h"

namespace flare {

struct DiskCacheOptions {
    std::string folder;
    std::uint64_t max_bytes = 0;  // of all files
    Fingerprint identity;
    // Of meshes that wait to be written; what comes when there is no room is not written.
    std::uint64_t queue_bytes = std::uint64_t{256} << 20;
    std::function<void(const std::string&)> log;  // called at most once a kind of trouble
};

// Counts since the start, but for files, file_bytes and queue_bytes, which are now.
struct DiskCacheStats {
    std::uint64_t hits = 0, misses = 0, discarded = 0, read_bytes = 0;
    std::uint64_t writes = 0, written_bytes = 0, dropped = 0, failed = 0;
    std::uint64_t evictions = 0, files = 0, file_bytes = 0, queue_bytes = 0;
};

class DiskCache {
  public:
    explicit DiskCache(DiskCacheOptions options);
    // Writes what waits, but for no longer than kLastWrites.
    ~DiskCache();
    DiskCache(const DiskCache&) = delete;
    DiskCache& operator=(const DiskCache&) = delete;

    static constexpr std::chrono::seconds kLastWrites{2};

    std::optional<GhostMesh> Read(const Fingerprint& key);
    // Returns at once.
    void Write(const Fingerprint& key, std::shared_ptr<const GhostMesh> mesh);
    // More than half of the queue is taken: work that nobody waits for had better wait itself.
    bool crowded() const;
    // Until nothing waits; false if `bound` passed before.
    bool WaitUntilWritten(std::chrono::milliseconds bound);

    DiskCacheStats stats() const;

  private:
    struct Item {
        Fingerprint key;
        std::shared_ptr<const GhostMesh> mesh;
    };

    Fingerprint NameOf(const Fingerprint& key) const;
    void WriteBehind();
    void WriteOne(const Item& item);
    void LogOnce(std::atomic<bool>& logged, const std::string& text) const;

    const DiskCacheOptions options_;
    CacheFolder folder_;
    std::atomic<std::uint64_t> hits_ = 0, misses_ = 0, discarded_ = 0, read_bytes_ = 0;
    std::atomic<std::uint64_t> writes_ = 0, written_bytes_ = 0, dropped_ = 0, failed_ = 0;
    std::atomic<bool> logged_failure_ = false, logged_discard_ = false;

    mutable std::mutex mutex_;  // guards all below
    std::condition_variable changed_;
    std::deque<Item> queue_;
    std::uint64_t queue_bytes_ = 0;  // with the one being written
    bool stop_ = false;
    std::thread writer_;
};

}  // namespace flare
