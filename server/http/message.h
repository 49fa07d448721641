// SPDX-License-Identifier: Apache-2.0
//
// An HTTP exchange as plain values, and the one interface between the transport (HttpServer, which
// knows sockets and the grammar of HTTP) and what is served (HttpHandler, which knows neither).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/result.h"
#include "core/base/spare_bytes.h"

namespace flare {

using HttpFields = std::vector<std::pair<std::string, std::string>>;

// The value of the first field of that name, whatever its case; nullopt if there is none.
std::optional<std::string_view> FieldValue(const HttpFields& fields, std::string_view name);

// A request without its body.
struct HttpHead {
    std::string method;
    std::string path;   // of the target, as sent, before the '?'
    std::string query;  // after it
    HttpFields fields;
};

struct HttpRequest {
    HttpHead head;
    std::string body;
    CancelToken cancel;  // set when the client has left
};

struct HttpReply {
    int status = 200;
    std::string content_type;
    HttpFields fields;
    std::string body;
    std::shared_ptr<SpareBytes> spare = nullptr;  // takes the body when it was written, or nobody
};

// Called on the transport's threads, several at once: must not block.
class HttpHandler {
  public:
    // Takes the reply, or nothing if the client has left and no reply is to be written. To be
    // called once, from any thread.
    using Done = std::function<void(std::optional<HttpReply>)>;

    virtual ~HttpHandler() = default;

    // A look at the head before the body is read. A reply here refuses the request: its body is
    // never read and the connection is closed.
    virtual std::optional<HttpReply> Refuse(const HttpHead& head) = 0;

    virtual void Handle(HttpRequest request, Done done) = 0;

    // The reply to what is no proper HTTP request or breaks the transport's limits.
    virtual HttpReply TransportError(int status, const Error& error) = 0;

    // A connection was closed without a reply because its client was too slow.
    virtual void ClientTooSlow() = 0;
};

}  // namespace flare
