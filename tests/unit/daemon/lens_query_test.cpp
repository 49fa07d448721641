// SPDX-License-Identifier: Apache-2.0
#include "server/lens_query.h"

#include <gtest/gtest.h>

namespace flare {
namespace {

TEST(GhostQuery, HasDefaults) {
    const auto query = ParseGhostQuery("");
    ASSERT_TRUE(query.ok());
    EXPECT_EQ(query->field_deg, 0.0);
    EXPECT_EQ(query->azimuth_deg, 0.0);
    EXPECT_FALSE(query->f_number || query->wavelength_nm);
    EXPECT_TRUE(query->coatings.own());
    EXPECT_EQ(query->state, LensState{});
    EXPECT_EQ(query->model.reflections, 2);
    EXPECT_FALSE(query->model.sensor_reflection);
}

TEST(GhostQuery, ReadsEveryParameter) {
    const auto query = ParseGhostQuery(
        "field_deg=-5&azimuth_deg=30&f_number=4&wavelength_nm=550.5&coatings=none&focus_m=1.5&"
        "zoom_mm=135&reflections=4&threshold=0.01&sensor_reflection=true");
    ASSERT_TRUE(query.ok()) << query.error().message;
    EXPECT_EQ(query->field_deg, -5.0);
    EXPECT_EQ(query->azimuth_deg, 30.0);
    EXPECT_EQ(query->f_number, 4.0);
    EXPECT_EQ(query->wavelength_nm, 550.5);
    EXPECT_TRUE(query->coatings.none);
    EXPECT_FALSE(query->coatings.default_name.has_value());
    EXPECT_EQ(query->state, (LensState{1.5, 135.0}));
    EXPECT_EQ(query->model.reflections, 4);
    EXPECT_EQ(query->model.four_reflection_threshold, 0.01);
    EXPECT_TRUE(query->model.sensor_reflection);
}

TEST(GhostQuery, TakesACoatingByName) {
    const auto query = ParseGhostQuery("coatings=mgf2-500");
    ASSERT_TRUE(query.ok());
    EXPECT_FALSE(query->coatings.none);
    EXPECT_EQ(query->coatings.default_name, "mgf2-500");
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
        {"azimuth_deg=361", "bad_value", "?azimuth_deg"},
        {"f_number=0", "bad_value", "?f_number"},
        {"f_number=-2", "bad_value", "?f_number"},
        {"wavelength_nm=1e9", "bad_value", "?wavelength_nm"},
        {"coatings=", "bad_value", "?coatings"},
        {"focus_m=0", "bad_value", "?focus_m"},
        {"focus_m=inf", "bad_value", "?focus_m"},
        {"zoom_mm=-70", "bad_value", "?zoom_mm"},
        {"reflections=3", "bad_value", "?reflections"},
        {"threshold=0", "bad_value", "?threshold"},
        {"sensor_reflection=1", "bad_value", "?sensor_reflection"},
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

TEST(LensQuery, ReadsTheStateAndNothingElse) {
    EXPECT_EQ(*ParseLensQuery(""), LensState{});
    EXPECT_EQ(*ParseLensQuery("focus_m=2.5&zoom_mm=85"), (LensState{2.5, 85.0}));
    for (const char* text : {"field_deg=5", "coatings=none", "focus=2"}) {
        const auto state = ParseLensQuery(text);
        ASSERT_FALSE(state.ok()) << text;
        EXPECT_EQ(state.error().code, "unknown_field") << text;
    }
    EXPECT_EQ(ParseLensQuery("zoom_mm=wide").error().where, "?zoom_mm");
}

}  // namespace
}  // namespace flare
