// SPDX-License-Identifier: Apache-2.0
//
// A JSON text read strictly (RFC 8259 and nothing more) into one flat array of values, within the
// limits of protocol/limits.h. Refused: anything after the value, a truncated text, NaN and
// Infinity, invalid UTF-8, a member named twice, numbers that a double cannot hold, too deep or too
// many values. Never throws, except for want of memory.
//
// A JsonView is a light handle into a JsonDocument that must outlive it. Its JSON pointer (RFC
// 6901) is worked out only when a message needs it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/wire/json_tree.h"
#include "protocol/wire/refusal.h"

namespace flare::wire {

enum class JsonKind : std::uint8_t { kNull, kBoolean, kNumber, kString, kArray, kObject };

class JsonDocument;
class JsonBuilder;

class JsonView {
  public:
    JsonKind kind() const;
    bool boolean() const;
    double number() const;
    std::string_view string() const;
    // Name of this member; "" for elements of an array and for the whole.
    std::string_view key() const;

    // Children of an array or object in the order of the text: first child, then its next sibling.
    std::optional<JsonView> FirstChild() const;
    std::optional<JsonView> NextSibling() const;
    std::size_t child_count() const;
    // The member `name` of an object.
    std::optional<JsonView> Find(std::string_view name) const;

    std::string Pointer() const;
    // Number of values in this one, itself included.
    std::size_t value_count() const;
    // A copy as a free-standing tree.
    JsonTree Tree() const;

  private:
    friend class JsonDocument;
    friend class JsonBuilder;
    JsonView(const JsonDocument* document, std::uint32_t index)
        : document_(document), index_(index) {}

    const JsonDocument* document_;
    std::uint32_t index_;
};

class JsonDocument {
  public:
    static Decoded<JsonDocument> Parse(std::string_view text);

    JsonView root() const { return JsonView(this, 0); }

  private:
    friend class JsonView;
    friend class JsonBuilder;

    // Values stand in the order of the text, children right behind their parent.
    struct Node {
        double number = 0.0;
        std::uint32_t text_begin = 0, text_size = 0;  // into text_
        std::uint32_t key_begin = 0, key_size = 0;    // into text_
        std::uint32_t parent = 0;
        std::uint32_t end = 0;  // index behind the last value inside this one
        std::uint32_t children = 0;
        JsonKind kind = JsonKind::kNull;
        bool boolean = false;
    };

    std::string_view Text(std::uint32_t begin, std::uint32_t size) const {
        return std::string_view(text_).substr(begin, size);
    }

    std::vector<Node> nodes_;
    std::string text_;  // all strings and keys, one after another
};

// Appends `token` to a JSON pointer, with ~ and / escaped.
void AppendPointerToken(std::string& pointer, std::string_view token);

}  // namespace flare::wire
