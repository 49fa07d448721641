// SPDX-License-Identifier: Apache-2.0
//
// What the service says when it refuses a request: the "error" object of a reply.
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace flare::wire {

// code     a stable word for programs; protocol/openapi.yaml lists them
// message  one sentence for people
// where    a JSON pointer, "" for the whole body, "byte N" for a syntax error
struct Refusal {
    std::string code;
    std::string message;
    std::string where;

    friend bool operator==(const Refusal&, const Refusal&) = default;
};

// A decoded T, or why it was refused.
template <class T>
using Decoded = std::variant<T, Refusal>;

template <class T>
const Refusal* RefusalOf(const Decoded<T>& decoded) {
    return std::get_if<Refusal>(&decoded);
}

}  // namespace flare::wire
