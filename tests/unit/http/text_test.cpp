// SPDX-License-Identifier: Apache-2.0
#include "server/http/text.h"

#include <gtest/gtest.h>

#include "server/http/message.h"

namespace flare {
namespace {

TEST(Query, ReadsNamesAndValues) {
    const auto query = ParseQuery("field_deg=-5.5&coatings=none&x=a%20b");
    ASSERT_TRUE(query.ok());
    EXPECT_EQ(*query, (Query{{"field_deg", "-5.5"}, {"coatings", "none"}, {"x", "a b"}}));
    EXPECT_TRUE(ParseQuery("")->empty());
}

TEST(Query, RefusesWhatIsNotNameAndValue) {
    const struct {
        const char* text;
        const char* where;
    } kBad[] = {
        {"a", "?a"},       {"=1", "?"},     {"a=1&", "?"},     {"&a=1", "?"},
        {"a=1&a=1", "?a"}, {"a=%", "?a"},   {"a=%2", "?a"},    {"a=%zz", "?a"},
        {"%=1", "?"},      {"a&b=1", "?a"}, {"a=1&&b=2", "?"},
    };
    for (const auto& row : kBad) {
        const auto query = ParseQuery(row.text);
        ASSERT_FALSE(query.ok()) << row.text;
        EXPECT_EQ(query.error().code, "bad_query") << row.text;
        EXPECT_EQ(query.error().where, row.where) << row.text;
    }
}

TEST(Percent, DecodesEveryByteAndNothingElse) {
    EXPECT_EQ(DecodePercent("a%2Fb%2fc+d"), "a/b/c+d");
    EXPECT_EQ(DecodePercent("%00"), std::string(1, '\0'));
    EXPECT_EQ(DecodePercent("100%"), std::nullopt);
}

TEST(Number, IsTheWholeTextAndFinite) {
    EXPECT_EQ(ParseNumber("-2.5e1"), -25.0);
    for (const char* bad : {"", " 1", "1 ", "1x", "nan", "inf", "-inf", "1e999", "+1", "0x10"}) {
        EXPECT_EQ(ParseNumber(bad), std::nullopt) << bad;
    }
}

TEST(Fields, AreFoundWhateverTheirCase) {
    const HttpFields fields{{"Content-Type", "a"}, {"content-type", "b"}};
    EXPECT_EQ(FieldValue(fields, "CONTENT-TYPE"), "a");
    EXPECT_EQ(FieldValue(fields, "Content"), std::nullopt);
}

}  // namespace
}  // namespace flare
