// SPDX-License-Identifier: Apache-2.0
//
// Writes JSON as text, in the order of the calls. ASCII only (the rest as \u escapes), so the same
// text may stand in an HTTP header. A double is written with the fewest digits that give it back
// exactly; NaN and infinities, which JSON cannot say, become null.
//
//     JsonWriter json(JsonWriter::Style::kPretty);
//     json.BeginObject().Member("name", lens.name()).Key("z_mm").BeginRow().Value(1.5).End().End();
//     json.Take();
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "protocol/wire/refusal.h"

namespace flare::wire {

class JsonWriter {
  public:
    enum class Style { kCompact, kPretty };
    explicit JsonWriter(Style style) : style_(style) {}

    JsonWriter& BeginObject() { return Begin('{', '}', false); }
    JsonWriter& BeginArray() { return Begin('[', ']', false); }
    // An object or array on one line, also in pretty style.
    JsonWriter& BeginInlineObject() { return Begin('{', '}', true); }
    JsonWriter& BeginRow() { return Begin('[', ']', true); }
    JsonWriter& End();

    JsonWriter& Key(std::string_view name);

    JsonWriter& Value(std::string_view text);
    JsonWriter& Value(const char* text) { return Value(std::string_view(text)); }
    JsonWriter& Value(const std::string& text) { return Value(std::string_view(text)); }
    JsonWriter& Value(double number);
    JsonWriter& Value(bool truth);
    JsonWriter& Value(std::int64_t number);
    JsonWriter& Value(std::uint64_t number);
    JsonWriter& Value(int number) { return Value(static_cast<std::int64_t>(number)); }
    JsonWriter& Null();

    template <class T>
    JsonWriter& Member(std::string_view name, const T& value) {
        return Key(name).Value(value);
    }

    // The text so far; pretty texts end with a newline. The writer is empty afterwards.
    std::string Take();

  private:
    struct Level {
        char closing;
        bool on_one_line;
        bool empty = true;
    };

    JsonWriter& Begin(char opening, char closing, bool on_one_line);
    void BeforeValue();
    void BreakLine();
    JsonWriter& Raw(std::string_view text);
    void AppendQuoted(std::string_view text);

    Style style_;
    std::string text_;
    std::vector<Level> levels_;
    bool after_key_ = false;
};

// {"error":{"code","message","where"}}
std::string EncodeRefusal(const Refusal& refusal);

}  // namespace flare::wire
