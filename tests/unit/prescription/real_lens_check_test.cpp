// SPDX-License-Identifier: Apache-2.0
//
// The lint of aspheric, anamorphic and zoom lenses: what it finds, where, and that it is silent on
// sound ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <ostream>

#include "core/prescription/prescription_check.h"
#include "tests/support/anamorphic_lens.h"
#include "tests/support/zoom_lens.h"

namespace flare {
namespace {

Prescription Honest(Prescription lens) {
    lens.source = "a table";
    const testing::TableFigures figures = testing::FiguresOf(lens);
    lens.design_focal_mm = figures.efl_mm;
    lens.design_f_number = figures.f_number;
    return lens;
}

// The zoom with nominal lengths met and in focus.
Prescription HonestZoom() {
    Prescription zoom = testing::Zoom();
    for (std::size_t i = 0; i < zoom.states.focal_mm.size(); ++i) {
        Prescription at = zoom;
        at.surfaces[1].gap_mm = zoom.states.gaps[0].values[i];
        at.surfaces[2].semi_diameter_mm = zoom.states.semi_diameters[0].values[i];
        const testing::TableFigures figures = testing::FiguresOf(at);
        zoom.states.focal_mm[i] = figures.efl_mm;
        zoom.states.f_number[i] = figures.f_number;
        zoom.states.gaps[1].values[i] = figures.bfl_mm;
    }
    zoom.surfaces[4].gap_mm = zoom.states.gaps[1].values[0];
    // No rim may narrow the beam.
    zoom.surfaces[0].semi_diameter_mm = zoom.surfaces[1].semi_diameter_mm = 24.0;
    return Honest(zoom);
}

Prescription HonestFocus() {
    Prescription lens = testing::InnerFocusing();
    lens.surfaces[0].semi_diameter_mm = lens.surfaces[1].semi_diameter_mm = 24.0;
    // The gap that puts the image on the sensor.
    const double sensor = testing::FiguresOf(lens).bfl_mm;
    for (std::size_t k = 1; k < 3; ++k) {
        double lo = 1.0, hi = 60.0;
        for (int i = 0; i < 100; ++i) {
            Prescription at = lens;
            at.surfaces[1].gap_mm = 0.5 * (lo + hi);
            const double image = testing::ImageOfObject(at, sensor, 1e3 * lens.states.focus_m[k]);
            (image > sensor ? lo : hi) = at.surfaces[1].gap_mm;
        }
        lens.states.gaps[0].values[k] = lo;
    }
    return Honest(lens);
}

Prescription HonestAsphere() {
    Prescription lens = testing::SeedLens();
    lens.surfaces[0].kind = SurfaceKind::kAsphere;
    lens.surfaces[0].conic = -0.3;
    lens.surfaces[0].asphere = {1e-7, 1e-10};
    return Honest(lens);
}

// x and y as unlike as can be in power, but of one focus: cylinders within an afocal front.
Prescription HonestAnamorphic() {
    Prescription lens = testing::PlanoConvex();
    lens.surfaces[1].vd = 60.0;
    lens = testing::BehindAfocalPair(lens, 1.0, 14.0);
    Prescription honest = Honest(lens);
    const double x = testing::FiguresOf(lens, Section::kX).f_number;
    honest.design_f_number = std::sqrt(x * *honest.design_f_number);
    return honest;
}

TEST(RealLensCheck, SoundLensesHaveNoFindings) {
    for (const Prescription& lens :
         {HonestZoom(), HonestFocus(), HonestAsphere(), HonestAnamorphic()}) {
        for (const Finding& finding : CheckPrescription(lens)) {
            ADD_FAILURE() << lens.name << ": " << finding.code << ": " << finding.message;
        }
    }
}

TEST(RealLensCheck, TheDesignsFocalLengthIsThatOfItsSection) {
    Prescription lens = HonestAnamorphic();
    lens.design_section = Section::kX;
    lens.design_focal_mm = testing::FiguresOf(lens, Section::kX).efl_mm;
    EXPECT_NEAR(*lens.design_focal_mm, 50.0, 1e-9);
    EXPECT_TRUE(CheckPrescription(lens).empty());
    lens.design_section = Section::kY;
    const std::vector<Finding> findings = CheckPrescription(lens);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].code, "efl");
    EXPECT_NE(findings[0].message.find("+100.00 %"), std::string::npos) << findings[0].message;
}

struct Lie {
    const char* what;
    std::function<Prescription()> lens;
    std::function<void(Prescription&)> tell;
    Severity severity;
    const char* code;
    const char* where;
    const char* says;
};

void PrintTo(const Lie& lie, std::ostream* out) {
    *out << lie.what;
}

class FoundRealLie : public ::testing::TestWithParam<Lie> {};

TEST_P(FoundRealLie, IsNamedOnceWithPlaceAndAmount) {
    Prescription lens = GetParam().lens();
    GetParam().tell(lens);
    const std::vector<Finding> findings = CheckPrescription(lens);
    const auto told = [](const Finding& finding) { return finding.code == GetParam().code; };
    ASSERT_EQ(std::count_if(findings.begin(), findings.end(), told), 1);
    const Finding& found = *std::find_if(findings.begin(), findings.end(), told);
    EXPECT_EQ(found.severity, GetParam().severity);
    EXPECT_EQ(found.where, GetParam().where);
    EXPECT_NE(found.message.find(GetParam().says), std::string::npos) << found.message;
}

