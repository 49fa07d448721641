// SPDX-License-Identifier: Apache-2.0
//
// A small blocking HTTP/1.1 client for the daemon: one request, one reply, one connection each
// call. A server is "unix:/path/to/socket" or "http://host:port" (no path, no TLS). Fetch never
// throws and never waits longer than the request's timeouts. Safe from any thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace flare::client {

using Headers = std::vector<std::pair<std::string, std::string>>;

struct Request {
    std::string method = "GET";
    std::string target = "/";  // path and query
    Headers headers{};         // Host and Content-Length are added
    std::string body{};
    std::chrono::seconds connect_timeout{10};
    std::chrono::seconds reply_timeout{600};  // from the end of connecting to the end of the reply
    std::uint64_t max_reply_bytes = std::uint64_t{4} << 30;
};

struct Reply {
    std::string error;  // "" if a whole reply was read, whatever its status; else why there is none
    int status = 0;
    Headers headers;  // names as the server wrote them
    std::string body{};

    bool ok() const { return error.empty(); }
    // The first header of that name, whatever its case; "" if there is none.
    std::string_view header(std::string_view name) const;
};

Reply Fetch(const std::string& server_url, const Request& request);

}  // namespace flare::client
