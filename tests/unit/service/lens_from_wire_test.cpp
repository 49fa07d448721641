// SPDX-License-Identifier: Apache-2.0
//
// The lens of a message: coated, zoomed and focused as asked, with errors at the client's field.
#include "server/translate/lens_from_wire.h"

#include <gtest/gtest.h>

#include <string>

namespace flare {
namespace {

constexpr char kSeed[] = "tronnier-double-gauss-50mm-f2";
constexpr char kZoom[] = "nikon-zoom-80-200mm-f2_8";

const LensLibrary& Library() {
    static const LensLibrary library = *LensLibrary::Load(FLARE_SOURCE_DIR "/lenses");
    return library;
}

wire::LensChoice Named(const std::string& name) {
    wire::LensChoice choice;
    choice.name = name;
    return choice;
}

LensInState LensOf(const wire::LensChoice& choice) {
    const Result<LensInState> lens = LensFromWire(choice, Library());
    EXPECT_TRUE(lens) << lens.error().where << " " << lens.error().message;
    return *lens;
}

const Coating& CoatingOf(const LensInState& lens, std::size_t surface) {
    return lens.lens->surfaces()[surface].coating;
}

TEST(LensFromWire, LeavesTheLensAsItIsWhereNothingIsAsked) {
    const LensInState lens = LensOf(Named(kSeed));
    EXPECT_EQ(lens.lens->fingerprint(), (*Library().Find(kSeed))->fingerprint());
    EXPECT_EQ(lens.state, LensState{});
    EXPECT_TRUE(lens.clamped.empty());
}

// A quarter wave of n 1.38 at NNN nm has the thickness NNN / (4 * 1.38).
TEST(LensFromWire, PutsANamedCoatingOnEveryFaceBetweenAirAndGlass) {
    wire::LensChoice choice = Named(kSeed);
    choice.coatings.default_name = "mgf2-500";
    const LensInState lens = LensOf(choice);
    ASSERT_EQ(CoatingOf(lens, 0).layers.size(), 1u);
    EXPECT_NEAR(CoatingOf(lens, 0).layers[0].thickness_nm, 500.0 / (4.0 * 1.38), 1e-9);
    EXPECT_TRUE(CoatingOf(lens, 3).bare()) << "cemented";
    EXPECT_TRUE(CoatingOf(lens, 5).bare()) << "the stop";
    EXPECT_EQ(lens.lens->geometry_fingerprint(), (*Library().Find(kSeed))->geometry_fingerprint());
}

TEST(LensFromWire, PutsCoatingsOnSingleSurfaces) {
    wire::LensChoice choice = Named(kSeed);
    choice.coatings.surfaces = {{0, "bare"}, {3, "mgf2-500"}};
    const LensInState lens = LensOf(choice);
    EXPECT_TRUE(CoatingOf(lens, 0).bare());
    EXPECT_NEAR(CoatingOf(lens, 1).layers.at(0).thickness_nm, 99.64, 0.01) << "the lens's own";
    EXPECT_NEAR(CoatingOf(lens, 3).layers.at(0).thickness_nm, 90.58, 0.01) << "cemented, but asked";
}

TEST(LensFromWire, KeepsTheCoatingsInAnotherState) {
    wire::LensChoice choice = Named(kSeed);
    choice.coatings.default_name = "mgf2-500";
    choice.focus_m = 1.0;
    EXPECT_NEAR(CoatingOf(LensOf(choice), 0).layers.at(0).thickness_nm, 90.58, 0.01);
    choice.coatings = {};
    choice.coatings.none = true;
    EXPECT_TRUE(CoatingOf(LensOf(choice), 0).bare());
}

TEST(LensFromWire, NamesTheFieldOfABadCoating) {
    const struct {
        const char* name;
        wire::Coatings coatings;
        const char* where;
    } table[] = {
        {"name", {false, "magic", {}, "/coatings"}, "/coatings"},
        {"default", {false, "magic", {}, "/coatings/default"}, "/coatings/default"},
        {"surface", {false, {}, {{3, "magic"}}, ""}, "/coatings/surfaces/3"},
        {"no such surface", {false, {}, {{11, "mgf2-550"}}, ""}, "/coatings/surfaces/11"},
        {"the stop", {false, {}, {{5, "mgf2-550"}}, ""}, "/coatings/surfaces/5"},
    };
    for (const auto& row : table) {
        wire::LensChoice choice = Named(kSeed);
        choice.coatings = row.coatings;
        const Result<LensInState> lens = LensFromWire(choice, Library());
        ASSERT_FALSE(lens) << row.name;
        EXPECT_EQ(lens.error().code, "bad_value") << row.name;
        EXPECT_EQ(lens.error().where, row.where) << row.name;
    }
}

TEST(LensFromWire, RefusesToCoatTheSensor) {
    wire::LensChoice choice = Named(kSeed);
    Prescription file = (*Library().Find(kSeed))->prescription();
    SurfacePrescription sensor;
    sensor.kind = SurfaceKind::kSensor;
    sensor.reflectance = 0.1;
    sensor.semi_diameter_mm = 21.6;
    file.surfaces.push_back(sensor);
    const auto lens = Lens::Build(file);
    ASSERT_TRUE(lens) << lens.error().message;
    choice.coatings.surfaces = {{11, "mgf2-550"}};
    const auto coated = LensAsAsked(*lens, choice.coatings, {});
    ASSERT_FALSE(coated);
    EXPECT_EQ(coated.error().where, "/coatings/surfaces/11");
}

TEST(LensFromWire, ZoomsALens) {
    wire::LensChoice choice = Named(kZoom);
    const LensInState wide = LensOf(choice);
    choice.zoom_mm = 135.0;
    const LensInState mid = LensOf(choice);
    EXPECT_EQ(wide.state.zoom_mm, 80.0);
    EXPECT_EQ(mid.state.zoom_mm, 135.0);
    EXPECT_TRUE(mid.clamped.empty());
    EXPECT_NEAR(mid.lens->first_order().efl_mm, 135.0, 0.2);
    EXPECT_NE(mid.lens->geometry_fingerprint(), wide.lens->geometry_fingerprint());
}

TEST(LensFromWire, ClampsAStateThatTheLensHasNot) {
    wire::LensChoice choice = Named(kZoom);
    choice.zoom_mm = 400.0;
    const LensInState lens = LensOf(choice);
    EXPECT_EQ(lens.state.zoom_mm, 200.0);
    ASSERT_EQ(lens.clamped.size(), 1u);
    EXPECT_EQ(lens.clamped[0].field, "zoom_mm");
    EXPECT_EQ(lens.clamped[0].from, 400.0);
    EXPECT_EQ(lens.clamped[0].to, 200.0);
}

TEST(LensFromWire, FocusesALens) {
    wire::LensChoice choice = Named(kSeed);
    choice.focus_m = 1.0;
    const LensInState near = LensOf(choice);
    const Lens& far = **Library().Find(kSeed);
    EXPECT_NEAR(near.lens->sensor_z_mm() - far.sensor_z_mm(), 2.8117, 1e-4);
    EXPECT_NE(near.lens->fingerprint(), far.fingerprint());
}

// A traced mesh is found again by the geometry's fingerprint: to the last bit, in every lens.
TEST(LensFromWire, KeepsTheGeometryWhereFocusingMovesTheSensorAlone) {
    int lenses = 0;
    for (const std::string& name : Library().Names()) {
        const StateTable& states = (*Library().Find(name))->prescription().states;
        if (!states.focus_m.empty()) continue;
        ++lenses;
        wire::LensChoice choice = Named(name);
        if (!states.focal_mm.empty()) choice.zoom_mm = 1.1 * states.focal_mm.front();
        const Fingerprint far = LensOf(choice).lens->geometry_fingerprint();
        for (const double focus_m : {0.7, 1.0, 2.5, 10.0, 33.0, 1e6}) {
            choice.focus_m = focus_m;
            EXPECT_EQ(LensOf(choice).lens->geometry_fingerprint(), far) << name << focus_m;
        }
    }
    EXPECT_GE(lenses, 10);
}

}  // namespace
}  // namespace flare
