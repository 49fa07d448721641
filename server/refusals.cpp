// SPDX-License-Identifier: Apache-2.0
#include "server/refusals.h"

#include <array>
#include <utility>

#include "protocol/codec/json_writer.h"
#include "server/http/text.h"
#include "server/negotiation.h"

namespace flare {
namespace {

struct StatusOfCode {
    std::string_view code;
    int status;
};
// Every other code means that the request was bad.
constexpr std::array kStatuses{
    StatusOfCode{"unknown_lens", 404},  StatusOfCode{"not_found", 404},
    StatusOfCode{"too_large", 413},     StatusOfCode{"deadline", 503},
    StatusOfCode{"overloaded", 503},    StatusOfCode{"draining", 503},
    StatusOfCode{"internal", 500},      StatusOfCode{"unknown_encoder", 404},
    StatusOfCode{"encoder_stale", 503},
};

// Browsers send Origin with what a page makes them post. A page of another origin has no business
// with a daemon on the viewer's machine, and no content type keeps it from trying.
bool FromForeignPage(const HttpFields& fields) {
    const auto origin = FieldValue(fields, "Origin");
    if (!origin) return false;
    const std::string host(FieldValue(fields, "Host").value_or(""));
    return !EqualIgnoringCase(*origin, "http://" + host) &&
           !EqualIgnoringCase(*origin, "https://" + host);
}

}  // namespace

int StatusFor(std::string_view code) {
    for (const StatusOfCode& entry : kStatuses) {
        if (entry.code == code) return entry.status;
    }
    return 400;
}

HttpReply ErrorReply(int status, const Error& error) {
    HttpReply reply;
    reply.status = status;
    reply.content_type = kJson;
    reply.body = wire::EncodeRefusal({error.code, error.message, error.where});
    return reply;
}

HttpReply TextReply(std::string content_type, std::string body) {
    HttpReply reply;
    reply.content_type = std::move(content_type);
    reply.body = std::move(body);
    return reply;
}

RefusalWords WordsFor(Refusal refusal) {
    switch (refusal) {
        case Refusal::kQueueFull:
            return {"queue_full", {"overloaded", "too many requests wait already", ""}};
        case Refusal::kMemory:
            return {"memory",
                    {"overloaded", "the pictures in work leave no room for this one", ""}};
        case Refusal::kTooLarge:
            return {"memory", {"too_large", "a picture of this size never fits this daemon", ""}};
        case Refusal::kDeadline:
            return {"deadline", {"deadline", "the request took longer than it may", ""}};
        case Refusal::kDraining:
            return {"draining", {"draining", "the daemon is going down", ""}};
        case Refusal::kCancelled:
            break;
    }
    return {"", {"cancelled", "the client left", ""}};
}

std::optional<HttpReply> RefuseWorkHead(const HttpHead& head) {
    if (FromForeignPage(head.fields)) {
        return ErrorReply(403, {"forbidden", "a page of another origin may not ask for work", ""});
    }
    const auto type = FieldValue(head.fields, "Content-Type");
    if (!IsJson(type)) {
        return ErrorReply(
            415, {"unsupported_media_type",
                  "the body is to be application/json, not '" + std::string(*type) + "'", ""});
    }
    if (const auto coding = FieldValue(head.fields, "Content-Encoding")) {
        return ErrorReply(415,
                          {"unsupported_media_type",
                           "the body is not to be encoded ('" + std::string(*coding) + "')", ""});
    }
    if (!head.query.empty()) {
        return ErrorReply(400, {"bad_query", head.path + " takes no query", "?"});
    }
    return std::nullopt;
}

std::optional<HttpReply> RefuseFlareHead(const HttpHead& head) {
    if (auto reply = RefuseWorkHead(head)) return reply;
    if (FormatForAccept(FieldValue(head.fields, "Accept"))) return std::nullopt;
    return ErrorReply(
        406, {"not_acceptable", "a picture can be had as " + std::string(kPictureTypes), ""});
}

}  // namespace flare
