// SPDX-License-Identifier: Apache-2.0
#include "server/cache/cache_folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <random>
#include <system_error>
#include <thread>
#include <vector>

namespace flare {
namespace {

constexpr std::size_t kNameDigits = 32;
constexpr const char* kTemporary = ".part";
constexpr std::int64_t kNsPerSecond = 1'000'000'000;

// Longer than another program needs for its turn. One that was stopped while it held the lock must
// not stop this one for ever; then the bound may be passed by what both write.
constexpr int kLockTries = 200;
constexpr std::chrono::milliseconds kLockPoll{10};

class File {
  public:
    explicit File(int fd) : fd_(fd) {}
    ~File() {
        if (fd_ >= 0) close(fd_);
    }
    File(const File&) = delete;
    File& operator=(const File&) = delete;

    int fd() const { return fd_; }
    explicit operator bool() const { return fd_ >= 0; }

  private:
    int fd_;
};

Error SystemError(const std::string& what, int number) {
    return {"cache_io", what + ": " + std::generic_category().message(number), ""};
}

std::int64_t ModifiedNs(const struct stat& facts) {
    return static_cast<std::int64_t>(facts.st_mtim.tv_sec) * kNsPerSecond + facts.st_mtim.tv_nsec;
}

void SetModified(int fd, std::int64_t ns) {
    timespec time{};
    time.tv_sec = static_cast<time_t>(ns / kNsPerSecond);
    time.tv_nsec = static_cast<long>(ns % kNsPerSecond);
    const std::array times{time, time};
    // A folder that may only be read keeps its old order.
    (void)futimens(fd, times.data());
}

bool WriteAll(int fd, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = write(fd, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return false;
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return true;
}

bool ReadAll(int fd, std::string& bytes) {
    std::size_t at = 0;
    while (at < bytes.size()) {
        const ssize_t got = read(fd, &bytes[at], bytes.size() - at);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        at += static_cast<std::size_t>(got);
    }
    return true;
}

bool TakeLock(int fd) {
    for (int i = 0; i < kLockTries; ++i) {
        if (flock(fd, LOCK_EX | LOCK_NB) == 0) return true;
        if (errno != EWOULDBLOCK && errno != EINTR) return false;
        std::this_thread::sleep_for(kLockPoll);
    }
    return false;
}

// Its writer holds a lock on it as long as it lives.
void RemoveIfLeftBehind(const std::string& temporary) {
    const File file(open(temporary.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
    if (file && flock(file.fd(), LOCK_EX | LOCK_NB) == 0) (void)unlink(temporary.c_str());
}

std::optional<std::uint64_t> HexNumber(std::string_view digits) {
    std::uint64_t number = 0;
    for (const char c : digits) {
        const bool letter = c >= 'a' && c <= 'f';
        if (!letter && (c < '0' || c > '9')) return std::nullopt;
        number = number * 16 + static_cast<std::uint64_t>(letter ? c - 'a' + 10 : c - '0');
    }
    return number;
}

}  // namespace

CacheFolder::CacheFolder(std::string path, std::string suffix, std::uint64_t max_bytes)
    : path_(std::move(path)), suffix_("." + std::move(suffix)), max_bytes_(max_bytes) {
    const std::lock_guard store_lock(store_mutex_);
    LookThrough();
    (void)MakeRoom(0, std::nullopt);  // the bound may have been lowered
}

std::optional<std::string> CacheFolder::Load(const Fingerprint& name) {
    const File file(open(FileOf(name).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
    struct stat facts {};
    if (!file || fstat(file.fd(), &facts) != 0 || !S_ISREG(facts.st_mode)) return std::nullopt;
    std::string bytes;
    // Larger than the whole bound: not ours, and not to be taken into memory.
    if (static_cast<std::uint64_t>(facts.st_size) > max_bytes_) return bytes;
    bytes.resize(static_cast<std::size_t>(facts.st_size));
    if (!ReadAll(file.fd(), bytes)) return std::nullopt;
    const std::lock_guard lock(mutex_);
    const std::int64_t now_ns = NowNs();
    SetModified(file.fd(), now_ns);
    Note(name, {bytes.size(), now_ns});
    return bytes;
}

std::optional<Error> CacheFolder::Store(const Fingerprint& name, std::string_view blob) {
    if (blob.size() > max_bytes_) return Error{"cache_io", "it is larger than the whole cache", ""};
    const std::lock_guard store_lock(store_mutex_);
    std::string temporary;
    const File file(OpenTemporary(name, temporary));
    if (!file) return SystemError("cannot write into " + path_, errno);
    std::int64_t now_ns = 0;
    {
        const std::lock_guard lock(mutex_);
        now_ns = NowNs();
    }
    std::optional<Error> error;
    if (WriteAll(file.fd(), blob)) {
        SetModified(file.fd(), now_ns);
        error = Publish(temporary, name, blob.size(), now_ns);
    } else {
        error = SystemError("cannot write into " + path_, errno);
    }
    if (error) (void)unlink(temporary.c_str());
    return error;
}

// A new file with a lock on it, or -1 and errno.
int CacheFolder::OpenTemporary(const Fingerprint& name, std::string& temporary) {
    constexpr int kFlags = O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC;
    constexpr int kTries = 4;
    int fd = -1;
    for (int i = 0; i < kTries; ++i) {
        temporary = path_ + "/" + name.hex() + "." + std::to_string(getpid()) + "-" +
                    std::to_string(serial_++) + kTemporary;
        fd = open(temporary.c_str(), kFlags, 0600);
        if (fd < 0 && errno == ENOENT && i == 0) {
            MakeFolder();
            continue;
        }
        if (fd < 0 && errno != EEXIST) return -1;
        // Another program may take it for one left behind, before the lock is on it.
        struct stat facts {};
        const bool held = fd >= 0 && (flock(fd, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) &&
                          fstat(fd, &facts) == 0 && facts.st_nlink > 0;
        if (held) return fd;
        if (fd >= 0) close(fd);
        errno = EAGAIN;
    }
    return -1;
}

void CacheFolder::Discard(const Fingerprint& name) {
    (void)unlink(FileOf(name).c_str());
    const std::lock_guard lock(mutex_);
    Forget(name);
}

CacheFolderStats CacheFolder::stats() const {
    const std::lock_guard lock(mutex_);
    return stats_;
}

std::string CacheFolder::FileOf(const Fingerprint& name) const {
    return path_ + "/" + name.hex() + suffix_;
}

std::optional<Fingerprint> CacheFolder::NameOf(std::string_view file) const {
    if (file.size() != kNameDigits + suffix_.size() || !file.ends_with(suffix_))
        return std::nullopt;
    const auto high = HexNumber(file.substr(0, kNameDigits / 2));
    const auto low = HexNumber(file.substr(kNameDigits / 2, kNameDigits / 2));
    if (!high || !low) return std::nullopt;
    return Fingerprint{*high, *low};
}

// Whether it worked shows when something is written.
void CacheFolder::MakeFolder() const {
    std::error_code ignored;
    const std::filesystem::path parent = std::filesystem::path(path_).parent_path();
    std::filesystem::create_directories(parent, ignored);
    (void)mkdir(path_.c_str(), 0700);
}

// Gives a finished temporary its name. Needs store_mutex_.
std::optional<Error> CacheFolder::Publish(const std::string& temporary, const Fingerprint& name,
                                          std::uint64_t bytes, std::int64_t now_ns) {
    const File lock(open((path_ + "/lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
    if (!lock) return SystemError("cannot write into " + path_, errno);
    if (TakeLock(lock.fd())) CatchUp(lock.fd());
    if (std::optional<Error> error = MakeRoom(bytes, name)) return error;
    if (rename(temporary.c_str(), FileOf(name).c_str()) != 0) {
        return SystemError("cannot write into " + path_, errno);
    }
    const std::lock_guard guard(mutex_);
    Note(name, {bytes, now_ns});
    return std::nullopt;
}

// Under the lock: looks through the folder if another program has left its mark, and leaves one
// before anything changes, so that a kill in between makes others look once too often, not too
// seldom.
void CacheFolder::CatchUp(int lock) {
    std::uint64_t mark = 0;
    if (pread(lock, &mark, sizeof(mark), 0) != sizeof(mark)) mark = 0;
    if (mark != mark_ || mark == 0) LookThrough();
    std::random_device random;
    mark_ = (static_cast<std::uint64_t>(random()) << 32U | random()) | 1U;
    if (pwrite(lock, &mark_, sizeof(mark_), 0) != sizeof(mark_)) mark_ = 0;
}

// Makes the index anew and sweeps temporaries of the dead. Needs store_mutex_.
void CacheFolder::LookThrough() {
    std::vector<std::pair<Fingerprint, Entry>> found;
    DIR* const directory = opendir(path_.c_str());
    if (directory) {
        while (const dirent* const item = readdir(directory)) {
            const std::string_view file = item->d_name;
            if (file.ends_with(kTemporary) && file.size() > kNameDigits &&
                HexNumber(file.substr(0, kNameDigits / 2))) {
                RemoveIfLeftBehind(path_ + "/" + std::string(file));
                continue;
            }
            const std::optional<Fingerprint> name = NameOf(file);
            struct stat facts {};
            if (!name ||
                fstatat(dirfd(directory), item->d_name, &facts, AT_SYMLINK_NOFOLLOW) != 0 ||
                !S_ISREG(facts.st_mode)) {
                continue;
            }
            found.push_back(
                {*name, {static_cast<std::uint64_t>(facts.st_size), ModifiedNs(facts)}});
        }
        closedir(directory);
    }
    const std::lock_guard lock(mutex_);
    entries_.clear();
    order_.clear();
    stats_.bytes = stats_.entries = 0;
    for (const auto& [name, entry] : found) Note(name, entry);
}

// Removes the oldest until there is room for `bytes` more, in place of what `name` has. Needs
// store_mutex_.
std::optional<Error> CacheFolder::MakeRoom(std::uint64_t bytes,
                                           const std::optional<Fingerprint>& name) {
    const std::lock_guard lock(mutex_);
    const auto replaced = name ? entries_.find(*name) : entries_.end();
    const std::uint64_t gone = replaced == entries_.end() ? 0 : replaced->second.bytes;
    while (stats_.bytes - gone + bytes > max_bytes_) {
        auto oldest = order_.begin();
        if (oldest->second == name) ++oldest;  // it is replaced in any case
        const auto [used_ns, victim] = *oldest;
        const std::string file = FileOf(victim);
        struct stat facts {};
        if (stat(file.c_str(), &facts) == 0 && ModifiedNs(facts) > used_ns) {
            // Another program has read it meanwhile.
            Note(victim, {static_cast<std::uint64_t>(facts.st_size), ModifiedNs(facts)});
            continue;
        }
        if (unlink(file.c_str()) != 0 && errno != ENOENT) {
            return SystemError("cannot remove " + file, errno);
        }
        Forget(victim);
        ++stats_.evictions;
    }
    return std::nullopt;
}

// Later than any time it gave before.
std::int64_t CacheFolder::NowNs() {
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);
    const std::int64_t ns = static_cast<std::int64_t>(now.tv_sec) * kNsPerSecond + now.tv_nsec;
    last_ns_ = std::max(last_ns_ + 1, ns);
    return last_ns_;
}

void CacheFolder::Note(const Fingerprint& name, Entry entry) {
    Forget(name);
    entries_[name] = entry;
    order_.emplace(entry.used_ns, name);
    stats_.bytes += entry.bytes;
    stats_.entries = entries_.size();
}

void CacheFolder::Forget(const Fingerprint& name) {
    const auto known = entries_.find(name);
    if (known == entries_.end()) return;
    order_.erase({known->second.used_ns, name});
    stats_.bytes -= known->second.bytes;
    entries_.erase(known);
    stats_.entries = entries_.size();
}

}  // namespace flare
