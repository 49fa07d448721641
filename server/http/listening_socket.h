// SPDX-License-Identifier: Apache-2.0
//
// A socket that listens at "unix:/path" or "http://HOST:PORT" (HOST an IP address or localhost,
// port 0 for any free one). A Unix socket file that nobody listens on any more is replaced; one
// that is in use, or a file that is no socket, is an error. The file is removed at destruction if
// it is still the one that was made.
#pragma once

#include <sys/types.h>

#include <string>

#include "core/base/result.h"

namespace flare {

class ListeningSocket {
  public:
    struct Options {
        bool allow_remote = false;    // addresses other than loopback
        unsigned socket_mode = 0600;  // of a Unix socket's file
    };

    // Error code "bad_address" for what can never work, "cannot_listen" for what the system
    // refused.
    static Result<ListeningSocket> Open(const std::string& url, const Options& options);

    ~ListeningSocket();
    ListeningSocket(ListeningSocket&& other) noexcept;
    ListeningSocket& operator=(ListeningSocket&& other) noexcept;

    int fd() const { return fd_; }
    const std::string& url() const { return url_; }  // with the port that was chosen
    bool is_unix() const { return !path_.empty(); }

  private:
    ListeningSocket() = default;
    static Result<ListeningSocket> OpenUnix(const std::string& path, unsigned mode);
    static Result<ListeningSocket> OpenTcp(const std::string& authority, bool allow_remote);

    int fd_ = -1;
    std::string url_;
    std::string path_;
    dev_t device_ = 0;
    ino_t inode_ = 0;
};

}  // namespace flare
