// SPDX-License-Identifier: Apache-2.0
//
// What the lens routes print, read back as JSON and held against the published first-order data of
// the seed lens.
#include "server/translate/lens_json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "protocol/codec/json_document.h"
#include "server/translate/lens_from_wire.h"

namespace flare {
namespace {

using wire::JsonDocument;
using wire::JsonKind;
using wire::JsonView;

constexpr char kSeed[] = "tronnier-double-gauss-50mm-f2";

std::shared_ptr<const Lens> LensOfFile(const std::string& name) {
    const auto lens = LoadLensFile(FLARE_SOURCE_DIR "/lenses/" + name + ".toml");
    EXPECT_TRUE(lens);
    return *lens;
}
std::shared_ptr<const Lens> SeedLens() {
    return LensOfFile(kSeed);
}

std::string Shown(const std::shared_ptr<const Lens>& lens, const LensState& state = {}) {
    const auto shown = SetState(lens, state);
    EXPECT_TRUE(shown);
    return LensJson(*lens, *shown, false);
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
    const JsonDocument document = Parsed(Shown(SeedLens()));
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
    const JsonDocument document = Parsed(Shown(seed));
    wire::JsonTree::Object prescription;
    const auto put = [&](const char* name, const JsonView& value) {
        prescription[name] = value.Tree();
    };
    put("name", *document.root().Find("name"));
    put("default_coating", *document.root().Find("default_coating"));
    put("surface", *document.root().Find("surfaces"));
    wire::LensChoice choice;
    choice.prescription = wire::JsonTree{prescription, ""};
    const auto built = LensFromWire(choice, LensLibrary());
    ASSERT_TRUE(built) << built.error().where << built.error().message;
    EXPECT_EQ(built->lens->fingerprint(), seed->fingerprint());
}

TEST(LensJson, NamesItsGlasses) {
    Prescription prescription = SeedLens()->prescription();
    prescription.surfaces[0].glass = "SCHOTT N-LAK8";
    prescription.surfaces[0].nd = prescription.surfaces[0].vd = std::nullopt;
    const JsonDocument document = Parsed(Shown(*Lens::Build(prescription)));
    const JsonView front = *document.root().Find("surfaces")->FirstChild();
    EXPECT_EQ(front.Find("glass")->string(), "SCHOTT N-LAK8");
    EXPECT_FALSE(front.Find("nd").has_value());
    EXPECT_FALSE(front.NextSibling()->Find("glass").has_value());
}

// The contract's closed form: S = focus - HH', s' = (S - sqrt(S^2 - 4 f S)) / 2.
TEST(LensJson, ShowsTheSensorMovedByUnitFocusing) {
    const std::shared_ptr<const Lens> seed = SeedLens();
    const JsonDocument far = Parsed(Shown(seed));
    const JsonDocument near = Parsed(Shown(seed, {1.0, std::nullopt}));
    EXPECT_EQ(far.root().Find("state")->Find("focus_m")->kind(), JsonKind::kNull);
    EXPECT_EQ(far.root().Find("state")->Find("zoom_mm")->kind(), JsonKind::kNull);
    const JsonView state = *near.root().Find("state");
    EXPECT_EQ(Number(state, "focus_m"), 1.0);
    EXPECT_EQ(state.Find("clamped")->child_count(), 0u);
    EXPECT_NEAR(Number(state, "focus_shift_mm"), 2.8117, 1e-4);
    EXPECT_NEAR(Number(near.root(), "sensor_z_mm") - Number(far.root(), "sensor_z_mm"), 2.8117,
                1e-4);
    EXPECT_EQ(Number(near.root(), "efl_mm"), Number(far.root(), "efl_mm"));
    EXPECT_NE(near.root().Find("fingerprint")->string(), far.root().Find("fingerprint")->string());
}

TEST(LensJson, SaysWhatWasClamped) {
    const JsonDocument document = Parsed(Shown(SeedLens(), {0.01, 85.0}));
    const JsonView clamped = *document.root().Find("state")->Find("clamped");
    ASSERT_EQ(clamped.child_count(), 2u);
    const JsonView zoom = *clamped.FirstChild();
    EXPECT_EQ(zoom.Find("field")->string(), "zoom_mm");
    EXPECT_EQ(Number(zoom, "from"), 85.0);
    EXPECT_EQ(Number(zoom, "to"), 50.0);  // what its file's design says
    const JsonView focus = *zoom.NextSibling();
    EXPECT_EQ(focus.Find("field")->string(), "focus_m");
    EXPECT_EQ(Number(focus, "from"), 0.01);
    // S = 4 f, at life size.
    EXPECT_NEAR(Number(focus, "to"), (4.0 * 50.358167 - 5.448) / 1000.0, 1e-5);
}

// Figures of the lens's file: focal lengths, f-number, and gap 9 at its positions.
TEST(LensJson, ShowsAZoomInItsState) {
    const std::shared_ptr<const Lens> zoom = LensOfFile("nikon-zoom-80-200mm-f2_8");
    const JsonDocument wide = Parsed(Shown(zoom));
    const JsonDocument tele = Parsed(Shown(zoom, {std::nullopt, 200.0}));
    for (const JsonDocument* document : {&wide, &tele}) {
        const JsonView states = *document->root().Find("states");
        EXPECT_EQ(states.Find("focal_mm")->FirstChild()->number(), 80.0);
        EXPECT_EQ(states.Find("focal_mm")->child_count(), 8u);
        EXPECT_FALSE(states.Find("focus_m").has_value());
    }
    EXPECT_EQ(Number(*wide.root().Find("state"), "zoom_mm"), 80.0);
    EXPECT_EQ(Number(*tele.root().Find("state"), "zoom_mm"), 200.0);
    ExpectRelative(Number(wide.root(), "efl_mm"), 80.1, 1e-3);
    ExpectRelative(Number(tele.root(), "efl_mm"), 200.3, 1e-3);
    ExpectRelative(Number(tele.root(), "f_number"), 2.69, 5e-3);
    EXPECT_GT(Number(*tele.root().Find("entrance_pupil"), "diameter_mm"),
              2.0 * Number(*wide.root().Find("entrance_pupil"), "diameter_mm"));
    EXPECT_EQ(Number(tele.root(), "year"), Number(wide.root(), "year"));
}

TEST(LensJson, ShowsBothSectionsOfAnAnamorphicLens) {
    const std::shared_ptr<const Lens> lens = LensOfFile("schneider-anamorphic-31mm-f2");
    const JsonDocument document = Parsed(Shown(lens));
    const JsonView root = document.root();
    const JsonView x = *root.Find("x");
    const JsonView y = *root.Find("y");
    EXPECT_EQ(root.Find("design")->Find("section")->string(), "x");
    ExpectRelative(Number(x, "efl_mm"), 31.49, 1e-3);
    ExpectRelative(Number(y, "efl_mm"), 60.55, 1e-3);
    EXPECT_EQ(Number(root, "efl_mm"), Number(x, "efl_mm"));
    EXPECT_EQ(Number(root, "bfl_mm"), Number(x, "bfl_mm"));
    ExpectRelative(Number(root, "squeeze"), 1.923, 1e-3);
    for (const JsonView& section : {x, y}) {
        ExpectRelative(
            Number(section, "f_number"),
            Number(section, "efl_mm") / Number(*section.Find("entrance_pupil"), "diameter_mm"),
            1e-12);
        EXPECT_GT(Number(section, "pupil_magnification"), 0.0);
        EXPECT_TRUE(section.Find("exit_pupil").has_value());
    }
    ExpectRelative(Number(root, "f_number"),
                   std::sqrt(Number(x, "f_number") * Number(y, "f_number")), 1e-12);
    EXPECT_FALSE(Parsed(Shown(SeedLens())).root().Find("x").has_value());
    EXPECT_EQ(Number(Parsed(Shown(SeedLens())).root(), "squeeze"), 1.0);
}

TEST(LensJson, GivesEveryKeyOfALensFile) {
    Prescription file;
    file.name = "every-key";
    file.year = 1999;
    file.design_focal_mm = 100.0;
    file.focal_tolerance = 0.25;
    SurfacePrescription front;
    front.kind = SurfaceKind::kAsphere;
    front.radius_mm = 50.0;
    front.conic = -0.5;
    front.asphere = {1e-7, -2e-10};
    front.gap_mm = 5.0;
    front.gap_given = true;
    front.glass = "SCHOTT N-BK7";
    front.semi_diameter_mm = 8.0;
    SurfacePrescription back = front;
    back.kind = SurfaceKind::kToroid;
    back.radius_mm = 0.0;
    back.radius_x_mm = -300.0;
    back.radius_y_mm = -200.0;
    back.conic = 0.0;
    back.asphere.clear();
    back.glass.reset();
    SurfacePrescription stop = back;
    stop.kind = SurfaceKind::kStop;
    stop.radius_x_mm = stop.radius_y_mm = 0.0;
    stop.gap_given = false;
    stop.semi_diameter_mm = 5.0;
    SurfacePrescription sensor;
    sensor.kind = SurfaceKind::kSensor;
    sensor.reflectance = 0.04;
    sensor.semi_diameter_mm = 21.6;
    front.coating = "amber";
    file.coatings.emplace("amber",
                          *CoatingDesign::Stack("amber", {{*MaterialByName("MgF2"), 82.0},
                                                          {std::complex<double>(2.1, 0.5), 20.0}}));
    file.surfaces = {front, back, stop, sensor};
    const auto lens = Lens::Build(file);
    ASSERT_TRUE(lens) << lens.error().message;
    const JsonDocument document = Parsed(Shown(*lens));
    const JsonView root = document.root();
    EXPECT_EQ(Number(root, "year"), 1999.0);
    EXPECT_EQ(Number(*root.Find("design"), "focal_tolerance"), 0.25);
    EXPECT_EQ(Number(*root.Find("sensor"), "reflectance"), 0.04);
    EXPECT_EQ(Number(*root.Find("sensor"), "semi_diameter_mm"), 21.6);
    const JsonView layers = *root.Find("coatings")->Find("amber")->Find("layers");
    ASSERT_EQ(layers.child_count(), 2u);
    EXPECT_EQ(MaterialByName(layers.FirstChild()->Find("material")->string())->name(),
              MaterialByName("MgF2")->name());
    EXPECT_EQ(Number(*layers.FirstChild(), "thickness_nm"), 82.0);
    EXPECT_EQ(Number(*layers.FirstChild()->NextSibling(), "n"), 2.1);
    EXPECT_EQ(Number(*layers.FirstChild()->NextSibling(), "k"), 0.5);
    ASSERT_EQ(root.Find("surfaces")->child_count(), 4u);
    const JsonView asphere = *root.Find("surfaces")->FirstChild();
    EXPECT_EQ(asphere.Find("kind")->string(), "asphere");
    EXPECT_EQ(Number(asphere, "conic"), -0.5);
    EXPECT_EQ(asphere.Find("asphere")->FirstChild()->NextSibling()->number(), -2e-10);
    const JsonView toroid = *asphere.NextSibling();
    EXPECT_EQ(Number(toroid, "radius_x_mm"), -300.0);
    EXPECT_EQ(Number(toroid, "radius_y_mm"), -200.0);
    const JsonView mirror = *toroid.NextSibling()->NextSibling();
    EXPECT_EQ(mirror.Find("kind")->string(), "sensor");
    EXPECT_EQ(Number(mirror, "reflectance"), 0.04);
}

TEST(LensListJson, ListsUsableLensesAndBrokenFiles) {
    const auto library = LensLibrary::Load(FLARE_SOURCE_DIR "/lenses");
    ASSERT_TRUE(library);
    const JsonDocument document = Parsed(LensListJson(*library));
    EXPECT_GE(document.root().Find("lenses")->child_count(), 4u);
    EXPECT_EQ(document.root().Find("broken")->child_count(), library->broken().size());
}

}  // namespace
}  // namespace flare
