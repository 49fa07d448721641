// SPDX-License-Identifier: Apache-2.0
//
// The daemon's words: replies of each kind, and which HTTP status stands for which error code
// (docs/daemon.md has the table).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "server/http/message.h"
#include "server/schedule/scheduler.h"

namespace flare {

inline constexpr const char* kJson = "application/json";

int StatusFor(std::string_view code);

HttpReply ErrorReply(int status, const Error& error);
HttpReply TextReply(std::string content_type, std::string body);

struct RefusalWords {
    const char* reason;  // in the counters
    Error error;
};
RefusalWords WordsFor(Refusal refusal);

// What is wrong with the head of a request for work with a JSON body, if anything.
std::optional<HttpReply> RefuseWorkHead(const HttpHead& head);
// The same of POST /v1/flare, which must be able to answer in a form that is wanted.
std::optional<HttpReply> RefuseFlareHead(const HttpHead& head);

}  // namespace flare
