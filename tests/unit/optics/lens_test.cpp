// SPDX-License-Identifier: Apache-2.0
#include "core/optics/lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "core/optics/prescription_faults.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::Assemble;
using testing::PlanoConvex;
using testing::SeedLens;
using testing::Sphere;
using testing::Stop;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

struct BadLens {
    const char* what;
    std::function<void(Prescription&)> spoil;
    const char* where;
    const char* says;  // a part of the message
};

void PrintTo(const BadLens& lens, std::ostream* out) {
    *out << lens.what;
}

class RefusedLens : public ::testing::TestWithParam<BadLens> {};

TEST_P(RefusedLens, IsRefusedAtItsPlace) {
    Prescription prescription = SeedLens();
    GetParam().spoil(prescription);
    const auto lens = Lens::Build(prescription);
    ASSERT_FALSE(lens.ok());
    EXPECT_EQ(lens.error().code, "bad_lens");
    EXPECT_EQ(lens.error().where, GetParam().where);
    EXPECT_NE(lens.error().message.find(GetParam().says), std::string::npos)
        << lens.error().message;
}

void NoGlass(Prescription& lens) {
    for (SurfacePrescription& surface : lens.surfaces) surface.nd = surface.vd = std::nullopt;
}

// A biconcave lens: its focus is virtual.
void Diverge(Prescription& lens) {
    lens = Assemble("diverging", {Stop(1.0, 5.0), Sphere(-50.0, 2.0, 1.5, 0.0, 10.0),
                                  Sphere(50.0, 0.0, 1.0, 0.0, 10.0)});
}

void PlaneParallel(Prescription& lens) {
    lens = Assemble("plate", {Stop(1.0, 5.0), Sphere(0.0, 2.0, 1.5, 0.0, 10.0),
                              Sphere(0.0, 0.0, 1.0, 0.0, 10.0)});
}

void StopAtFocus(Prescription& lens) {
    lens = Assemble(
        "stop at focus",
        {Sphere(50.0, 6.0, 1.5, 0.0, 10.0), Sphere(0.0, 96.0, 1.0, 0.0, 10.0), Stop(50.0, 5.0),
         Sphere(50.0, 6.0, 1.5, 0.0, 10.0), Sphere(0.0, 0.0, 1.0, 0.0, 10.0)});
    lens.surfaces.back().gap_mm = 10.0;
    lens.surfaces.back().gap_given = true;
}

void TooMany(Prescription& lens) {
    while (lens.surfaces.size() <= 100)
        lens.surfaces.insert(lens.surfaces.begin(), lens.surfaces[0]);
}

