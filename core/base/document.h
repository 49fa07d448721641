// SPDX-License-Identifier: Apache-2.0
//
// A parsed text document (TOML, JSON, ...) as one plain tree, so that the meaning of a lens file is
// read by one function whatever syntax it came in. Each node knows where it stood in the text, in
// the words of its syntax: "line 12, column 3" for TOML, "/surface/3/radius_mm" for JSON.
#pragma once

#include <map>
#include <string>
#include <variant>
#include <vector>

namespace flare {

struct DocumentNode {
    using Table = std::map<std::string, DocumentNode>;
    using Array = std::vector<DocumentNode>;

    std::variant<std::monostate, bool, double, std::string, Array, Table> value;
    std::string where;

    const Table* table() const { return std::get_if<Table>(&value); }
    const Array* array() const { return std::get_if<Array>(&value); }
    const std::string* string() const { return std::get_if<std::string>(&value); }
    const double* number() const { return std::get_if<double>(&value); }
    const bool* boolean() const { return std::get_if<bool>(&value); }
};

}  // namespace flare
