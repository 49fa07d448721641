// SPDX-License-Identifier: Apache-2.0
//
// Reads the fields of one table of a document into variables and keeps the first error. Used by the
// readers of lens files and coating files; private to this layer.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/document.h"
#include "core/base/result.h"

namespace flare {

inline const char* TypeNameOf(const DocumentNode& node) {
    static constexpr std::array<const char*, 6> kNames = {
        "null, a date or a time", "a boolean", "a number", "a string", "an array", "a table"};
    return kNames[node.value.index()];
}

// Reads the fields of one table into variables and keeps the first error.
class Fields {
  public:
    // `owner` names the table in messages: "the lens", "surface 3".
    Fields(const DocumentNode& node, std::string owner) : node_(node), owner_(std::move(owner)) {
        if (node.table() == nullptr) {
            Fail(owner_ + " must be a table, not " + TypeNameOf(node), node.where);
        }
    }

    // Refuses every key that is neither known nor part of the format that a later version reads.
    void Allow(std::initializer_list<std::string_view> known,
               std::initializer_list<std::string_view> later) {
        if (error_.has_value()) return;
        const auto has = [](std::initializer_list<std::string_view> keys, std::string_view key) {
            return std::find(keys.begin(), keys.end(), key) != keys.end();
        };
        for (const auto& [key, child] : *node_.table()) {
            if (has(known, key)) continue;
            if (has(later, key)) {
                Fail("\"" + key + "\" of " + owner_ + " is not supported yet", child.where,
                     "unsupported");
            } else {
                Fail(owner_ + " has no key \"" + key + "\"", child.where);
            }
        }
    }

    const DocumentNode* Find(const std::string& key) const {
        if (error_.has_value()) return nullptr;
        const auto found = node_.table()->find(key);
        return found == node_.table()->end() ? nullptr : &found->second;
    }

    const DocumentNode* Require(const std::string& key) {
        const DocumentNode* found = Find(key);
        if (found == nullptr) Fail(owner_ + " needs \"" + key + "\"", node_.where);
        return found;
    }

    bool Read(const std::string& key, std::string& out) {
        const DocumentNode* found = Find(key);
        if (found == nullptr) return false;
        if (found->string() == nullptr) return FailType(key, "a string", *found);
        out = *found->string();
        return true;
    }

    bool Read(const std::string& key, bool& out) {
        const DocumentNode* found = Find(key);
        if (found == nullptr) return false;
        if (found->boolean() == nullptr) return FailType(key, "true or false", *found);
        out = *found->boolean();
        return true;
    }

    bool Read(const std::string& key, double& out) {
        const DocumentNode* found = Find(key);
        if (found == nullptr) return false;
        if (found->number() == nullptr) return FailType(key, "a number", *found);
        if (!std::isfinite(*found->number())) {
            Fail("\"" + key + "\" of " + owner_ + " is not a finite number", found->where);
            return false;
        }
        out = *found->number();
        return true;
    }

    void Read(const std::string& key, std::optional<double>& out) {
        double value = 0.0;
        if (Read(key, value)) out = value;
    }

    // An array of finite numbers.
    bool Read(const std::string& key, std::vector<double>& out) {
        const DocumentNode* found = Find(key);
        if (found == nullptr) return false;
        if (found->array() == nullptr) return FailType(key, "an array of numbers", *found);
        std::vector<double> values;
        for (const DocumentNode& item : *found->array()) {
            if (item.number() == nullptr) return FailType(key, "an array of numbers", item);
            if (!std::isfinite(*item.number())) {
                Fail("\"" + key + "\" of " + owner_ + " holds a number that is not finite",
                     item.where);
                return false;
            }
            values.push_back(*item.number());
        }
        out = std::move(values);
        return true;
    }

    void Fail(std::string message, std::string where, std::string code = "bad_lens") {
        if (!error_.has_value())
            error_ = Error{std::move(code), std::move(message), std::move(where)};
    }

    const std::optional<Error>& error() const { return error_; }

  private:
    bool FailType(const std::string& key, const char* wanted, const DocumentNode& found) {
        Fail("\"" + key + "\" of " + owner_ + " must be " + wanted + ", not " + TypeNameOf(found),
             found.where);
        return false;
    }

    const DocumentNode& node_;
    std::string owner_;
    std::optional<Error> error_;
};

}  // namespace flare
