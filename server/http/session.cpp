// SPDX-License-Identifier: Apache-2.0
//
// A chain of steps on one strand: wait for a byte, read a head, read its body, let the handler
// work, write the reply, and again. Only one step is ever pending, so pipelined requests wait in
// the buffer or in the kernel until their turn.
//
// While the handler works nothing is read. A timer asks the kernel instead whether the peer has
// closed (POLLRDHUP): that sees a client leave even behind bytes that it pipelined, takes no bytes
// away from the next head, and needs no read that would have to be called off.
//
// A connection that is closed with bytes unread would be reset, and the reset can overtake the
// reply. So after the last reply the sending side is shut down and what still comes is thrown away,
// for a bounded time.
#include "server/http/session.h"

#include <poll.h>

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "server/http/text.h"

namespace flare {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using boost::system::error_code;

constexpr std::chrono::milliseconds kClientPoll{25};
constexpr std::chrono::seconds kLinger{2};
constexpr std::size_t kReadBytes = 65'536;

HttpHead HeadOf(const http::request<http::string_body>& message) {
    HttpHead head;
    head.method = message.method_string();
    const std::string target(message.target());
    const std::size_t mark = target.find('?');
    head.path = target.substr(0, mark);
    if (mark != std::string::npos) head.query = target.substr(mark + 1);
    for (const auto& field : message) {
        head.fields.emplace_back(field.name_string(), field.value());
    }
    return head;
}

// A line break in a header would let a value write headers of its own.
std::string OneLine(std::string text) {
    for (char& c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x20 || byte == 0x7F) c = ' ';
    }
    return text;
}

class Session : public std::enable_shared_from_this<Session> {
  public:
    Session(SessionSocket socket, SessionShared& shared)
        : shared_(shared), stream_(std::move(socket)), timer_(stream_.get_executor()) {
        ++shared_.connections;
    }
    ~Session() {
        SetBusy(false);
        --shared_.connections;
    }

    void Start(bool too_many) {
        net::dispatch(stream_.get_executor(), [self = shared_from_this(), too_many] {
            if (too_many) {
                self->FailTransport(503, {"overloaded", "too many connections are open", ""});
            } else {
                self->AwaitRequest();
            }
        });
    }

  private:
    // Waits for the first byte of a request; a silent client may do nothing wrong for a while.
    void AwaitRequest() {
        SetBusy(false);
        parser_.emplace();
        parser_->header_limit(static_cast<std::uint32_t>(shared_.limits.header_bytes));
        parser_->body_limit(shared_.limits.body_bytes);
        if (buffer_.size() > 0) return ReadHead();
        stream_.expires_after(shared_.limits.idle);
        stream_.async_read_some(buffer_.prepare(kReadBytes),
                                [self = shared_from_this()](error_code code, std::size_t bytes) {
                                    if (code) return;  // idle for too long, or the client is done
                                    self->buffer_.commit(bytes);
                                    self->ReadHead();
                                });
    }

    void ReadHead() {
        stream_.expires_after(shared_.limits.header);
        http::async_read_header(stream_, buffer_, *parser_,
                                [self = shared_from_this()](error_code code, std::size_t) {
                                    if (code) return self->FailRead(code);
                                    self->OnHead();
                                });
    }

    void OnHead() {
        SetBusy(true);
        const auto& message = parser_->get();
        request_ = {};
        request_.head = HeadOf(message);
        version_ = message.version();
        keep_alive_ = message.keep_alive();
        head_only_ = message.method() == http::verb::head;
        if (std::optional<HttpReply> reply = RefuseGrammar()) return WriteLast(std::move(*reply));
        if (std::optional<HttpReply> reply = shared_.handler.Refuse(request_.head)) {
            // A body that is on its way is not read, so nothing after it can be.
            if (!parser_->is_done()) return WriteLast(std::move(*reply));
            return Write(std::move(*reply));
        }
        if (!parser_->is_done() && FieldValue(request_.head.fields, "Expect")) return Continue();
        ReadBody();
    }

    // What Beast's parser lets through and this server does not serve.
    std::optional<HttpReply> RefuseGrammar() {
        const HttpFields& fields = request_.head.fields;
        const auto refuse = [&](int status, const char* code, const char* message) {
            return shared_.handler.TransportError(status, {code, message, ""});
        };
        if (parser_->get().target().size() > shared_.limits.target_bytes) {
            return refuse(414, "target_too_long", "the request target is too long");
        }
        if (version_ != 10 && version_ != 11) {
            return refuse(505, "bad_http", "only HTTP/1.0 and HTTP/1.1 are served");
        }
        if (version_ == 11 && !FieldValue(fields, "Host")) {
            return refuse(400, "bad_http", "an HTTP/1.1 request needs a Host field");
        }
        const auto coding = FieldValue(fields, "Transfer-Encoding");
        if (coding && !EqualIgnoringCase(TrimSpace(*coding), "chunked")) {
            return refuse(501, "unsupported", "the only transfer coding served is chunked");
        }
        const auto expect = FieldValue(fields, "Expect");
        if (expect && !EqualIgnoringCase(TrimSpace(*expect), "100-continue")) {
            return refuse(417, "bad_http", "the only expectation served is 100-continue");
        }
        return std::nullopt;
    }

    void Continue() {
        continue_.emplace(http::status::continue_, version_);
        stream_.expires_after(shared_.limits.header);
        http::async_write(stream_, *continue_,
                          [self = shared_from_this()](error_code code, std::size_t) {
                              if (!code) self->ReadBody();
                          });
    }