constexpr Severity kWarning = Severity::kWarning;
constexpr Severity kError = Severity::kError;

void Scale(double& value, double by) {
    value *= by;
}

INSTANTIATE_TEST_SUITE_P(
    States, FoundRealLie,
    ::testing::Values(
        Lie{"a position's focal length 2 % off", HonestZoom,
            [](Prescription& l) { Scale(l.states.focal_mm[2], 1.0 / 1.02); }, kWarning, "efl", "",
            "the focal length in mm at 87.7941 mm is 89.55 by the table but 87.7941 by design "
            "(+2.00 %)"},
        Lie{"another position's gap", HonestZoom,
            [](Prescription& l) { l.states.gaps[0].values[3] = l.states.gaps[0].values[2]; },
            kError, "efl", "", "at 117.3 mm is 89.55"},
        Lie{"the first position's, where design names none", HonestZoom,
            [](Prescription& l) {
                l.design_focal_mm.reset();
                Scale(l.states.focal_mm[0], 1.03);
            },
            kWarning, "efl", "", "(-2.91 %)"},
        Lie{"a position's f-number 5 % off", HonestZoom,
            [](Prescription& l) { Scale(l.states.f_number[1], 1.0 / 1.05); }, kWarning, "f_number",
            "", "(+5.00 %)"},
        Lie{"a position's stop a diameter", HonestZoom,
            [](Prescription& l) { Scale(l.states.semi_diameters[0].values[3], 2.0); }, kError,
            "f_number", "", "(-50.00 %)"},
        Lie{"a position out of focus", HonestZoom,
            [](Prescription& l) { l.states.gaps[1].values[2] += 1.0; }, kWarning, "focus", "#4",
            "1 mm behind the paraxial focus at 89.55 mm"},
        Lie{"a near position out of focus", HonestFocus,
            [](Prescription& l) { l.states.gaps[0].values[2] += 0.5; }, kWarning, "focus", "#4",
            "focused to 1.2 m"},
        Lie{"groups that run into each other at one end", HonestZoom,
            [](Prescription& l) {
                l.states.gaps.push_back({3, {4.0, 4.0, 4.0, 0.5}, "#g"});
            },
            kWarning, "overlap", "#4", "surfaces 3 and 4 overlap by"},
        Lie{"a rim off its sphere at one end", HonestZoom,
            [](Prescription& l) {
                l.states.semi_diameters.push_back({3, {10.0, 10.0, 10.0, 23.0}, "#g"});
            },
            kError, "states", "#3", "at 117.3 mm: surface 3: the semi-diameter 23 mm"},
        Lie{"a table with a fault", HonestZoom,
            [](Prescription& l) { l.states.gaps[0].values.pop_back(); }, kError, "states", "#d",
            "needs 4 values"}));

INSTANTIATE_TEST_SUITE_P(
    Shapes, FoundRealLie,
    ::testing::Values(Lie{"an asphere with a slip of a digit", HonestAsphere,
                          [](Prescription& l) { l.surfaces[0].asphere[0] = 1e-4; }, kWarning,
                          "overlap", "#1", "surfaces 0 and 1 overlap"},
                      Lie{"too many coefficients", HonestAsphere,
                          [](Prescription& l) { l.surfaces[0].asphere.assign(9, 0.0); }, kError,
                          "asphere", "#0", "at most 8"},
                      Lie{"sections that focus apart", HonestAnamorphic,
                          [](Prescription& l) { l.surfaces[1].gap_mm += 2.0; }, kWarning,
                          "astigmatism", "", "the foci of the x and y sections lie"},
                      Lie{"cylinders that cross in their own section", HonestAnamorphic,
                          [](Prescription& l) { l.surfaces[2].gap_mm = 1.0; }, kWarning, "overlap",
                          "#3", "surfaces 2 and 3 overlap by 1"},
                      Lie{"rims that cut the beam", HonestAnamorphic,
                          [](Prescription& l) { l.surfaces[5].semi_diameter_mm = 4.5; }, kWarning,
                          "rim", "", "(10 % less)"}));

TEST(RealLensCheck, TolerancesOfTheFileStandInForTheLintsOwn) {
    Prescription lens = HonestZoom();
    Scale(lens.states.focal_mm[2], 1.0 / 1.02);
    Scale(lens.states.f_number[1], 1.0 / 1.05);
    lens.focal_tolerance = 0.021;
    lens.f_number_tolerance = 0.051;
    EXPECT_TRUE(CheckPrescription(lens).empty());
    lens.focal_tolerance = 0.001;
    lens.f_number_tolerance = 0.001;
    EXPECT_EQ(CheckPrescription(lens).size(), 2U);
    // A wide tolerance does not turn into an error what is within it.
    Scale(lens.states.focal_mm[2], 1.0 / 1.06);
    lens.f_number_tolerance = 0.06;
    lens.focal_tolerance = 0.10;
    EXPECT_TRUE(CheckPrescription(lens).empty());
}

}  // namespace
}  // namespace flare
