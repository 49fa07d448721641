// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/reader.h"

#include <algorithm>
#include <charconv>

namespace flare::wire {
namespace {

std::string Digits(double value) {
    std::array<char, 32> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    return std::string(digits.data(), end);
}

std::string_view KindName(JsonKind kind) {
    switch (kind) {
        case JsonKind::kNull:
            return "null";
        case JsonKind::kBoolean:
            return "true or false";
        case JsonKind::kNumber:
            return "a number";
        case JsonKind::kString:
            return "a string";
        case JsonKind::kArray:
            return "an array";
        case JsonKind::kObject:
            return "an object";
    }
    return "null";
}

bool Holds(std::initializer_list<std::string_view> names, std::string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

// Text from outside, cut to a length that suits a message, never inside a UTF-8 character.
std::string Shortened(std::string_view text) {
    constexpr std::size_t kShown = 60;
    if (text.size() <= kShown) return std::string(text);
    std::size_t end = kShown;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0u) == 0x80u) --end;
    return std::string(text.substr(0, end)) + "...";
}

}  // namespace

std::string Reader::Quoted(const JsonView& text) {
    return '"' + Shortened(text.string()) + '"';
}

bool Reader::Refuse(const JsonView& at, std::string code, std::string message) {
    refusal_ = {std::move(code), std::move(message), at.Pointer()};
    return false;
}

bool Reader::RefuseMember(const JsonView& object, std::string_view member, std::string code,
                          std::string message) {
    std::string pointer = object.Pointer();
    AppendPointerToken(pointer, member);
    refusal_ = {std::move(code), std::move(message), std::move(pointer)};
    return false;
}

bool Reader::Unsupported(const JsonView& at) {
    std::string what = at.key().empty() ? "this value" : '"' + std::string(at.key()) + '"';
    if (at.kind() == JsonKind::kString) what = Quoted(at);
    return Refuse(at, "unsupported", what + " is not supported by this version");
}

bool Reader::WrongType(const JsonView& at, std::string_view expected) {
    return Refuse(
        at, "bad_type",
        "expected " + std::string(expected) + ", found " + std::string(KindName(at.kind())));
}

bool Reader::Object(const JsonView& at, std::initializer_list<std::string_view> known,
                    std::initializer_list<std::string_view> later) {
    if (at.kind() != JsonKind::kObject) return WrongType(at, "an object");
    for (auto child = at.FirstChild(); child; child = child->NextSibling()) {
        if (Holds(known, child->key())) continue;
        if (Holds(later, child->key())) return Unsupported(*child);
        return Refuse(*child, "unknown_field",
                      "there is no field \"" + Shortened(child->key()) + "\" here");
    }
    return true;
}

bool Reader::Require(const JsonView& object, std::string_view name,
                     std::optional<JsonView>& member) {
    member = object.Find(name);
    if (member) return true;
    return RefuseMember(object, name, "missing_field",
                        "the field \"" + std::string(name) + "\" is missing");
}

bool Reader::Boolean(const JsonView& at, bool& value) {
    if (at.kind() != JsonKind::kBoolean) return WrongType(at, "true or false");
    value = at.boolean();
    return true;
}

bool Reader::Number(const JsonView& at, Range range, double& value) {
    if (at.kind() != JsonKind::kNumber) return WrongType(at, "a number");
    value = at.number();
    if (value < range.min || (range.min_excluded && value == range.min)) {
        return Refuse(at, "bad_value",
                      Digits(value) + " is not " + (range.min_excluded ? "above " : "at least ") +
                          Digits(range.min));
    }
    if (value > range.max) {
        return Refuse(at, range.max_is_limit ? "limit" : "bad_value",
                      Digits(value) + " is above " + Digits(range.max));
    }
    return true;
}

bool Reader::Integer(const JsonView& at, int min, int limit, int& value) {
    double number = 0.0;
    if (!Number(at, FromUpTo(min, limit), number)) return false;
    if (number != std::floor(number)) {
        return Refuse(at, "bad_type", Digits(number) + " is not a whole number");
    }
    value = static_cast<int>(number);
    return true;
}

bool Reader::IsText(const JsonView& at) {
    return at.kind() == JsonKind::kString || WrongType(at, "a string");
}

bool Reader::Text(const JsonView& at, std::size_t limit, std::string& value) {
    if (!IsText(at)) return false;
    if (at.string().empty()) return Refuse(at, "bad_value", "the string is empty");
    if (at.string().size() > limit) {
        return Refuse(at, "limit", "the string is longer than " + std::to_string(limit) + " bytes");
    }
    value = std::string(at.string());
    return true;
}

bool Reader::Array(const JsonView& at, std::size_t limit) {
    if (at.kind() != JsonKind::kArray) return WrongType(at, "an array");
    if (at.child_count() <= limit) return true;
    return Refuse(at, "limit",
                  std::to_string(at.child_count()) + " elements, at most " + std::to_string(limit) +
                      " are allowed");
}

bool Reader::Tuple(const JsonView& at, std::size_t count) {
    if (at.kind() != JsonKind::kArray) return WrongType(at, "an array");
    if (at.child_count() == count) return true;
    return Refuse(at, "bad_value",
                  "expected " + std::to_string(count) + " elements, found " +
                      std::to_string(at.child_count()));
}

}  // namespace flare::wire
