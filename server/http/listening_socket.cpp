// SPDX-License-Identifier: Apache-2.0
//
// Plain POSIX, so that what happens to the file of a Unix socket is to be seen in one place: it is
// replaced only after a connection to it was refused, made with its final permissions, and removed
// only while it is still the inode that was bound.
#include "server/http/listening_socket.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

namespace flare {
namespace {

constexpr int kBacklog = 128;

Error SystemError(const std::string& what) {
    return {"cannot_listen", what + ": " + std::generic_category().message(errno), ""};
}

Error BadAddress(const std::string& message) {
    return {"bad_address", message, ""};
}

const sockaddr* Generic(const void* address) {
    return static_cast<const sockaddr*>(address);
}

std::optional<sockaddr_un> UnixAddress(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.size() >= sizeof(address.sun_path)) return std::nullopt;
    std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
    return address;
}

// Somebody accepts connections there, or did not refuse one.
bool SomebodyListens(const sockaddr_un& address) {
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0) return true;
    const bool refused =
        connect(fd, Generic(&address), sizeof(address)) != 0 && errno == ECONNREFUSED;
    close(fd);
    return !refused;
}

// Makes room for a new socket file. The empty optional says that the path is free.
std::optional<Error> RemoveStaleSocket(const std::string& path, const sockaddr_un& address) {
    struct stat status {};
    if (lstat(path.c_str(), &status) != 0) {
        if (errno == ENOENT) return std::nullopt;
        return SystemError(path);
    }
    if (!S_ISSOCK(status.st_mode)) {
        return Error{"cannot_listen", path + " exists and is no socket", ""};
    }
    if (SomebodyListens(address)) {
        return Error{"cannot_listen", "another program listens on " + path, ""};
    }
    if (unlink(path.c_str()) != 0) return SystemError("cannot remove the stale socket " + path);
    return std::nullopt;
}

struct HostPort {
    std::string host;
    std::uint16_t port = 0;
};

std::optional<HostPort> SplitAuthority(std::string_view authority) {
    if (authority.ends_with('/')) authority.remove_suffix(1);
    const std::size_t colon = authority.rfind(':');
    if (colon == std::string_view::npos) return std::nullopt;
    const std::string_view digits = authority.substr(colon + 1);
    HostPort result;
    const auto [end, problem] =
        std::from_chars(digits.data(), digits.data() + digits.size(), result.port);
    if (problem != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
    std::string_view host = authority.substr(0, colon);
    if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
    result.host = host == "localhost" ? "127.0.0.1" : std::string(host);
    return result;
}

std::string UrlOf(const sockaddr_storage& address) {
    char text[INET6_ADDRSTRLEN] = {};
    if (address.ss_family == AF_INET) {
        sockaddr_in v4{};
        std::memcpy(&v4, &address, sizeof(v4));
        inet_ntop(AF_INET, &v4.sin_addr, text, sizeof(text));
        return "http://" + std::string(text) + ":" + std::to_string(ntohs(v4.sin_port));
    }
    sockaddr_in6 v6{};
    std::memcpy(&v6, &address, sizeof(v6));
    inet_ntop(AF_INET6, &v6.sin6_addr, text, sizeof(text));
    return "http://[" + std::string(text) + "]:" + std::to_string(ntohs(v6.sin6_port));
}

struct TcpAddress {
    sockaddr_storage storage{};
    socklen_t size = 0;
    bool loopback = false;
};

std::optional<TcpAddress> ResolveTcp(const HostPort& where) {
    TcpAddress result;
    sockaddr_in v4{};
    if (inet_pton(AF_INET, where.host.c_str(), &v4.sin_addr) == 1) {
        v4.sin_family = AF_INET;
        v4.sin_port = htons(where.port);
        std::memcpy(&result.storage, &v4, sizeof(v4));
        result.size = sizeof(v4);
        result.loopback = (ntohl(v4.sin_addr.s_addr) >> 24) == 127;
        return result;
    }
    sockaddr_in6 v6{};
    if (inet_pton(AF_INET6, where.host.c_str(), &v6.sin6_addr) != 1) return std::nullopt;
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(where.port);
    std::memcpy(&result.storage, &v6, sizeof(v6));
    result.size = sizeof(v6);
    result.loopback = IN6_IS_ADDR_LOOPBACK(&v6.sin6_addr);
    return result;
}

}  // namespace

