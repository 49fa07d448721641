// SPDX-License-Identifier: Apache-2.0
//
// HTTP/1.1 over the given listening sockets: keep-alive, pipelining (in order, one request of a
// connection at a time), chunked bodies, Expect: 100-continue, HEAD (the handler answers as for GET
// and the body is left out). Limits on sizes, times and connections hold for every client. A client
// that goes away while its request is handled has the request's token cancelled; a client that
// closes its sending side counts as gone. Runs its own threads from construction on.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <vector>

#include "server/http/listening_socket.h"
#include "server/http/message.h"

namespace flare {

struct HttpLimits {
    std::size_t header_bytes = 16'384;
    std::size_t target_bytes = 2'048;
    std::size_t body_bytes = std::size_t{16} << 20;
    std::size_t connections = 256;
    std::chrono::milliseconds idle{60'000};    // between requests of a connection
    std::chrono::milliseconds header{10'000};  // from the first byte of a head to its last
    std::chrono::milliseconds body{60'000};    // of a whole body
    // A reply may take this long, and a second more for every MiB it has.
    std::chrono::milliseconds reply{30'000};
};

class HttpServer {
  public:
    // The handler must outlive the server.
    HttpServer(const HttpLimits& limits, std::vector<ListeningSocket> sockets,
               HttpHandler& handler);
    ~HttpServer();  // closes every connection
    HttpServer(const HttpServer&) = delete;
    HttpServer& operator=(const HttpServer&) = delete;

    // From now on every reply closes its connection.
    void CloseAfterReplies();
    // Waits until no request is being handled and no reply being written; false after `bound`.
    bool WaitUntilQuiet(std::chrono::milliseconds bound);

    std::size_t connections() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace flare