    void ReadBody() {
        stream_.expires_after(shared_.limits.body);
        http::async_read(stream_, buffer_, *parser_,
                         [self = shared_from_this()](error_code code, std::size_t) {
                             if (code) return self->FailRead(code);
                             self->Handle();
                         });
    }

    void Handle() {
        stream_.expires_never();
        request_.body = std::move(parser_->get().body());
        request_.cancel = cancel_ = CancelToken();
        handling_ = true;
        WatchClient();
        shared_.handler.Handle(
            std::move(request_), [self = shared_from_this()](std::optional<HttpReply> reply) {
                net::post(self->stream_.get_executor(), [self, reply = std::move(reply)]() mutable {
                    self->OnHandled(std::move(reply));
                });
            });
    }

    void WatchClient() {
        timer_.expires_after(kClientPoll);
        timer_.async_wait([self = shared_from_this()](error_code code) {
            if (code || !self->handling_) return;
            if (self->ClientLeft()) return self->cancel_.Cancel();
            self->WatchClient();
        });
    }

    bool ClientLeft() {
        pollfd watched{stream_.socket().native_handle(), POLLRDHUP, 0};
        return poll(&watched, 1, 0) > 0 &&
               (watched.revents & (POLLRDHUP | POLLHUP | POLLERR | POLLNVAL)) != 0;
    }

    void OnHandled(std::optional<HttpReply> reply) {
        handling_ = false;
        timer_.cancel();
        if (!reply) return;
        Write(std::move(*reply));
    }

    void FailRead(error_code code) {
        if (code == beast::error::timeout) return shared_.handler.ClientTooSlow();
        if (code == http::error::end_of_stream) return;
        if (code == http::error::body_limit) {
            return FailTransport(413, {"too_large",
                                       "the body is larger than " +
                                           std::to_string(shared_.limits.body_bytes) + " bytes",
                                       ""});
        }
        if (code == http::error::header_limit || code == http::error::buffer_overflow) {
            return FailTransport(431, {"head_too_large", "the request's head is too large", ""});
        }
        if (code == http::error::partial_message) {
            return FailTransport(400, {"bad_http", "the request ends before its length", ""});
        }
        const error_code any_http_error = http::error::bad_method;
        if (code.category() != any_http_error.category()) return;  // the connection broke
        FailTransport(400, {"bad_http", "no HTTP request: " + code.message(), ""});
    }

    void FailTransport(int status, const Error& error) {
        SetBusy(true);
        WriteLast(shared_.handler.TransportError(status, error));
    }

    void WriteLast(HttpReply reply) {
        keep_alive_ = false;
        Write(std::move(reply));
    }

    void Write(HttpReply reply) {
        if (shared_.close_after_replies) keep_alive_ = false;
        http::response<http::string_body>& message = response_.emplace();
        message.result(static_cast<unsigned>(reply.status));
        message.version(version_);
        message.set(http::field::server, "flared");
        if (!reply.content_type.empty()) {
            message.set(http::field::content_type, reply.content_type);
        }
        for (const auto& [name, value] : reply.fields) message.set(name, OneLine(value));
        message.keep_alive(keep_alive_);
        message.body() = std::move(reply.body);
        spare_ = std::move(reply.spare);
        message.prepare_payload();
        serializer_.emplace(message);
        stream_.expires_after(shared_.limits.reply +
                              std::chrono::seconds(message.body().size() >> 20));
        const auto written = [self = shared_from_this()](error_code code, std::size_t) {
            self->OnWritten(code);
        };
        if (head_only_) {
            http::async_write_header(stream_, *serializer_, written);
        } else {
            http::async_write(stream_, *serializer_, written);
        }
    }

    void OnWritten(error_code code) {
        serializer_.reset();
        if (spare_) spare_->Keep(std::move(response_->body()));
        spare_.reset();
        response_.reset();
        if (code == beast::error::timeout) shared_.handler.ClientTooSlow();
        if (code) return;
        if (keep_alive_) return AwaitRequest();
        SetBusy(false);
        error_code ignored;
        stream_.socket().shutdown(net::socket_base::shutdown_send, ignored);
        stream_.expires_after(kLinger);
        Linger();
    }

    // The expiry stands for all of it, however long the client keeps sending.
    void Linger() {
        buffer_.clear();
        stream_.async_read_some(buffer_.prepare(kReadBytes),
                                [self = shared_from_this()](error_code code, std::size_t) {
                                    if (!code) self->Linger();
                                });
    }

    void SetBusy(bool busy) {
        if (busy == busy_) return;
        busy_ = busy;
        if (busy) {
            ++shared_.busy;
        } else {
            --shared_.busy;
        }
    }

    SessionShared& shared_;
    beast::basic_stream<net::generic::stream_protocol, SessionStrand> stream_;
    net::steady_timer timer_;
    beast::flat_buffer buffer_;
    std::optional<http::request_parser<http::string_body>> parser_;
    std::optional<http::response<http::empty_body>> continue_;
    std::optional<http::response<http::string_body>> response_;
    std::optional<http::response_serializer<http::string_body>> serializer_;
    std::shared_ptr<SpareBytes> spare_;  // of the reply that is being written
    HttpRequest request_;
    CancelToken cancel_;
    unsigned version_ = 11;
    bool keep_alive_ = false;
    bool head_only_ = false;
    bool handling_ = false;
    bool busy_ = false;
};

}  // namespace

void StartSession(SessionSocket socket, SessionShared& shared, bool too_many) {
    std::make_shared<Session>(std::move(socket), shared)->Start(too_many);
}

}  // namespace flare
