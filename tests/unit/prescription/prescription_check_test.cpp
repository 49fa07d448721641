// SPDX-License-Identifier: Apache-2.0
#include "core/prescription/prescription_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <ostream>

#include "core/optics/lens.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

// The seed lens with provenance and figures: nothing to find.
Prescription Honest() {
    Prescription lens = testing::SeedLens();
    lens.source = "a table";
    lens.design_focal_mm = 50.0;
    lens.design_f_number = 2.0;
    return lens;
}

TEST(PrescriptionCheck, AnHonestFileHasNoFindings) {
    for (const Finding& finding : CheckPrescription(Honest())) ADD_FAILURE() << finding.message;
}

struct Lie {
    const char* what;
    std::function<void(Prescription&)> tell;
    Severity severity;
    const char* code;
    const char* where;
    const char* says;
};

void PrintTo(const Lie& lie, std::ostream* out) {
    *out << lie.what;
}

class FoundLie : public ::testing::TestWithParam<Lie> {};

TEST_P(FoundLie, IsNamedWithPlaceAndAmount) {
    Prescription lens = Honest();
    GetParam().tell(lens);
    const std::vector<Finding> findings = CheckPrescription(lens);
    const auto found = std::find_if(findings.begin(), findings.end(), [](const Finding& finding) {
        return finding.code == GetParam().code;
    });
    ASSERT_NE(found, findings.end());
    EXPECT_EQ(found->severity, GetParam().severity);
    EXPECT_EQ(found->where, GetParam().where);
    EXPECT_NE(found->message.find(GetParam().says), std::string::npos) << found->message;
}

void SetSensor(Prescription& lens, double gap_mm) {
    lens.surfaces.back().gap_given = true;
    lens.surfaces.back().gap_mm = gap_mm;
}

// A biconcave lens: its focus is virtual.
void Diverge(Prescription& lens) {
    lens.surfaces = {testing::Stop(1.0, 5.0), testing::Sphere(-50.0, 2.0, 1.5, 60.0, 10.0),
                     testing::Sphere(50.0, 0.0, 1.0, 0.0, 10.0)};
    lens.surfaces[2].gap_given = false;
    lens.surfaces[2].where = "#2";
}

void SetUnknownGlass(Prescription& lens) {
    lens.surfaces[0].glass = "N-BK99";
    lens.surfaces[0].nd.reset();
    lens.surfaces[0].vd.reset();
}

void BendTooFar(Prescription& lens) {
    lens.surfaces[1].kind = SurfaceKind::kAsphere;
    lens.surfaces[1].asphere = {1e-2};
}

void TakeGlassOut(Prescription& lens) {
    for (SurfacePrescription& surface : lens.surfaces) {
        surface.nd.reset();
        surface.vd.reset();
    }
}

constexpr Severity kWarning = Severity::kWarning;
constexpr Severity kError = Severity::kError;

