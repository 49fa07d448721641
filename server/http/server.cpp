// SPDX-License-Identifier: Apache-2.0
//
// Two threads run all connections: they only move bytes and read heads. Each listening socket
// accepts in its own chain; an error there (no file descriptors left) is waited out, not spun on.
#include "server/http/server.h"

#include <boost/asio/basic_socket_acceptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <list>
#include <thread>
#include <utility>

#include "core/base/check.h"
#include "server/http/session.h"

namespace flare {
namespace {

namespace net = boost::asio;
using boost::system::error_code;
using Acceptor =
    net::basic_socket_acceptor<net::generic::stream_protocol, net::io_context::executor_type>;

constexpr int kThreads = 2;
constexpr std::chrono::milliseconds kAcceptPause{100};
constexpr std::chrono::milliseconds kQuietPoll{5};

class Listener {
  public:
    Listener(net::io_context& io, ListeningSocket socket, SessionShared& shared)
        : io_(io), socket_(std::move(socket)), acceptor_(io), pause_(io), shared_(shared) {
        sockaddr_storage address{};
        socklen_t size = sizeof(address);
        void* name = &address;
        FLARE_CHECK(getsockname(socket_.fd(), static_cast<sockaddr*>(name), &size) == 0);
        const int copy = dup(socket_.fd());  // the acceptor closes what it is given
        FLARE_CHECK(copy >= 0);
        acceptor_.assign(net::generic::stream_protocol(address.ss_family, 0), copy);
    }

    void Accept() {
        acceptor_.async_accept(net::make_strand(io_),
                               [this](error_code code, SessionSocket socket) {
                                   if (code == net::error::operation_aborted) return;
                                   if (code) return AcceptLater();
                                   const std::size_t open = shared_.connections;
                                   const std::size_t limit = shared_.limits.connections;
                                   // Those over the limit are told so; a flood of them is not even
                                   // told.
                                   if (open < 2 * limit)
                                       StartSession(std::move(socket), shared_, open >= limit);
                                   Accept();
                               });
    }

  private:
    void AcceptLater() {
        pause_.expires_after(kAcceptPause);
        pause_.async_wait([this](error_code code) {
            if (!code) Accept();
        });
    }

    net::io_context& io_;
    ListeningSocket socket_;
    Acceptor acceptor_;
    net::steady_timer pause_;
    SessionShared& shared_;
};

}  // namespace

// Members are destroyed from the last to the first: threads are joined by then, and the context,
// which holds the sessions' pending steps, goes before what the sessions share.
struct HttpServer::State {
    State(const HttpLimits& limits, HttpHandler& handler) : shared{limits, handler} {}

    SessionShared shared;
    net::io_context io{kThreads};
    std::list<Listener> listeners;
    std::vector<std::thread> threads;
};

HttpServer::HttpServer(const HttpLimits& limits, std::vector<ListeningSocket> sockets,
                       HttpHandler& handler)
    : state_(std::make_unique<State>(limits, handler)) {
    for (ListeningSocket& socket : sockets) {
        state_->listeners.emplace_back(state_->io, std::move(socket), state_->shared).Accept();
    }
    for (int i = 0; i < kThreads; ++i) {
        state_->threads.emplace_back([this] {
            const auto keep_running = net::make_work_guard(state_->io);
            state_->io.run();
        });
    }
}

HttpServer::~HttpServer() {
    state_->io.stop();
    for (std::thread& thread : state_->threads) thread.join();
}

void HttpServer::CloseAfterReplies() {
    state_->shared.close_after_replies = true;
}

bool HttpServer::WaitUntilQuiet(std::chrono::milliseconds bound) {
    const auto end = std::chrono::steady_clock::now() + bound;
    while (state_->shared.busy > 0) {
        if (std::chrono::steady_clock::now() >= end) return false;
        std::this_thread::sleep_for(kQuietPoll);
    }
    return true;
}

std::size_t HttpServer::connections() const {
    return state_->shared.connections;
}

}  // namespace flare
