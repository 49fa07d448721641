// SPDX-License-Identifier: Apache-2.0
#include "server/cache/disk_cache.h"

#include <new>
#include <utility>

#include "server/cache/mesh_file.h"

namespace flare {

DiskCache::DiskCache(DiskCacheOptions options)
    : options_(std::move(options)),
      folder_(options_.folder, "mesh", options_.max_bytes),
      writer_([this] { WriteBehind(); }) {}

DiskCache::~DiskCache() {
    WaitUntilWritten(kLastWrites);
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
        dropped_ += queue_.size();
        queue_.clear();
    }
    changed_.notify_all();
    writer_.join();
}

std::optional<GhostMesh> DiskCache::Read(const Fingerprint& key) {
    const Fingerprint name = NameOf(key);
    try {
        const std::optional<std::string> file = folder_.Load(name);
        if (!file) {
            ++misses_;
            return std::nullopt;
        }
        Result<GhostMesh> mesh = DecodeMesh(name, *file);
        if (mesh) {
            ++hits_;
            read_bytes_ += file->size();
            return std::move(*mesh);
        }
        ++discarded_;
        LogOnce(logged_discard_, "a mesh file in " + folder_.path() + " is traced anew: " +
                                     mesh.error().message + "; further ones are only counted");
    } catch (const std::bad_alloc&) {
        ++misses_;
        return std::nullopt;  // the caller may do with less
    }
    ++misses_;
    folder_.Discard(name);
    return std::nullopt;
}

void DiskCache::Write(const Fingerprint& key, std::shared_ptr<const GhostMesh> mesh) {
    const std::uint64_t bytes = mesh->bytes();
    {
        const std::lock_guard lock(mutex_);
        if (queue_bytes_ + bytes > options_.queue_bytes) {
            ++dropped_;
            return;
        }
        queue_bytes_ += bytes;
        queue_.push_back({key, std::move(mesh)});
    }
    changed_.notify_all();
}

bool DiskCache::crowded() const {
    const std::lock_guard lock(mutex_);
    return queue_bytes_ > options_.queue_bytes / 2;
}

bool DiskCache::WaitUntilWritten(std::chrono::milliseconds bound) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, bound, [this] { return queue_bytes_ == 0; });
}

DiskCacheStats DiskCache::stats() const {
    DiskCacheStats stats;
    stats.hits = hits_;
    stats.misses = misses_;
    stats.discarded = discarded_;
    stats.read_bytes = read_bytes_;
    stats.writes = writes_;
    stats.written_bytes = written_bytes_;
    stats.dropped = dropped_;
    stats.failed = failed_;
    const CacheFolderStats folder = folder_.stats();
    stats.evictions = folder.evictions;
    stats.files = folder.entries;
    stats.file_bytes = folder.bytes;
    const std::lock_guard lock(mutex_);
    stats.queue_bytes = queue_bytes_;
    return stats;
}

Fingerprint DiskCache::NameOf(const Fingerprint& key) const {
    return Fingerprinter().Add("mesh on disk").Add(options_.identity).Add(key).value();
}

void DiskCache::WriteBehind() {
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [this] { return stop_ || !queue_.empty(); });
        if (queue_.empty()) return;
        const Item item = std::move(queue_.front());
        queue_.pop_front();
        lock.unlock();
        WriteOne(item);
        lock.lock();
        queue_bytes_ -= item.mesh->bytes();
        changed_.notify_all();
    }
}

void DiskCache::WriteOne(const Item& item) {
    const Fingerprint name = NameOf(item.key);
    try {
        const std::string file = EncodeMesh(name, *item.mesh);
        const std::optional<Error> error = folder_.Store(name, file);
        if (!error) {
            ++writes_;
            written_bytes_ += file.size();
            return;
        }
        ++failed_;
        LogOnce(logged_failure_, "meshes are not kept on disk: " + error->message +
                                     "; further failures are only counted");
    } catch (const std::bad_alloc&) {
        ++failed_;
    }
}

void DiskCache::LogOnce(std::atomic<bool>& logged, const std::string& text) const {
    if (!logged.exchange(true) && options_.log) options_.log(text);
}

}  // namespace flare
