// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/json_writer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "protocol/codec/json_document.h"

namespace flare::wire {
namespace {

using Style = JsonWriter::Style;

TEST(JsonWriter, WritesNestedValuesCompactly) {
    JsonWriter json(Style::kCompact);
    json.BeginObject().Member("a", 1).Key("b").BeginArray().Value(true).Null().Value("x").End();
    json.Key("c").BeginObject().End().End();
    EXPECT_EQ(json.Take(), R"({"a":1,"b":[true,null,"x"],"c":{}})");
}

TEST(JsonWriter, WritesOneMemberALineAndRowsOnOne) {
    JsonWriter json(Style::kPretty);
    json.BeginObject().Member("a", 1.5).Key("b").BeginRow().Value(1).Value(2).End().End();
    EXPECT_EQ(json.Take(), "{\n  \"a\": 1.5,\n  \"b\": [1, 2]\n}\n");
}

TEST(JsonWriter, GivesBackEveryDoubleExactly) {
    for (const double value : {0.1, 1.0 / 3.0, 50.358234567890123, 1e-300, 4.9e-324, -0.0,
                               std::numeric_limits<double>::max(), 36.0, 1e21}) {
        JsonWriter json(Style::kCompact);
        json.BeginRow().Value(value).End();
        const auto parsed = JsonDocument::Parse(json.Take());
        ASSERT_EQ(RefusalOf(parsed), nullptr);
        const double read = std::get<JsonDocument>(parsed).root().FirstChild()->number();
        EXPECT_EQ(read, value);
        EXPECT_EQ(std::signbit(read), std::signbit(value)) << value;
    }
}

TEST(JsonWriter, WritesNullForWhatJsonCannotSay) {
    JsonWriter json(Style::kCompact);
    json.BeginRow().Value(std::nan("")).Value(std::numeric_limits<double>::infinity()).End();
    EXPECT_EQ(json.Take(), "[null,null]");
}

// A header line must be ASCII without line breaks, whatever text came from outside.
TEST(JsonWriter, WritesAnyTextInPlainAscii) {
    const std::string text = "\"\\\n\x01\x7f \xc3\xa9 \xf0\x9f\x93\xb7";
    JsonWriter json(Style::kCompact);
    json.BeginRow().Value(text).End();
    const std::string written = json.Take();
    EXPECT_EQ(written, R"(["\"\\\n\u0001\u007f \u00e9 \ud83d\udcf7"])");
    const auto parsed = JsonDocument::Parse(written);
    EXPECT_EQ(std::get<JsonDocument>(parsed).root().FirstChild()->string(), text);
}

TEST(JsonWriter, ReplacesBytesThatAreNoUtf8) {
    JsonWriter json(Style::kCompact);
    json.BeginRow().Value("a\xff\xc3").Value("\xc0\xaf").End();
    EXPECT_EQ(json.Take(), R"(["a\ufffd\ufffd","\ufffd\ufffd"])");
}

TEST(EncodeRefusal, NamesCodeMessageAndPlace) {
    EXPECT_EQ(EncodeRefusal({"bad_value", "is \"not\" good", "/a/0"}),
              R"({"error":{"code":"bad_value","message":"is \"not\" good","where":"/a/0"}})");
}

}  // namespace
}  // namespace flare::wire