Result<ListeningSocket> ListeningSocket::Open(const std::string& url, const Options& options) {
    if (url.starts_with("unix:")) return OpenUnix(url.substr(5), options.socket_mode);
    if (url.starts_with("http://")) return OpenTcp(url.substr(7), options.allow_remote);
    return BadAddress("'" + url + "' is no address: write unix:/path or http://127.0.0.1:PORT");
}

Result<ListeningSocket> ListeningSocket::OpenUnix(const std::string& path, unsigned mode) {
    if (path.empty()) return BadAddress("unix: needs a path");
    const std::optional<sockaddr_un> address = UnixAddress(path);
    if (!address) return BadAddress("the socket path '" + path + "' is longer than 107 bytes");
    ListeningSocket result;
    result.fd_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (result.fd_ < 0) return SystemError("cannot make a socket");
    if (std::optional<Error> problem = RemoveStaleSocket(path, *address)) return *problem;
    // The file must never be open to more users than it should be, not even for a moment.
    const mode_t old_mask = umask(static_cast<mode_t>(~mode & 0777U));
    const int bound = bind(result.fd_, Generic(&*address), sizeof(*address));
    umask(old_mask);
    if (bound != 0) return SystemError("cannot bind " + path);
    struct stat status {};
    if (lstat(path.c_str(), &status) != 0) return SystemError(path);
    result.path_ = path;
    result.device_ = status.st_dev;
    result.inode_ = status.st_ino;
    result.url_ = "unix:" + path;
    if (listen(result.fd_, kBacklog) != 0) return SystemError("cannot listen on " + path);
    return result;
}

Result<ListeningSocket> ListeningSocket::OpenTcp(const std::string& authority, bool allow_remote) {
    const std::optional<HostPort> where = SplitAuthority(authority);
    const std::optional<TcpAddress> address = where ? ResolveTcp(*where) : std::nullopt;
    if (!address) {
        return BadAddress("'http://" + authority + "' is no address: write http://IP:PORT");
    }
    if (!address->loopback && !allow_remote) {
        return BadAddress("http://" + authority +
                          " is open to other machines; set allow_remote = true to mean it");
    }
    ListeningSocket result;
    result.fd_ = socket(address->storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (result.fd_ < 0) return SystemError("cannot make a socket");
    const int on = 1;
    setsockopt(result.fd_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
    if (bind(result.fd_, Generic(&address->storage), address->size) != 0) {
        return SystemError("cannot bind http://" + authority);
    }
    if (listen(result.fd_, kBacklog) != 0) return SystemError("cannot listen on " + authority);
    sockaddr_storage chosen{};
    socklen_t size = sizeof(chosen);
    void* name = &chosen;
    if (getsockname(result.fd_, static_cast<sockaddr*>(name), &size) != 0) {
        return SystemError("cannot ask for the port");
    }
    result.url_ = UrlOf(chosen);
    return result;
}

ListeningSocket::ListeningSocket(ListeningSocket&& other) noexcept {
    *this = std::move(other);
}

ListeningSocket& ListeningSocket::operator=(ListeningSocket&& other) noexcept {
    std::swap(fd_, other.fd_);
    std::swap(url_, other.url_);
    std::swap(path_, other.path_);
    std::swap(device_, other.device_);
    std::swap(inode_, other.inode_);
    return *this;
}

ListeningSocket::~ListeningSocket() {
    if (!path_.empty()) {
        struct stat status {};
        if (lstat(path_.c_str(), &status) == 0 && status.st_dev == device_ &&
            status.st_ino == inode_) {
            unlink(path_.c_str());
        }
    }
    if (fd_ >= 0) close(fd_);
}

}  // namespace flare