INSTANTIATE_TEST_SUITE_P(
    Table, RefusedLens,
    ::testing::Values(
        BadLens{"nd NaN", [](Prescription& l) { l.surfaces[2].nd = kNan; }, "#2", "index"},
        BadLens{"nd infinite", [](Prescription& l) { l.surfaces[2].nd = kInf; }, "#2", "index"},
        BadLens{"nd 0.9", [](Prescription& l) { l.surfaces[2].nd = 0.9; }, "#2", "nd = 0.9"},
        BadLens{"nd 4.1", [](Prescription& l) { l.surfaces[2].nd = 4.1; }, "#2", "nd = 4.1"},
        BadLens{"vd 0", [](Prescription& l) { l.surfaces[2].vd = 0.0; }, "#2", "vd = 0"},
        BadLens{"vd -47", [](Prescription& l) { l.surfaces[2].vd = -47.0; }, "#2", "vd = -47"},
        BadLens{"vd 1e9", [](Prescription& l) { l.surfaces[2].vd = 1e9; }, "#2", "vd = 1e+09"},
        BadLens{"vd NaN", [](Prescription& l) { l.surfaces[2].vd = kNan; }, "#2", "vd"},
        BadLens{"vd in air", [](Prescription& l) { l.surfaces[1].vd = 50.0; }, "#1", "without nd"},
        BadLens{"gap -1", [](Prescription& l) { l.surfaces[3].gap_mm = -1.0; }, "#3", "gap -1"},
        BadLens{"gap NaN", [](Prescription& l) { l.surfaces[3].gap_mm = kNan; }, "#3", "gap"},
        BadLens{"gap 1e9", [](Prescription& l) { l.surfaces[3].gap_mm = 1e9; }, "#3", "gap"},
        BadLens{"radius NaN", [](Prescription& l) { l.surfaces[0].radius_mm = kNan; }, "#0",
                "not a number"},
        BadLens{"radius 1e-300", [](Prescription& l) { l.surfaces[0].radius_mm = 1e-300; }, "#0",
                "too small"},
        BadLens{"rim as wide as the sphere",
                [](Prescription& l) { l.surfaces[4].semi_diameter_mm = 12.75; }, "#4",
                "not below the radius"},
        BadLens{"rim wider than the sphere",
                [](Prescription& l) { l.surfaces[4].semi_diameter_mm = 18.0; }, "#4",
                "not below the radius"},
        BadLens{"rim of a negative radius",
                [](Prescription& l) { l.surfaces[6].semi_diameter_mm = 14.6; }, "#6",
                "not below the radius"},
        BadLens{"no rim", [](Prescription& l) { l.surfaces[4].semi_diameter_mm = 0.0; }, "#4",
                "semi-diameter 0"},
        BadLens{"rim NaN", [](Prescription& l) { l.surfaces[4].semi_diameter_mm = kNan; }, "#4",
                "semi-diameter"},
        BadLens{"no stop", [](Prescription& l) { l.surfaces.erase(l.surfaces.begin() + 5); }, "",
                "no aperture stop"},
        BadLens{"two stops", [](Prescription& l) { l.surfaces.push_back(Stop(1.0, 5.0)); }, "",
                "second aperture stop"},
        BadLens{"curved stop", [](Prescription& l) { l.surfaces[5].radius_mm = 100.0; }, "#5",
                "flat"},
        BadLens{"stop that refracts", [](Prescription& l) { l.surfaces[5].nd = 1.5; }, "#5",
                "does not refract"},
        BadLens{"coated stop", [](Prescription& l) { l.surfaces[5].coating = "mgf2-550"; }, "#5",
                "nothing to coat"},
        BadLens{"unknown coating", [](Prescription& l) { l.surfaces[0].coating = "gold"; }, "#0",
                "gold"},
        BadLens{"unknown default coating", [](Prescription& l) { l.default_coating = "gold"; }, "",
                "default_coating"},
        BadLens{"glass behind the lens", [](Prescription& l) { l.surfaces[10].nd = 1.5; }, "#10",
                "behind the last surface"},
        BadLens{"sensor touches the lens", [](Prescription& l) { l.surfaces[10].gap_given = true; },
                "#10", "touches"},
        BadLens{"sensor in front of the last vertex",
                [](Prescription& l) {
                    l.surfaces[10].gap_given = true;
                    l.surfaces[10].gap_mm = -2.0;
                },
                "#10", "gap -2"},
        BadLens{"virtual focus", Diverge, "#2", "in front of the last vertex"},
        BadLens{"afocal without a sensor", PlaneParallel, "#2", "afocal"},
        BadLens{"stop at a focus", StopAtFocus, "#2", "no f-number"},
        BadLens{"no glass", NoGlass, "", "no surface of the lens refracts"},
        BadLens{"no surfaces", [](Prescription& l) { l.surfaces.clear(); }, "", "no surfaces"},
        BadLens{"101 surfaces", TooMany, "", "limit is 100"}));

TEST(Lens, AfocalWithASensorDistanceIsALens) {
    Prescription prescription;
    PlaneParallel(prescription);
    prescription.surfaces.back().gap_mm = 30.0;
    prescription.surfaces.back().gap_given = true;
    const auto lens = Lens::Build(prescription);
    ASSERT_TRUE(lens.ok()) << lens.error().message;
    EXPECT_TRUE(std::isinf((*lens)->first_order().efl_mm));
    EXPECT_EQ((*lens)->sensor_z_mm(), 33.0);
    EXPECT_TRUE(std::isfinite((*lens)->first_order().projection_distance_mm));
}

TEST(Lens, StopMayBeFirstOrLast) {
    Prescription last = Assemble("stop last", {Sphere(50.0, 6.0, 1.5, 0.0, 10.0),
                                               Sphere(0.0, 2.0, 1.0, 0.0, 10.0), Stop(0.0, 5.0)});
    const auto lens = Lens::Build(last);
    ASSERT_TRUE(lens.ok()) << lens.error().message;
    EXPECT_EQ((*lens)->stop_index(), 2);
    // The stop is its own exit pupil; the focus is 94 mm behind it.
    EXPECT_NEAR((*lens)->first_order().exit.z_mm, 8.0, 1e-12);
    EXPECT_NEAR((*lens)->first_order().exit.diameter_mm, 10.0, 1e-12);
    EXPECT_NEAR((*lens)->first_order().bfl_mm, 94.0, 1e-12);
    EXPECT_TRUE(Lens::Build(PlanoConvex()).ok());
}

TEST(Lens, StopInsideGlassRepeatsTheGlass) {
    Prescription lens = Assemble(
        "stop in glass",
        {Sphere(50.0, 3.0, 1.5, 60.0, 10.0), Stop(3.0, 5.0), Sphere(0.0, 0.0, 1.0, 0.0, 10.0)});
    EXPECT_FALSE(Lens::Build(lens).ok());
    lens.surfaces[1].nd = 1.5;
    lens.surfaces[1].vd = 60.0;
    const auto built = Lens::Build(lens);
    ASSERT_TRUE(built.ok()) << built.error().message;
    EXPECT_NEAR((*built)->first_order().efl_mm, 100.0, 1e-12);
}

