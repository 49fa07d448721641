// SPDX-License-Identifier: Apache-2.0
//
// Beast's synchronous calls know no timeouts, so every step is an asynchronous one that is run to
// its end in the caller's thread; the stream's own timer cuts a step that takes too long. One
// stream type over "any stream socket" serves Unix sockets and TCP alike. A server that refuses a
// body early closes while we still write: the reply is read whether or not all was written.
#include "protocol/client/client.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <charconv>
#include <exception>
#include <optional>
#include <system_error>

namespace flare::client {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using AnyStream = net::generic::stream_protocol;
using Stream = beast::basic_stream<AnyStream, net::io_context::executor_type>;
using boost::system::error_code;

constexpr std::string_view kUnixPrefix = "unix:";
constexpr std::string_view kHttpPrefix = "http://";

struct Address {
    std::string unix_path;  // or
    std::string host, port;
    std::string host_header;
};

std::optional<Address> ParseHttpAddress(std::string_view authority) {
    if (authority.ends_with('/')) authority.remove_suffix(1);
    if (authority.find_first_of("/@?# ") != std::string_view::npos) return std::nullopt;
    Address address;
    address.host_header = std::string(authority);
    std::string_view host = authority, port = "80";
    const bool bracketed = authority.starts_with('[');
    const std::size_t close = bracketed ? authority.find(']') : 0;
    if (close == std::string_view::npos) return std::nullopt;
    if (const std::size_t colon = authority.find(':', close); colon != std::string_view::npos) {
        host = authority.substr(0, colon);
        port = authority.substr(colon + 1);
    }
    if (bracketed) {
        if (host.size() != close + 1) return std::nullopt;
        host = host.substr(1, close - 1);
    }
    unsigned number = 0;
    const auto [end, problem] = std::from_chars(port.data(), port.data() + port.size(), number);
    if (host.empty() || problem != std::errc() || end != port.data() + port.size() || number == 0 ||
        number > 65535) {
        return std::nullopt;
    }
    address.host = std::string(host);
    address.port = std::string(port);
    return address;
}

std::optional<Address> ParseAddress(std::string_view url) {
    if (url.starts_with(kUnixPrefix) && url.size() > kUnixPrefix.size()) {
        Address address;
        address.unix_path = std::string(url.substr(kUnixPrefix.size()));
        address.host_header = "localhost";
        return address;
    }
    if (url.starts_with(kHttpPrefix)) return ParseHttpAddress(url.substr(kHttpPrefix.size()));
    return std::nullopt;
}

// Runs one asynchronous step to its end.
template <class Start>
error_code Finish(net::io_context& io, Start start) {
    error_code result = net::error::would_block;
    start([&](error_code code, auto&&...) { result = code; });
    io.restart();
    io.run();
    return result;
}

error_code Connect(net::io_context& io, Stream& stream, const Address& address,
                   std::chrono::seconds timeout) {
    if (!address.unix_path.empty()) {
        const net::local::stream_protocol::endpoint endpoint(address.unix_path);
        stream.expires_after(timeout);
        return Finish(io, [&](auto done) { stream.async_connect(endpoint, done); });
    }
    net::ip::tcp::resolver resolver(io);
    error_code result = net::error::timed_out;
    net::ip::tcp::resolver::results_type found;
    resolver.async_resolve(address.host, address.port, [&](error_code code, auto results) {
        result = code;
        found = std::move(results);
    });
    io.restart();
    io.run_for(timeout);
    resolver.cancel();
    io.restart();
    io.run();
    if (result) return result;
    for (const auto& entry : found) {
        const AnyStream::endpoint endpoint = entry.endpoint();
        stream.expires_after(timeout);
        result = Finish(io, [&](auto done) { stream.async_connect(endpoint, done); });
        if (!result) break;
        error_code ignored;
        stream.socket().close(ignored);
    }
    return result;
}

Reply Exchange(const Address& address, const Request& request) {
    Reply reply;
    net::io_context io(1);
    Stream stream(io);
    if (const error_code code = Connect(io, stream, address, request.connect_timeout)) {
        reply.error = "cannot connect: " + code.message();
        return reply;
    }
    http::request<http::string_body> message;
    message.method_string(request.method);
    message.target(request.target);
    message.version(11);
    message.set(http::field::host, address.host_header);
    message.set(http::field::connection, "close");
    for (const auto& [name, value] : request.headers) message.insert(name, value);
    message.body() = request.body;
    message.prepare_payload();

    stream.expires_after(request.reply_timeout);
    const error_code written =
        Finish(io, [&](auto done) { http::async_write(stream, message, done); });
    if (written == beast::error::timeout) {
        reply.error = "timed out while sending";
        return reply;
    }
    beast::flat_buffer buffer;
    http::response_parser<http::string_body> parser;
    parser.body_limit(request.max_reply_bytes);
    parser.skip(request.method == "HEAD");
    const error_code read =
        Finish(io, [&](auto done) { http::async_read(stream, buffer, parser, done); });
    if (read) {
        const bool timeout = read == beast::error::timeout;
        reply.error = timeout ? "timed out while waiting for the reply"
                              : "cannot read the reply: " + (written ? written : read).message();
        return reply;
    }
    reply.status = static_cast<int>(parser.get().result_int());
    for (const auto& field : parser.get()) {
        reply.headers.emplace_back(field.name_string(), field.value());
    }
    reply.body = std::move(parser.get().body());
    return reply;
}

bool SameName(std::string_view a, std::string_view b) {
    return beast::iequals({a.data(), a.size()}, {b.data(), b.size()});
}

}  // namespace

std::string_view Reply::header(std::string_view name) const {
    for (const auto& [key, value] : headers) {
        if (SameName(key, name)) return value;
    }
    return {};
}

Reply Fetch(const std::string& server_url, const Request& request) {
    Reply failure;
    const std::optional<Address> address = ParseAddress(server_url);
    if (!address) {
        failure.error = "'" + server_url + "' is no server: write unix:/path or http://host:port";
        return failure;
    }
    // Beast and Asio throw for what they cannot represent (a path too long for a Unix socket, a
    // header with a line break) and when memory runs out.
    try {
        Reply reply = Exchange(*address, request);
        if (!reply.ok()) reply.error = server_url + ": " + reply.error;
        return reply;
    } catch (const std::exception& problem) {
        failure.error = server_url + ": " + problem.what();
        return failure;
    }
}

}  // namespace flare::client
