// SPDX-License-Identifier: Apache-2.0
//
// The field data as programs read it.
#include "server/translate/field_json.h"

#include <gtest/gtest.h>

#include <string>

#include "protocol/codec/flare_request_codec.h"
#include "protocol/codec/json_document.h"
#include "server/translate/lens_json.h"

namespace flare {
namespace {

using wire::JsonDocument;
using wire::JsonKind;
using wire::JsonView;

std::shared_ptr<const Lens> LensOfLibrary(const std::string& name) {
    const auto lens = LoadLensFile(FLARE_SOURCE_DIR "/lenses/" + name + ".toml");
    EXPECT_TRUE(lens);
    return *lens;
}

JsonDocument Parsed(const std::string& text) {
    auto parsed = JsonDocument::Parse(text);
    const wire::Refusal* refusal = wire::RefusalOf(parsed);
    EXPECT_EQ(refusal, nullptr) << refusal->message;
    return std::get<JsonDocument>(std::move(parsed));
}

JsonView Child(const JsonView& array, int index) {
    std::optional<JsonView> child = array.FirstChild();
    for (; index > 0 && child; --index) child = child->NextSibling();
    EXPECT_TRUE(child.has_value());
    return *child;
}

JsonDocument Written(const Lens& lens, const FieldOptions& options) {
    wire::JsonWriter json(wire::JsonWriter::Style::kPretty);
    json.BeginObject();
    WriteField(json, lens, options);
    json.End();
    return Parsed(json.Take());
}

TEST(FieldJson, HoldsTheRowsOfTheData) {
    const auto lens = LensOfLibrary("tronnier-double-gauss-50mm-f2");
    const FieldOptions options{.rows = 3, .f_number = 4.0};
    const FieldData data = FieldDataOf(*lens, options);
    const JsonDocument document = Written(*lens, options);
    const JsonView field = *document.root().Find("field");
    EXPECT_EQ(field.Find("f_number")->number(), 4.0);
    EXPECT_EQ(field.Find("wavelengths_nm")->child_count(), 7u);
    ASSERT_EQ(field.Find("tables")->child_count(), 1u);
    const JsonView table = Child(*field.Find("tables"), 0);
    EXPECT_FALSE(table.Find("section").has_value());
    EXPECT_EQ(table.Find("edge")->string(), "image_circle");
    ASSERT_EQ(table.Find("rows")->child_count(), 3u);
    const JsonView edge = Child(*table.Find("rows"), 2);
    const FieldRow& row = data.tables[0].rows[2];
    EXPECT_NEAR(edge.Find("field_deg")->number(), 23.6, 0.05);
    EXPECT_NEAR(edge.Find("image_height_mm")->number(), 21.65, 1e-6);
    EXPECT_EQ(edge.Find("distortion")->number(), *row.distortion);
    EXPECT_EQ(edge.Find("relative_illumination")->number(), *row.relative_illumination);
    EXPECT_EQ(edge.Find("flux_mm2")->number(), row.flux_mm2);
    EXPECT_EQ(edge.Find("transmittance")->child_count(), 7u);
    EXPECT_FALSE(edge.Find("f_theta_distortion").has_value());
}

TEST(FieldJson, HasNullWhereDistortionMeansNothing) {
    const auto lens = LensOfLibrary("shimizu-fisheye-6mm-f2_8-220deg");
    const JsonDocument document = Written(*lens, {.rows = 2, .wavelengths_nm = {}});
    const JsonView table = Child(*document.root().Find("field")->Find("tables"), 0);
    const JsonView edge = Child(*table.Find("rows"), 1);
    EXPECT_GT(edge.Find("field_deg")->number(), 105.0);
    EXPECT_EQ(edge.Find("distortion")->kind(), JsonKind::kNull);
    EXPECT_EQ(edge.Find("ideal_height_mm")->kind(), JsonKind::kNull);
    EXPECT_EQ(edge.Find("f_theta_distortion")->kind(), JsonKind::kNumber);
}

TEST(FieldJson, NamesTheSectionsOfAnAnamorphicLens) {
    const auto lens = LensOfLibrary("schneider-anamorphic-31mm-f2");
    const JsonDocument document = Written(*lens, {.rows = 2, .wavelengths_nm = {}});
    const JsonView tables = *document.root().Find("field")->Find("tables");
    ASSERT_EQ(tables.child_count(), 2u);
    EXPECT_EQ(Child(tables, 0).Find("section")->string(), "x");
    EXPECT_EQ(Child(tables, 1).Find("section")->string(), "y");
}

TEST(LensJson, HasTheFieldOnlyWhereAskedFor) {
    const auto lens = LensOfLibrary("tronnier-double-gauss-50mm-f2");
    EXPECT_FALSE(Parsed(LensJson(*lens, {lens, {}, {}}, false)).root().Find("field").has_value());
    const JsonDocument document = Parsed(LensJson(*lens, {lens, {}, {}}, true));
    const JsonView table = Child(*document.root().Find("field")->Find("tables"), 0);
    EXPECT_EQ(table.Find("rows")->child_count(), 11u);
}

}  // namespace
}  // namespace flare
