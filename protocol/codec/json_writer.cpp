// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/json_writer.h"

#include <array>
#include <charconv>
#include <cmath>

namespace flare::wire {
namespace {

void AppendEscape(std::string& text, unsigned code_unit) {
    constexpr char kDigits[] = "0123456789abcdef";
    text += "\\u";
    for (int shift = 12; shift >= 0; shift -= 4) text += kDigits[(code_unit >> shift) & 15u];
}

// One code point of UTF-8 from text[at]; moves `at` behind it. Bytes that are no UTF-8 become
// U+FFFD.
unsigned NextCodePoint(std::string_view text, std::size_t& at) {
    const auto byte = [&](std::size_t i) {
        return i < text.size() ? static_cast<unsigned>(static_cast<unsigned char>(text[i])) : 0u;
    };
    const unsigned first = byte(at);
    const std::size_t length = first < 0x80 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
    unsigned code = length == 1 ? first : first & (0x7fu >> length);
    bool sound = first < 0x80 || (first >= 0xc2 && first < 0xf5);
    for (std::size_t i = 1; i < length && sound; ++i) {
        sound = (byte(at + i) & 0xc0u) == 0x80u;
        code = (code << 6) | (byte(at + i) & 0x3fu);
    }
    at += sound ? length : 1;
    return sound ? code : 0xfffdu;
}

}  // namespace

JsonWriter& JsonWriter::Begin(char opening, char closing, bool on_one_line) {
    BeforeValue();
    text_ += opening;
    const bool inherited = !levels_.empty() && levels_.back().on_one_line;
    levels_.push_back({closing, on_one_line || inherited || style_ == Style::kCompact});
    return *this;
}

JsonWriter& JsonWriter::End() {
    const Level level = levels_.back();
    levels_.pop_back();
    if (!level.empty && !level.on_one_line) BreakLine();
    text_ += level.closing;
    return *this;
}

void JsonWriter::BreakLine() {
    text_ += '\n';
    text_.append(2 * levels_.size(), ' ');
}

// The comma, space or line break that the next value or key needs in front of it.
void JsonWriter::BeforeValue() {
    if (after_key_) {
        after_key_ = false;
        return;
    }
    if (levels_.empty()) return;
    Level& level = levels_.back();
    if (!level.empty) text_ += ',';
    if (!level.on_one_line) {
        BreakLine();
    } else if (!level.empty && style_ == Style::kPretty) {
        text_ += ' ';
    }
    level.empty = false;
}

JsonWriter& JsonWriter::Key(std::string_view name) {
    BeforeValue();
    AppendQuoted(name);
    text_ += style_ == Style::kPretty ? ": " : ":";
    after_key_ = true;
    return *this;
}

JsonWriter& JsonWriter::Raw(std::string_view text) {
    BeforeValue();
    text_ += text;
    return *this;
}

JsonWriter& JsonWriter::Value(std::string_view text) {
    BeforeValue();
    AppendQuoted(text);
    return *this;
}

JsonWriter& JsonWriter::Value(double number) {
    if (!std::isfinite(number)) return Null();
    if (number == 0.0 && std::signbit(number)) return Raw("-0.0");  // "-0" would read as an integer
    std::array<char, 32> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    return Raw({digits.data(), static_cast<std::size_t>(end - digits.data())});
}

JsonWriter& JsonWriter::Value(bool truth) {
    return Raw(truth ? "true" : "false");
}
JsonWriter& JsonWriter::Value(std::int64_t number) {
    return Raw(std::to_string(number));
}
JsonWriter& JsonWriter::Value(std::uint64_t number) {
    return Raw(std::to_string(number));
}
JsonWriter& JsonWriter::Null() {
    return Raw("null");
}

void JsonWriter::AppendQuoted(std::string_view text) {
    text_ += '"';
    for (std::size_t at = 0; at < text.size();) {
        const unsigned code = NextCodePoint(text, at);
        if (code == '"' || code == '\\') {
            text_ += '\\';
            text_ += static_cast<char>(code);
        } else if (code == '\n') {
            text_ += "\\n";
        } else if (code >= 0x20 && code < 0x7f) {
            text_ += static_cast<char>(code);
        } else if (code < 0x10000) {
            AppendEscape(text_, code);
        } else {
            AppendEscape(text_, 0xd800u + ((code - 0x10000u) >> 10));
            AppendEscape(text_, 0xdc00u + ((code - 0x10000u) & 0x3ffu));
        }
    }
    text_ += '"';
}

std::string JsonWriter::Take() {
    if (style_ == Style::kPretty) text_ += '\n';
    std::string text = std::move(text_);
    text_.clear();
    levels_.clear();
    after_key_ = false;
    return text;
}

std::string EncodeRefusal(const Refusal& refusal) {
    JsonWriter json(JsonWriter::Style::kCompact);
    json.BeginObject().Key("error").BeginObject();
    json.Member("code", refusal.code);
    json.Member("message", refusal.message);
    json.Member("where", refusal.where);
    json.End().End();
    return json.Take();
}

}  // namespace flare::wire