TEST(Lens, AFlatSphereIsAPlaneHoweverItIsWritten) {
    const auto flat_power = [](double radius) {
        Prescription lens = PlanoConvex();
        lens.surfaces[2].kind = SurfaceKind::kSphere;
        lens.surfaces[2].radius_mm = radius;
        return (*Lens::Build(lens))->first_order().efl_mm;
    };
    EXPECT_NEAR(flat_power(0.0), 100.0, 1e-12);
    EXPECT_NEAR(flat_power(kInf), 100.0, 1e-12);
    EXPECT_NEAR(flat_power(1e30), 100.0, 1e-12);
    EXPECT_NEAR(flat_power(-1e30), 100.0, 1e-12);
}

TEST(Lens, ZeroGapAndIndexOneAreAllowed) {
    Prescription lens = SeedLens();
    lens.surfaces[1].gap_mm = 0.0;
    lens.surfaces[1].nd = 1.0;
    EXPECT_TRUE(Lens::Build(lens).ok());
}

TEST(Lens, DefaultCoatingLiesOnAirFacesOnly) {
    const auto lens = *Lens::Build(SeedLens());
    for (const int air_face : {0, 1, 2, 4, 6, 8, 9, 10}) {
        EXPECT_EQ(lens->surfaces()[static_cast<std::size_t>(air_face)].coating.name, "mgf2-550")
            << air_face;
    }
    for (const int cemented_or_stop : {3, 5, 7}) {
        EXPECT_TRUE(lens->surfaces()[static_cast<std::size_t>(cemented_or_stop)].coating.bare())
            << cemented_or_stop;
    }
    // Glass in front, air behind: light towards +z meets the layers from the glass side.
    EXPECT_FALSE(lens->surfaces()[0].dense_in_front);
    EXPECT_TRUE(lens->surfaces()[1].dense_in_front);
    EXPECT_TRUE(lens->surfaces()[10].dense_in_front);
}

TEST(Lens, ASurfacesOwnCoatingWins) {
    Prescription prescription = SeedLens();
    prescription.surfaces[0].coating = "bare";
    prescription.surfaces[3].coating = "mgf2-600";
    const auto lens = *Lens::Build(prescription);
    EXPECT_TRUE(lens->surfaces()[0].coating.bare());
    EXPECT_EQ(lens->surfaces()[3].coating.name, "mgf2-600");
}

TEST(LensFingerprint, GeometryIgnoresCoatingsAndNames) {
    const auto lens = *Lens::Build(SeedLens());
    const auto bare = lens->WithBareGlass();
    for (const LensSurface& surface : bare->surfaces()) EXPECT_TRUE(surface.coating.bare());
    EXPECT_EQ(lens->geometry_fingerprint(), bare->geometry_fingerprint());
    EXPECT_NE(lens->fingerprint(), bare->fingerprint());
    Prescription renamed = SeedLens();
    renamed.name = "other";
    EXPECT_EQ((*Lens::Build(renamed))->fingerprint(), lens->fingerprint());
    // Bare by file and bare by request are one lens.
    Prescription uncoated = SeedLens();
    uncoated.default_coating = "none";
    EXPECT_EQ((*Lens::Build(uncoated))->fingerprint(), bare->fingerprint());
}

TEST(LensFingerprint, EverythingThatBendsOrClipsChangesTheGeometry) {
    const Fingerprint before = (*Lens::Build(SeedLens()))->geometry_fingerprint();
    const std::function<void(Prescription&)> changes[] = {
        [](Prescription& l) { l.surfaces[0].radius_mm += 1e-9; },
        [](Prescription& l) { l.surfaces[0].gap_mm += 1e-9; },
        [](Prescription& l) { l.surfaces[0].nd = 1.67 + 1e-9; },
        [](Prescription& l) { l.surfaces[0].vd = 47.1 + 1e-9; },
        [](Prescription& l) { l.surfaces[0].semi_diameter_mm += 1e-9; },
        [](Prescription& l) { l.surfaces[5].semi_diameter_mm += 1e-9; },
        [](Prescription& l) {
            l.surfaces[10].gap_given = true;
            l.surfaces[10].gap_mm = 36.0;
        },
    };
    for (const auto& change : changes) {
        Prescription lens = SeedLens();
        change(lens);
        EXPECT_NE((*Lens::Build(lens))->geometry_fingerprint(), before);
    }
}

TEST(PrescriptionFaults, AllAreFoundNotOnlyTheFirst) {
    Prescription lens = SeedLens();
    lens.surfaces[2].nd = 0.5;
    lens.surfaces[3].gap_mm = -1.0;
    lens.surfaces[4].semi_diameter_mm = 20.0;
    const std::vector<PrescriptionFault> faults = FindFaults(lens);
    ASSERT_EQ(faults.size(), 3u);
    EXPECT_EQ(faults[0].code, "index");
    EXPECT_EQ(faults[1].code, "gap");
    EXPECT_EQ(faults[2].code, "semi_diameter");
    EXPECT_TRUE(FindFaults(SeedLens()).empty());
}

}  // namespace
}  // namespace flare
