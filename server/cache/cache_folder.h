// SPDX-License-Identifier: Apache-2.0
//
// A folder of named blobs, bounded in bytes, that outlives the program and that several programs
// may share. The least recently used go first, by the files' modification times, which reading
// renews. A blob is there whole or not at all as long as the machine runs, whenever a program is
// killed: it is written to a temporary file of the same folder and renamed. Nothing is synchronised
// to the medium: after a loss of power a file may be torn, and callers check what they read.
//
// The files are NAME.SUFFIX with a name of 32 hex digits, "lock", and temporaries; a file of any
// other name is left alone. All programs together keep at most `max_bytes` of blobs, and each may
// have one temporary besides: before it renames, a program takes the lock and finds out from a mark
// in it whether another one has changed the folder since; then it looks through the folder again.
// A temporary that nobody holds open any more is what a killed program left, and goes.
//
// Safe from any thread. Errors have the code "cache_io" and the system's words; none is thrown.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "core/base/fingerprint.h"
#include "core/base/result.h"

namespace flare {

struct CacheFolderStats {
    std::uint64_t evictions = 0;           // by this program, since its start
    std::uint64_t bytes = 0, entries = 0;  // as far as this program knows
};

class CacheFolder {
  public:
    // Looks through the folder, if it is there; makes none before something is stored.
    CacheFolder(std::string path, std::string suffix, std::uint64_t max_bytes);

    // The blob, or nothing if it is not there or cannot be read.
    std::optional<std::string> Load(const Fingerprint& name);
    // The empty optional: it was stored.
    std::optional<Error> Store(const Fingerprint& name, std::string_view blob);
    void Discard(const Fingerprint& name);

    CacheFolderStats stats() const;
    const std::string& path() const { return path_; }

  private:
    struct Entry {
        std::uint64_t bytes = 0;
        std::int64_t used_ns = 0;  // the file's modification time
    };
    using Use = std::pair<std::int64_t, Fingerprint>;

    std::string FileOf(const Fingerprint& name) const;
    std::optional<Fingerprint> NameOf(std::string_view file) const;
    void MakeFolder() const;
    int OpenTemporary(const Fingerprint& name, std::string& temporary);
    std::optional<Error> Publish(const std::string& temporary, const Fingerprint& name,
                                 std::uint64_t bytes, std::int64_t now_ns);
    void LookThrough();
    void CatchUp(int lock);
    std::optional<Error> MakeRoom(std::uint64_t bytes, const std::optional<Fingerprint>& name);
    std::int64_t NowNs();
    void Note(const Fingerprint& name, Entry entry);
    void Forget(const Fingerprint& name);

    const std::string path_, suffix_;
    const std::uint64_t max_bytes_;

    std::mutex store_mutex_;    // one Store at a time; taken before mutex_
    std::uint64_t mark_ = 0;    // in the lock file, when the index was true
    std::uint64_t serial_ = 0;  // of temporaries

    mutable std::mutex mutex_;  // guards all below
    std::unordered_map<Fingerprint, Entry> entries_;
    std::set<Use> order_;  // oldest first
    CacheFolderStats stats_;
    std::int64_t last_ns_ = 0;
};

}  // namespace flare
