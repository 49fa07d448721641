// SPDX-License-Identifier: Apache-2.0
#include "core/optics/lens_coatings.h"

#include <gtest/gtest.h>

#include "core/optics/lens.h"
#include "core/optics/prescription_faults.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::SeedLens;

const Coating& CoatingOn(const Lens& lens, std::size_t surface) {
    return lens.surfaces()[surface].coating;
}

CoatingDefinitions Amber() {
    CoatingDefinitions own;
    own["amber"] = *CoatingDesign::Stack("amber", {{1.38, 82.0}, {*MaterialByName("ZrO2"), 20.0}});
    return own;
}

TEST(LensCoatings, ADesignIsLaidForTheGlassUnderIt) {
    Prescription prescription = SeedLens();
    prescription.default_coating = "v-550";
    const auto lens = *Lens::Build(prescription);
    for (const std::size_t face : {0U, 1U, 2U, 4U, 6U, 8U, 9U, 10U}) {
        const int i = static_cast<int>(face);
        const double before = lens->MediumBefore(i).Index(550.0);
        const double behind = lens->MediumBehind(i).Index(550.0);
        EXPECT_EQ(CoatingOn(*lens, face).layers.size(), 2U);
        EXPECT_LT(ReflectionOf(CoatingOn(*lens, face), lens->surfaces()[face].dense_in_front,
                               before, behind, 1.0, 550.0)
                      .reflectance,
                  1e-12)
            << face;
    }
    EXPECT_NE(CoatingOn(*lens, 0).layers, CoatingOn(*lens, 4).layers) << "other glass, other V";
}

TEST(LensCoatings, OfTheLensItselfAreFoundByName) {
    Prescription prescription = SeedLens();
    prescription.surfaces[2].coating = "amber";
    EXPECT_FALSE(Lens::Build(prescription).ok());
    prescription.coatings = Amber();
    const auto lens = *Lens::Build(prescription);
    EXPECT_EQ(CoatingOn(*lens, 2).layers, prescription.coatings["amber"].layers());
    EXPECT_EQ(CoatingOn(*lens, 0).name, "mgf2-550");
}

TEST(LensCoatings, UnknownNamesAreFaultsThatListTheKnownOnes) {
    Prescription prescription = SeedLens();
    prescription.coatings = Amber();
    prescription.surfaces[4].coating = "gold";
    prescription.surfaces[4].where = "line 40, column 1";
    const std::vector<PrescriptionFault> faults = FindFaults(prescription);
    ASSERT_EQ(faults.size(), 1U);
    EXPECT_EQ(faults[0].code, "coating");
    EXPECT_EQ(faults[0].where, "line 40, column 1");
    for (const char* part : {"surface 4", "gold", "broadband-NNN", "amber"}) {
        EXPECT_NE(faults[0].message.find(part), std::string::npos) << faults[0].message;
    }
}

// A request's "coatings": NAME.
TEST(WithCoatings, OneNameGoesOnEveryAirFace) {
    Prescription prescription = SeedLens();
    prescription.surfaces[0].coating = "bare";
    prescription.surfaces[3].coating = "mgf2-600";
    const auto lens = *Lens::Build(prescription);
    const auto multi = *lens->WithCoatings({"multi-550", {}, {}});
    for (const std::size_t face : {0U, 1U, 2U, 4U, 6U, 8U, 9U, 10U}) {
        EXPECT_EQ(CoatingOn(*multi, face).name, "multi-550") << face;
    }
    EXPECT_EQ(CoatingOn(*multi, 3).name, "mgf2-600") << "a cemented face keeps its own";
    EXPECT_TRUE(CoatingOn(*multi, 7).bare());
    EXPECT_TRUE(CoatingOn(*multi, 5).bare()) << "the stop";
    EXPECT_EQ(CoatingOn(*lens, 1).name, "mgf2-550") << "the lens itself stays as it was";

    EXPECT_EQ(multi->geometry_fingerprint(), lens->geometry_fingerprint());
    EXPECT_NE(multi->fingerprint(), lens->fingerprint());
    // The prescription says what lies there: built anew it is the same lens.
    EXPECT_EQ((*Lens::Build(multi->prescription()))->fingerprint(), multi->fingerprint());
}

// A request's "coatings": {"default": NAME, "surfaces": {"3": NAME}}.
TEST(WithCoatings, SingleSurfacesGoBeforeTheDefault) {
    const auto lens = *Lens::Build(SeedLens());
    const auto some = *lens->WithCoatings({"broadband-550", {{0, "none"}, {3, "v-500"}}, {}});
    EXPECT_TRUE(CoatingOn(*some, 0).bare());
    EXPECT_EQ(CoatingOn(*some, 3).name, "v-500");
    EXPECT_EQ(CoatingOn(*some, 1).name, "broadband-550");
    const auto one = *lens->WithCoatings({{}, {{10, "amber"}}, Amber()});
    EXPECT_EQ(CoatingOn(*one, 10).layers.size(), 2U);
    EXPECT_EQ(CoatingOn(*one, 9).name, "mgf2-550");
    EXPECT_EQ((*Lens::Build(one->prescription()))->fingerprint(), one->fingerprint());
}

TEST(WithCoatings, NothingAskedIsTheSameLensAndNoneIsBareGlass) {
    const auto lens = *Lens::Build(SeedLens());
    EXPECT_EQ((*lens->WithCoatings({}))->fingerprint(), lens->fingerprint());
    EXPECT_EQ((*lens->WithCoatings({"none", {}, {}}))->fingerprint(),
              lens->WithBareGlass()->fingerprint());
}

TEST(WithCoatings, ABadNameOrSurfaceIsNamed) {
    const auto lens = *Lens::Build(SeedLens());
    struct Bad {
        CoatingOverride coatings;
        const char* where;
        const char* says;
    };
    for (const Bad& bad : {Bad{{"gold", {}, {}}, "/default", "gold"},
                           Bad{{{}, {{0, "none"}, {4, "v-9"}}, {}}, "/surfaces/4", "v-NNN"},
                           Bad{{{}, {{5, "none"}}, {}}, "/surfaces/5", "stop"},
                           Bad{{{}, {{11, "none"}}, {}}, "/surfaces/11", "0 to 10"},
                           Bad{{{}, {{-1, "none"}}, {}}, "/surfaces/-1", "no surface -1"}}) {
        const auto made = lens->WithCoatings(bad.coatings);
        ASSERT_FALSE(made.ok()) << bad.where;
        EXPECT_EQ(made.error().code, "bad_value");
        EXPECT_EQ(made.error().where, bad.where);
        EXPECT_NE(made.error().message.find(bad.says), std::string::npos) << made.error().message;
    }
}

}  // namespace
}  // namespace flare
