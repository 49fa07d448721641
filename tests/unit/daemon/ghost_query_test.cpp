// SPDX-License-Identifier: Apache-2.0
#include "server/ghost_query.h"

#include <gtest/gtest.h>

namespace flare {
namespace {

TEST(GhostQuery, HasDefaults) {
    const auto query = ParseGhostQuery("");
    ASSERT_TRUE(query.ok());
    EXPECT_EQ(query->field_deg, 0.0);
    EXPECT_FALSE(query->f_number || query->wavelength_nm || query->bare_glass);
}

TEST(GhostQuery, ReadsEveryParameter) {
    const auto query = ParseGhostQuery("field_deg=5&f_number=4&wavelength_nm=550.5&coatings=none");
    ASSERT_TRUE(query.ok());
    EXPECT_EQ(query->field_deg, 5.0);
    EXPECT_EQ(query->f_number, 4.0);
    EXPECT_EQ(query->wavelength_nm, 550.5);
    EXPECT_TRUE(query->bare_glass);
}

TEST(GhostQuery, NamesTheParameterThatIsWrong) {
    const struct {
        const char* text;
        const char* code;
        const char* where;
    } kBad[] = {
        {"field_deg=nan", "bad_value", "?field_deg"},
        {"field_deg=181", "bad_value", "?field_deg"},
        {"field_deg=", "bad_value", "?field_deg"},
        {"field_deg=5deg", "bad_value", "?field_deg"},
        {"f_number=0", "bad_value", "?f_number"},
        {"f_number=-2", "bad_value", "?f_number"},
        {"wavelength_nm=1e9", "bad_value", "?wavelength_nm"},
        {"coatings=all", "bad_value", "?coatings"},
        {"iris=6", "unknown_field", "?iris"},
        {"field_deg=1&field_deg=2", "bad_query", "?field_deg"},
    };
    for (const auto& row : kBad) {
        const auto query = ParseGhostQuery(row.text);
        ASSERT_FALSE(query.ok()) << row.text;
        EXPECT_EQ(query.error().code, row.code) << row.text;
        EXPECT_EQ(query.error().where, row.where) << row.text;
    }
}

}  // namespace
}  // namespace flare