INSTANTIATE_TEST_SUITE_P(
    Table, FoundLie,
    ::testing::Values(
        Lie{"EFL 2 % off", [](Prescription& l) { l.design_focal_mm = 49.37; }, kWarning, "efl", "",
            "+2.00 %"},
        Lie{"EFL 7 % off", [](Prescription& l) { l.design_focal_mm = 54.1; }, kError, "efl", "",
            "-6.92 %"},
        Lie{"f-number 5 % off", [](Prescription& l) { l.design_f_number = 2.137; }, kWarning,
            "f_number", "", "-5.00 %"},
        Lie{"diameters for semi-diameters",
            [](Prescription& l) { l.surfaces[5].semi_diameter_mm = 17.1; }, kError, "f_number", "",
            "1.01508 by the table but 2 by design"},
        Lie{"rims narrower than the stop",
            [](Prescription& l) { l.surfaces[2].semi_diameter_mm = 9.0; }, kWarning, "rim", "",
            "24.8051"},
        Lie{"sensor 0.5 mm behind the focus", [](Prescription& l) { SetSensor(l, 36.6059); },
            kWarning, "focus", "#10", "0.499995 mm behind"},
        Lie{"sensor 0.5 mm in front of the focus", [](Prescription& l) { SetSensor(l, 35.6059); },
            kWarning, "focus", "#10", "in front of"},
        Lie{"faces that cross", [](Prescription& l) { l.surfaces[0].gap_mm = 1.5; }, kWarning,
            "overlap", "#1", "surfaces 0 and 1 overlap by 0.3879"},
        Lie{"a stop inside the next glass", [](Prescription& l) { l.surfaces[5].gap_mm = 2.0; },
            kWarning, "overlap", "#6", "surfaces 5 and 6 overlap by 0.7"},
        Lie{"an element without an edge",
            [](Prescription& l) { l.surfaces[10].semi_diameter_mm = 16.0; }, kWarning,
            "edge_thickness", "#9", "no edge"},
        Lie{"glass without V", [](Prescription& l) { l.surfaces[2].vd.reset(); }, kWarning,
            "v_number", "#2", "without dispersion"},
        Lie{"nearly a hemisphere", [](Prescription& l) { l.surfaces[4].semi_diameter_mm = 12.7; },
            kWarning, "semi_diameter", "#4", "99.6"},
        Lie{"more than a hemisphere", [](Prescription& l) { l.surfaces[4].semi_diameter_mm = 13; },
            kError, "semi_diameter", "#4", "12.75"},
        Lie{"no stop", [](Prescription& l) { l.surfaces.erase(l.surfaces.begin() + 5); }, kError,
            "no_stop", "", "no aperture stop"},
        Lie{"no source", [](Prescription& l) { l.source.clear(); }, kWarning, "source", "",
            "source"},
        Lie{"no design", [](Prescription& l) { l.design_focal_mm.reset(); }, kWarning, "design", "",
            "focal_mm"},
        Lie{"a name with blanks", [](Prescription& l) { l.name = "My Lens"; }, kWarning, "name", "",
            "My Lens"},
        Lie{"an index below 1", [](Prescription& l) { l.surfaces[2].nd = 0.9; }, kError, "index",
            "#2", "0.9"},
        Lie{"a gap below 0", [](Prescription& l) { l.surfaces[3].gap_mm = -1.0; }, kError, "gap",
            "#3", "-1"},
        Lie{"a V-number of no glass", [](Prescription& l) { l.surfaces[0].vd = 4.71; }, kError,
            "v_number", "#0", "4.71"},
        Lie{"a glass nobody makes", SetUnknownGlass, kError, "glass", "#0", "N-BK99"},
        Lie{"a glass and its index", [](Prescription& l) { l.surfaces[0].glass = "SCHOTT N-BK7"; },
            kError, "glass", "#0", "together with nd"},
        Lie{"a radius too small to be one", [](Prescription& l) { l.surfaces[7].radius_mm = 1e-9; },
            kError, "radius", "#7", "1e-09"},
        Lie{"a stop with a radius", [](Prescription& l) { l.surfaces[5].radius_mm = 40.0; }, kError,
            "radius", "#5", "flat"},
        Lie{"a rim of no width", [](Prescription& l) { l.surfaces[6].semi_diameter_mm = 0.0; },
            kError, "semi_diameter", "#6", "semi-diameter 0 mm"},
        Lie{"a conic constant of a sphere", [](Prescription& l) { l.surfaces[1].conic = -1.0; },
            kError, "asphere", "#1", "sphere"},
        Lie{"an asphere off by a power of ten", BendTooFar, kError, "asphere", "#1",
            "wrong by a power of ten"},
        Lie{"a stop between air and glass", [](Prescription& l) { l.surfaces[5].nd = 1.5; }, kError,
            "stop_medium", "#5", "a stop does not refract"},
        Lie{"a coated stop", [](Prescription& l) { l.surfaces[5].coating = "mgf2-550"; }, kError,
            "coating", "#5", "nothing to coat"},
        Lie{"a coating nobody knows", [](Prescription& l) { l.surfaces[0].coating = "magic"; },
            kError, "coating", "#0", "magic"},
        Lie{"a mirror that is no sensor", [](Prescription& l) { l.surfaces[1].reflectance = 0.5; },
            kError, "sensor", "#1", "reflectance"},
        Lie{"two stops",
            [](Prescription& l) { l.surfaces.insert(l.surfaces.begin() + 5, l.surfaces[5]); },
            kError, "several_stops", "#5", "a second aperture stop"},
        Lie{"glass up to the sensor", [](Prescription& l) { l.surfaces.back().nd = 1.5; }, kError,
            "last_medium", "#10", "1.5"},
        Lie{"no glass at all", TakeGlassOut, kError, "no_glass", "", "refracts"},
        Lie{"a hundred and ten surfaces",
            [](Prescription& l) { l.surfaces.insert(l.surfaces.begin(), 99, l.surfaces[1]); },
            kError, "surface_count", "", "110"},
        Lie{"no surface", [](Prescription& l) { l.surfaces.clear(); }, kError, "no_surface", "",
            "no surfaces"},
        Lie{"a sensor in the glass", [](Prescription& l) { SetSensor(l, 0.0); }, kError, "gap",
            "#10", "touches"},
        Lie{"a virtual focus", Diverge, kError, "first_order", "#2",
            "in front of the last vertex"}));

TEST(PrescriptionCheck, ErrorsComeFirstAndNoneHidesAnother) {
    Prescription lens = Honest();
    lens.source.clear();
    lens.surfaces[2].nd = 0.5;
    lens.surfaces[3].gap_mm = -1.0;
    const std::vector<Finding> findings = CheckPrescription(lens);
    ASSERT_EQ(findings.size(), 3u);
    EXPECT_EQ(findings[0].code, "index");
    EXPECT_EQ(findings[1].code, "gap");
    EXPECT_EQ(findings[2].code, "source");
}

}  // namespace
}  // namespace flare
