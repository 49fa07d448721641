// SPDX-License-Identifier: Apache-2.0
//
// Which lens, how coated and in which state: what requests and rays to trace have in common. Plain
// values, finite and inside protocol/limits.h.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "protocol/wire/json_tree.h"

namespace flare::wire {

// The coatings that lie on the lens in place of its own; as it stands: the lens's own.
struct Coatings {
    bool none = false;  // "coatings": "none": every surface bare, and no other member is set
    std::optional<std::string> default_name;  // on every surface between air and glass
    std::map<int, std::string> surfaces;      // and on single ones, by number

    // Where default_name was written, for messages: "/coatings" or "/coatings/default". Not part of
    // what is asked for.
    std::string default_where;

    bool own() const { return !none && !default_name && surfaces.empty(); }
};

// Exactly one of name and prescription is there, or, in a request with an encoder, perhaps none.
struct LensChoice {
    std::optional<std::string> name;  // of the library
    std::optional<JsonTree> prescription;
    Coatings coatings;
    std::optional<double> f_number;  // absent: the lens's own
    std::optional<double> focus_m;   // from the sensor; absent: infinity
    std::optional<double> zoom_mm;   // absent: as the lens file has it
};

}  // namespace flare::wire
