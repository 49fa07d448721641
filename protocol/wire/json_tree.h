// SPDX-License-Identifier: Apache-2.0
//
// A free-form part of a message as a plain tree: an inline lens prescription, whose meaning the
// wire does not know. Numbers are doubles; an object's keys are unique. Each node knows its JSON
// pointer in the body it came from.
#pragma once

#include <map>
#include <string>
#include <variant>
#include <vector>

namespace flare::wire {

struct JsonTree {
    using Array = std::vector<JsonTree>;
    using Object = std::map<std::string, JsonTree>;

    std::variant<std::monostate, bool, double, std::string, Array, Object> value;
    std::string pointer;

    friend bool operator==(const JsonTree&, const JsonTree&) = default;
};

}  // namespace flare::wire
