// SPDX-License-Identifier: Apache-2.0
//
// What the lens routes print, read back as JSON and held against the published first-order data of
// the seed lens.
#include "server/translate/lens_json.h"

#include <gtest/gtest.h>

#include <string>

#include "protocol/codec/flare_request_codec.h"
#include "protocol/codec/json_document.h"
#include "server/translate/request_from_wire.h"

namespace flare {
namespace {

using wire::JsonDocument;
using wire::JsonKind;
using wire::JsonView;

constexpr char kSeed[] = "tronnier-double-gauss-50mm-f2";

std::shared_ptr<const Lens> SeedLens() {
    const auto lens = LoadLensFile(std::string(FLARE_SOURCE_DIR "/lenses/") + kSeed + ".toml");
    EXPECT_TRUE(lens);
    return *lens;
}

JsonDocument Parsed(const std::string& text) {
    auto parsed = JsonDocument::Parse(text);
    const wire::Refusal* refusal = wire::RefusalOf(parsed);
    EXPECT_EQ(refusal, nullptr) << refusal->message;
    return std::get<JsonDocument>(std::move(parsed));
}

double Number(const JsonView& object, const char* name) {
    const auto member = object.Find(name);
    EXPECT_TRUE(member.has_value()) << name;
    return member ? member->number() : 0.0;
}

void ExpectRelative(double value, double expected, double tolerance) {
    EXPECT_NEAR(value, expected, std::abs(expected) * tolerance);
}

TEST(LensJson, ShowsTheFirstOrderDataOfTheSeedLens) {
    const JsonDocument document = Parsed(LensJson(*SeedLens()));
    const JsonView lens = document.root();
    EXPECT_EQ(lens.Find("name")->string(), kSeed);
    ExpectRelative(Number(lens, "efl_mm"), 50.3582, 1e-4);
    ExpectRelative(Number(lens, "bfl_mm"), 36.1059, 1e-4);
    ExpectRelative(Number(lens, "f_number"), 2.0302, 1e-4);
    ExpectRelative(Number(*lens.Find("entrance_pupil"), "z_mm"), 19.9465, 1e-4);
    ExpectRelative(Number(*lens.Find("entrance_pupil"), "diameter_mm"), 24.805, 1e-4);
    const JsonView exit = *lens.Find("exit_pupil");
    ExpectRelative(Number(exit, "z_from_last_vertex_mm"), -17.771, 1e-4);
    EXPECT_NEAR(Number(exit, "z_mm") - Number(lens, "last_vertex_z_mm"),
                Number(exit, "z_from_last_vertex_mm"), 1e-12);
    ExpectRelative(Number(lens, "sensor_z_mm") - Number(lens, "last_vertex_z_mm"), 36.1059, 1e-4);
    EXPECT_EQ(lens.Find("surfaces")->child_count(), 11u);
    EXPECT_EQ(lens.Find("vertex_z_mm")->child_count(), 11u);
    EXPECT_EQ(Number(lens, "stop_index"), 5.0);
}

// The surfaces are given as the file has them, so they make the same lens again.
TEST(LensJson, GivesSurfacesThatBuildTheSameLens) {
    const std::shared_ptr<const Lens> seed = SeedLens();
    const JsonDocument document = Parsed(LensJson(*seed));
    wire::JsonTree::Object prescription;
    const auto put = [&](const char* name, const JsonView& value) {
        prescription[name] = value.Tree();
    };
    put("name", *document.root().Find("name"));
    put("default_coating", *document.root().Find("default_coating"));
    put("surface", *document.root().Find("surfaces"));
    const auto built =
        LensFromWire(std::nullopt, wire::JsonTree{prescription, ""}, false, LensLibrary());
    ASSERT_TRUE(built) << built.error().where << built.error().message;
    EXPECT_EQ((*built)->fingerprint(), seed->fingerprint());
}

TEST(LensJson, NamesItsGlasses) {
    Prescription prescription = SeedLens()->prescription();
    prescription.surfaces[0].glass = "SCHOTT N-LAK8";
    prescription.surfaces[0].nd = prescription.surfaces[0].vd = std::nullopt;
    const JsonDocument document = Parsed(LensJson(**Lens::Build(prescription)));
    const JsonView front = *document.root().Find("surfaces")->FirstChild();
    EXPECT_EQ(front.Find("glass")->string(), "SCHOTT N-LAK8");
    EXPECT_FALSE(front.Find("nd").has_value());
    EXPECT_FALSE(front.NextSibling()->Find("glass").has_value());
}

TEST(LensListJson, ListsUsableLensesAndBrokenFiles) {
    const auto library = LensLibrary::Load(FLARE_SOURCE_DIR "/lenses");
    ASSERT_TRUE(library);
    const JsonDocument document = Parsed(LensListJson(*library));
    EXPECT_GE(document.root().Find("lenses")->child_count(), 4u);
    EXPECT_EQ(document.root().Find("broken")->child_count(), library->broken().size());
}

TEST(GhostListJson, ShowsEveryNumberOfTheContract) {
    GhostEntry ghost;
    ghost.sequence = {9, 1};
    ghost.abcd = {1.5, -2.5, 0.25, 3.0};
    ghost.crossings = {{0.5, 3.0, 11.0}, {-0.75, -2.0, 12.0}, {0.25, 6.0, 13.0}};
    ghost.largest_crossing = 1;
    ghost.flux_mm2 = 0.5;
    ghost.centroid_mm = Vec2d(-1.25, 0.0);
    ghost.peak_irradiance = 0.125;
    const GhostList list{2.0, {ghost}};
    GhostListOptions options;
    options.field_deg = 5.0;
    const JsonDocument document = Parsed(GhostListJson(*SeedLens(), list, options, true));
    const JsonView root = document.root();
    EXPECT_EQ(root.Find("lens")->string(), kSeed);
    EXPECT_EQ(Number(root, "total_flux_mm2"), 2.0);
    EXPECT_EQ(Number(root, "field_deg"), 5.0);
    ExpectRelative(Number(root, "f_number"), 2.0302, 1e-4);
    EXPECT_TRUE(root.Find("bare_glass")->boolean());
    const JsonView shown = *root.Find("ghosts")->FirstChild();
    EXPECT_EQ(shown.Find("sequence")->FirstChild()->number(), 9.0);
    EXPECT_EQ(Number(shown, "stop_crossings"), 3.0);
    EXPECT_EQ(shown.Find("abcd")->FirstChild()->NextSibling()->number(), -2.5);
    EXPECT_EQ(Number(shown, "m"), -2.0);
    EXPECT_EQ(Number(shown, "z_eff_mm"), 12.0);
    EXPECT_EQ(shown.Find("crossings")->child_count(), 3u);
    EXPECT_EQ(Number(*shown.Find("crossings")->FirstChild(), "a1"), 0.5);
    EXPECT_EQ(Number(shown, "flux_mm2"), 0.5);
    EXPECT_EQ(Number(shown, "share"), 0.25);
    EXPECT_EQ(shown.Find("centroid_mm")->FirstChild()->number(), -1.25);
    EXPECT_EQ(Number(shown, "peak_irradiance"), 0.125);
}

}  // namespace
}  // namespace flare
