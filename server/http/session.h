// SPDX-License-Identifier: Apache-2.0
//
// One connection from its first byte to its last. Owns itself: it lives as long as one of its
// asynchronous steps is pending.
#pragma once

#include <atomic>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/strand.hpp>
#include <cstddef>

#include "server/http/message.h"
#include "server/http/server.h"

namespace flare {

using SessionStrand = boost::asio::strand<boost::asio::io_context::executor_type>;
using SessionSocket =
    boost::asio::basic_stream_socket<boost::asio::generic::stream_protocol, SessionStrand>;

// What the sessions of one server share; outlives them.
struct SessionShared {
    const HttpLimits limits;
    HttpHandler& handler;
    std::atomic<bool> close_after_replies = false;
    std::atomic<std::size_t> connections = 0;
    std::atomic<std::size_t> busy = 0;  // from a whole head to the last byte of its reply
};

// Serves the connection. `too_many`: answers 503 to whatever comes and closes.
void StartSession(SessionSocket socket, SessionShared& shared, bool too_many);

}  // namespace flare
