// SPDX-License-Identifier: Apache-2.0
//
// Focus and zoom against first-order optics computed another way (support/paraxial_table.h).
#include "core/optics/lens_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/base/check.h"
#include "core/optics/paraxial.h"
#include "tests/support/paraxial_table.h"
#include "tests/support/random.h"
#include "tests/support/seed_lens.h"
#include "tests/support/zoom_lens.h"

namespace flare {
namespace {

using testing::FiguresOf;
using testing::ImageOfObject;
using testing::InnerFocusing;
using testing::kPositions;
using testing::Zoom;
using testing::ZoomPosition;

constexpr double kInf = std::numeric_limits<double>::infinity();

std::shared_ptr<const Lens> Built(const Prescription& prescription) {
    const auto lens = Lens::Build(prescription);
    FLARE_CHECK(lens.ok());
    return *lens;
}

LensInState Set(const Prescription& prescription, const LensState& state) {
    const Result<LensInState> set = SetState(Built(prescription), state);
    if (!set) CheckFailed(set.error().message.c_str(), __FILE__, __LINE__);
    return *set;
}

// ---- monotone interpolation

TEST(Monotone, IsExactAtItsPointsAndConstantBeyond) {
    const std::vector<double> x{0.0, 0.3, 1.0, 4.0}, y{2.0, -1.0, -1.0, 7.5};
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_EQ(MonotoneAt(x, y, x[i]), y[i]);
    EXPECT_EQ(MonotoneAt(x, y, -5.0), 2.0);
    EXPECT_EQ(MonotoneAt(x, y, 5.0), 7.5);
    // Level data stay level.
    EXPECT_EQ(MonotoneAt(x, y, 0.7), -1.0);
}

TEST(Monotone, IsALineThroughTwoPointsAndThroughPointsOnALine) {
    for (double at = 1.0; at <= 3.0; at += 0.125) {
        EXPECT_NEAR(MonotoneAt({1.0, 3.0}, {5.0, -1.0}, at), 8.0 - 3.0 * at, 1e-14);
        EXPECT_NEAR(MonotoneAt({1.0, 1.4, 2.9, 3.0}, {5.0, 3.8, -0.7, -1.0}, at), 8.0 - 3.0 * at,
                    1e-14);
    }
}

TEST(Monotone, NeverOvershootsAndHasNoKinks) {
    testing::Random random(17);
    for (int round = 0; round < 400; ++round) {
        const int count = 2 + random.Below(8);
        // Rising, falling or neither; with steep and level stretches.
        const int kind = round % 3;
        std::vector<double> x{random.Uniform(-2.0, 2.0)}, y{random.Uniform(-9.0, 9.0)};
        for (int i = 1; i < count; ++i) {
            x.push_back(x.back() + std::pow(10.0, random.Uniform(-2.0, 1.0)));
            const double step =
                random.Below(5) == 0 ? 0.0 : std::pow(10.0, random.Uniform(-3.0, 1.5));
            const bool up = kind == 0 || (kind == 2 && random.Below(2) == 0);
            y.push_back(y.back() + (up ? step : -step));
        }
        for (std::size_t i = 0; i + 1 < x.size(); ++i) {
            const double lo = std::min(y[i], y[i + 1]), hi = std::max(y[i], y[i + 1]);
            const double slack = 1e-12 * (1.0 + std::abs(lo) + std::abs(hi));
            const bool up = y[i + 1] >= y[i];
            double before = y[i];
            for (int k = 1; k <= 64; ++k) {
                const double at = x[i] + (x[i + 1] - x[i]) * k / 64.0;
                const double value = MonotoneAt(x, y, at);
                EXPECT_GE(value, lo - slack);
                EXPECT_LE(value, hi + slack);
                EXPECT_GE(up ? value - before : before - value, -slack);
                before = value;
            }
            if (i == 0) continue;
            // One slope from both sides of a point, by second-order one-sided differences.
            const auto slope = [&](double h) {
                return (-3.0 * y[i] + 4.0 * MonotoneAt(x, y, x[i] + h) -
                        MonotoneAt(x, y, x[i] + 2.0 * h)) /
                       (2.0 * h);
            };
            const double h = 1e-4 * std::min(x[i] - x[i - 1], x[i + 1] - x[i]);
            const double steepest = std::abs((y[i + 1] - y[i]) / (x[i + 1] - x[i])) +
                                    std::abs((y[i] - y[i - 1]) / (x[i] - x[i - 1]));
            const double rounding = 1e-14 * (1.0 + std::abs(y[i])) / h;
            EXPECT_NEAR(slope(h), slope(-h), 1e-4 * steepest + rounding);
        }
    }
}

// ---- unit focusing

TEST(UnitFocus, MovesTheSeedLensSensorByTheClosedForm) {
    const Prescription seed = testing::SeedLens();
    const LensInState at = Set(seed, {1.0, {}});
    EXPECT_TRUE(at.clamped.empty());
    EXPECT_EQ(at.state, (LensState{1.0, {}}));
    // S = 1000 + 5.448, f = 50.3582: s' - f = (S - sqrt(S^2 - 4 f S)) / 2 - f.
    EXPECT_NEAR(at.lens->sensor_gap_mm() - Built(seed)->sensor_gap_mm(), 2.8117, 5e-5);
    EXPECT_EQ(at.lens->nominal_sensor_gap_mm(), Built(seed)->nominal_sensor_gap_mm());
}

TEST(UnitFocus, PutsTheImageOfTheObjectOnTheSensor) {
    for (const Prescription& prescription : {testing::SeedLens(), testing::PlanoConvex()}) {
        for (const double focus_m : {0.45, 0.5, 1.0, 3.7, 40.0, 1e4}) {
            const LensInState at = Set(prescription, {focus_m, {}});
            ASSERT_TRUE(at.clamped.empty());
            const double gap = at.lens->sensor_gap_mm();
            EXPECT_NEAR(ImageOfObject(prescription, gap, 1e3 * focus_m), gap, 1e-9) << focus_m;
            // The same in the core's matrices: B from object to sensor is 0.
            const Abcd whole = FrontToSensor(*at.lens, kLineD);
            const double object = 1e3 * focus_m - at.lens->sensor_z_mm();
            EXPECT_NEAR((whole.a * object + whole.b) / object, 0.0, 1e-9);
        }
    }
}

TEST(UnitFocus, KeepsTheGeometryAndEverythingButTheSensor) {
    const auto base = Built(testing::SeedLens());
    for (const double focus_m : {0.31, 0.7, 1.0, 2.3, 11.0}) {
        const LensInState at = Set(testing::SeedLens(), {focus_m, {}});
        EXPECT_EQ(at.lens->geometry_fingerprint(), base->geometry_fingerprint()) << focus_m;
        EXPECT_NE(at.lens->fingerprint(), base->fingerprint());
        EXPECT_EQ(at.lens->first_order().efl_mm, base->first_order().efl_mm);
        EXPECT_EQ(at.lens->first_order().entrance.z_mm, base->first_order().entrance.z_mm);
        EXPECT_EQ(at.lens->f_number(), base->f_number());
        EXPECT_EQ(at.lens->nominal_sensor_gap_mm(), base->nominal_sensor_gap_mm());
    }
}

TEST(UnitFocus, KeepsADefocusThatTheFileStates) {
    Prescription prescription = testing::SeedLens();
    const double focus = FiguresOf(prescription).bfl_mm;
    prescription.surfaces.back().gap_given = true;
    prescription.surfaces.back().gap_mm = focus + 0.04;
    const double moved = Set(prescription, {2.0, {}}).lens->sensor_gap_mm();
    const double sharp = Set(testing::SeedLens(), {2.0, {}}).lens->sensor_gap_mm();
    EXPECT_NEAR(moved - sharp, 0.04, 1e-12);
}

TEST(UnitFocus, StopsAtTheNearestDistanceAndSaysSo) {
    const Prescription seed = testing::SeedLens();
    const LensInState at = Set(seed, {0.1, {}});
    // 4 f + HH' = 201.4329 - 5.448 mm: object and image both twice the focal length away.
    const double f = FiguresOf(seed).efl_mm;
    ASSERT_EQ(at.clamped.size(), 1U);
    EXPECT_EQ(at.clamped[0].field, "focus_m");
    EXPECT_EQ(at.clamped[0].from, 0.1);
    EXPECT_NEAR(at.clamped[0].to, 1e-3 * (4.0 * f - 5.448), 1e-6);
    EXPECT_EQ(at.state.focus_m, at.clamped[0].to);
    EXPECT_NEAR(at.lens->sensor_gap_mm() - Built(seed)->sensor_gap_mm(), f, 1e-5);
}

TEST(UnitFocus, OfAnyDistanceHoweverFarIsFinite) {
    const double at_infinity = Built(testing::SeedLens())->sensor_gap_mm();
    for (const double focus_m : {1e9, 1e100, 1e200, 1e308}) {
        EXPECT_NEAR(Set(testing::SeedLens(), {focus_m, {}}).lens->sensor_gap_mm(), at_infinity,
                    1e-5)
            << focus_m;
    }
    // Infinity itself is the lens as it stands, and is said so.
    const LensInState at = Set(testing::SeedLens(), {kInf, {}});
    EXPECT_EQ(at.lens->sensor_gap_mm(), at_infinity);
    EXPECT_EQ(at.state, LensState{});
    EXPECT_TRUE(at.clamped.empty());
}

TEST(UnitFocus, OfAnAfocalLensIsClampedToInfinity) {
    Prescription plate = testing::Assemble(
        "plate", {testing::Stop(1.0, 5.0), testing::Sphere(0.0, 2.0, 1.5, 0.0, 10.0),
                  testing::Sphere(0.0, 30.0, 1.0, 0.0, 10.0)});
    plate.surfaces.back().gap_given = true;
    plate.surfaces.back().gap_mm = 30.0;
    const LensInState at = Set(plate, {1.0, {}});
    ASSERT_EQ(at.clamped.size(), 1U);
    EXPECT_EQ(at.clamped[0].to, kInf);
    EXPECT_FALSE(at.state.focus_m.has_value());
    EXPECT_EQ(at.lens->sensor_gap_mm(), 30.0);
}

TEST(UnitFocus, OfAnAnamorphicLensIsTheMeanOfBothSections) {
    Prescription prescription = testing::PlanoConvex();
    prescription.surfaces[1].kind = SurfaceKind::kToroid;
    prescription.surfaces[1].radius_mm = 0.0;
    prescription.surfaces[1].radius_x_mm = 48.0;
    prescription.surfaces[1].radius_y_mm = 50.0;
    const auto base = Built(prescription);
    EXPECT_NEAR(base->sensor_gap_mm(),
                0.5 * (FiguresOf(prescription, Section::kX).bfl_mm +
                       FiguresOf(prescription, Section::kY).bfl_mm),
                1e-9);
    const double gap = Set(prescription, {1.5, {}}).lens->sensor_gap_mm();
    // To first order the two sections' images lie as far on both sides of the sensor.
    const double x = ImageOfObject(prescription, gap, 1500.0, Section::kX);
    const double y = ImageOfObject(prescription, gap, 1500.0, Section::kY);
    EXPECT_LT(x, gap - 1.0);
    EXPECT_NEAR(0.5 * (x + y), gap, 0.05 * (y - x));
}

TEST(PrimeLens, IsNotZoomed) {
    Prescription seed = testing::SeedLens();
    seed.design_focal_mm = 50.0;
    EXPECT_TRUE(Set(seed, {{}, 50.0}).clamped.empty());
    const LensInState at = Set(seed, {{}, 70.0});
    ASSERT_EQ(at.clamped.size(), 1U);
    EXPECT_EQ(at.clamped[0].field, "zoom_mm");
    EXPECT_EQ(at.clamped[0].from, 70.0);
    EXPECT_EQ(at.clamped[0].to, 50.0);
    EXPECT_FALSE(at.state.zoom_mm.has_value());
    EXPECT_EQ(at.lens->fingerprint(), Built(seed)->fingerprint());
}

// ---- zoom

double Defocus(const Lens& lens) {
    return lens.sensor_gap_mm() - FiguresOf(lens.prescription()).bfl_mm;
}

TEST(Zoom, StandsByTheFilesNumbersAtItsPositions) {
    const Prescription zoom = Zoom();
    for (std::size_t i = 0; i < std::size(kPositions); ++i) {
        const LensInState at = Set(zoom, {{}, kPositions[i].nominal_mm});
        EXPECT_TRUE(at.clamped.empty());
        EXPECT_EQ(at.state.zoom_mm, kPositions[i].nominal_mm);
        const Prescription& set = at.lens->prescription();
        EXPECT_EQ(set.surfaces[1].gap_mm, zoom.states.gaps[0].values[i]);
        EXPECT_EQ(set.surfaces[4].gap_mm, zoom.states.gaps[1].values[i]);
        EXPECT_EQ(set.surfaces[2].semi_diameter_mm, kPositions[i].stop_mm);
        EXPECT_NEAR(at.lens->first_order().efl_mm,
                    kPositions[i].nominal_mm * kPositions[i].real_over_nominal, 1e-8);
        EXPECT_NEAR(Defocus(*at.lens), kPositions[i].defocus_mm, 1e-8);
        EXPECT_NEAR(at.lens->f_number(), FiguresOf(set).f_number, 1e-9);
    }
    // Nothing asked: the first position, which is the lens as its surfaces stand.
    const LensInState at = Set(zoom, {});
    EXPECT_EQ(at.state.zoom_mm, 45.0);
    EXPECT_EQ(at.lens->fingerprint(), Set(zoom, {{}, 45.0}).lens->fingerprint());
}

TEST(Zoom, MeetsTheFocalLengthAndKeepsTheFocusInBetween) {
    const Prescription zoom = Zoom();
    std::vector<double> log_nominal, log_ratio, defocus;
    for (const ZoomPosition& p : kPositions) {
        log_nominal.push_back(std::log(p.nominal_mm));
        log_ratio.push_back(std::log(p.real_over_nominal));
        defocus.push_back(p.defocus_mm);
    }
    double before = 0.0;
    for (double asked = 45.0; asked <= 115.0; asked += 0.7) {
        const LensInState at = Set(zoom, {{}, asked});
        const Lens& lens = *at.lens;
        const testing::TableFigures figures = FiguresOf(lens.prescription());
        const auto above =
            std::upper_bound(std::begin(kPositions), std::end(kPositions) - 1, asked,
                             [](double z, const ZoomPosition& p) { return z < p.nominal_mm; });
        const ZoomPosition& hi = *above;
        const ZoomPosition& lo = *(above - 1);
        const double ratio = figures.efl_mm / asked;
        EXPECT_GE(ratio, std::min(lo.real_over_nominal, hi.real_over_nominal) - 1e-9);
        EXPECT_LE(ratio, std::max(lo.real_over_nominal, hi.real_over_nominal) + 1e-9);
        EXPECT_NEAR(std::log(ratio), MonotoneAt(log_nominal, log_ratio, std::log(asked)), 1e-9);
        EXPECT_GE(Defocus(lens), std::min(lo.defocus_mm, hi.defocus_mm) - 1e-8);
        EXPECT_LE(Defocus(lens), std::max(lo.defocus_mm, hi.defocus_mm) + 1e-8);
        EXPECT_NEAR(Defocus(lens), MonotoneAt(log_nominal, defocus, std::log(asked)), 1e-8);
        const double stop = lens.prescription().surfaces[2].semi_diameter_mm;
        EXPECT_GE(stop, lo.stop_mm - 1e-12);
        EXPECT_LE(stop, hi.stop_mm + 1e-12);
        EXPECT_GT(figures.efl_mm, before);
        before = figures.efl_mm;
    }
}

TEST(Zoom, OutsideItsRangeIsClampedAndSaidSo) {
    for (const auto& [asked, set] : {std::pair(20.0, 45.0), std::pair(300.0, 115.0)}) {
        const LensInState at = Set(Zoom(), {{}, asked});
        ASSERT_EQ(at.clamped.size(), 1U);
        EXPECT_EQ(at.clamped[0].field, "zoom_mm");
        EXPECT_EQ(at.clamped[0].from, asked);
        EXPECT_EQ(at.clamped[0].to, set);
        EXPECT_EQ(at.state.zoom_mm, set);
        EXPECT_EQ(at.lens->fingerprint(), Set(Zoom(), {{}, set}).lens->fingerprint());
    }
}

TEST(Zoom, WithoutASensorDistanceStandsAtItsFocusEverywhere) {
    Prescription zoom = Zoom();
    zoom.surfaces.back().gap_given = false;
    zoom.states.gaps.pop_back();
    for (const double asked : {45.0, 52.0, 70.0, 99.0, 115.0}) {
        EXPECT_NEAR(Defocus(*Set(zoom, {{}, asked}).lens), 0.0, 1e-9) << asked;
    }
}

TEST(Zoom, WithoutAFocusTableFocusesAsAWhole) {
    for (const double asked : {45.0, 60.0, 115.0}) {
        const LensInState far = Set(Zoom(), {{}, asked});
        const LensInState near = Set(Zoom(), {2.0, asked});
        const double sharp = near.lens->sensor_gap_mm() - Defocus(*far.lens);
        EXPECT_NEAR(ImageOfObject(far.lens->prescription(), near.lens->sensor_gap_mm(), 2000.0),
                    sharp, 2e-3)
            << asked;
        EXPECT_EQ(near.lens->geometry_fingerprint(), far.lens->geometry_fingerprint());
    }
}

// ---- focus by a table

TEST(FocusTable, IsReadAtItsDistancesAndOverTheirReciprocalsInBetween) {
    const Prescription lens = InnerFocusing();
    const auto gap = [&](double focus_m) {
        return Set(lens, {focus_m, {}}).lens->prescription().surfaces[1].gap_mm;
    };
    EXPECT_EQ(gap(3.0), 28.0);
    EXPECT_EQ(gap(1.2), 25.0);
    EXPECT_EQ(gap(1e12), MonotoneAt({0.0, 1.0 / 3.0, 1.0 / 1.2}, {30.0, 28.0, 25.0}, 1e-12));
    EXPECT_NEAR(gap(2.0), MonotoneAt({0.0, 1.0 / 3.0, 1.0 / 1.2}, {30.0, 28.0, 25.0}, 0.5), 1e-14);
    EXPECT_GT(gap(2.0), 25.0);
    EXPECT_LT(gap(2.0), 28.0);
    // The sensor has not moved.
    for (const double focus_m : {3.0, 2.0, 1.2}) {
        const LensInState at = Set(lens, {focus_m, {}});
        EXPECT_TRUE(at.clamped.empty());
        EXPECT_EQ(at.lens->sensor_gap_mm(), Built(lens)->sensor_gap_mm());
        EXPECT_NE(at.lens->geometry_fingerprint(), Built(lens)->geometry_fingerprint());
    }
}

TEST(FocusTable, EndsAtItsNearestDistance) {
    const LensInState at = Set(InnerFocusing(), {0.4, {}});
    ASSERT_EQ(at.clamped.size(), 1U);
    EXPECT_EQ(at.clamped[0].field, "focus_m");
    EXPECT_EQ(at.clamped[0].from, 0.4);
    EXPECT_EQ(at.clamped[0].to, 1.2);
    EXPECT_EQ(at.state.focus_m, 1.2);
    EXPECT_EQ(at.lens->fingerprint(), Set(InnerFocusing(), {1.2, {}}).lens->fingerprint());
}

TEST(FocusTable, AtInfinityIsTheLensAsItStands) {
    const LensInState at = Set(InnerFocusing(), {kInf, {}});
    EXPECT_EQ(at.state, LensState{});
    EXPECT_EQ(at.lens->fingerprint(), Built(InnerFocusing())->fingerprint());
}

TEST(StateTables, OfZoomAndFocusAreReadAlongBothAxes) {
    Prescription zoom = Zoom();
    const std::vector<double> far = zoom.states.gaps[0].values;
    zoom.states.focus_m = {kInf, 2.0, 1.0};
    const auto spread = [](const std::vector<double>& values, double step) {
        std::vector<double> out;
        for (const double value : values) {
            for (int k = 0; k < 3; ++k) out.push_back(value - step * k);
        }
        return out;
    };
    zoom.states.gaps[0].values = spread(far, 0.4);
    zoom.states.gaps[1].values = spread(zoom.states.gaps[1].values, 0.0);
    zoom.states.semi_diameters[0].values = spread(zoom.states.semi_diameters[0].values, 0.0);
    EXPECT_TRUE(FindStateFaults(zoom).empty());
    for (std::size_t i = 0; i < far.size(); ++i) {
        const double nominal = kPositions[i].nominal_mm;
        const auto gap = [&](LensState state) {
            return Set(zoom, state).lens->prescription().surfaces[1].gap_mm;
        };
        EXPECT_EQ(gap({{}, nominal}), far[i]);
        EXPECT_EQ(gap({2.0, nominal}), far[i] - 0.4);
        EXPECT_EQ(gap({1.0, nominal}), far[i] - 0.8);
        // 1 / focus: 0, 0.5, 1 are even, and so are the values.
        EXPECT_NEAR(gap({4.0, nominal}), far[i] - 0.2, 1e-12);
    }
    // Between zoom positions the place is found at infinity; focusing then moves what it moves.
    const double infinite = Set(zoom, {{}, 60.0}).lens->prescription().surfaces[1].gap_mm;
    EXPECT_NEAR(Set(zoom, {2.0, 60.0}).lens->prescription().surfaces[1].gap_mm, infinite - 0.4,
                1e-12);
    EXPECT_NEAR(infinite, Set(Zoom(), {{}, 60.0}).lens->prescription().surfaces[1].gap_mm, 1e-12);
    const LensInState both = Set(zoom, {0.5, 10.0});
    EXPECT_EQ(both.clamped.size(), 2U);
    EXPECT_EQ(both.state, (LensState{1.0, 45.0}));
}

TEST(LensInState, KeepsItsCoatingsAndIsRefusedWhereItCannotBeBuilt) {
    const auto bare = Built(testing::SeedLens())->WithBareGlass();
    const auto at = SetState(bare, {1.0, {}});
    ASSERT_TRUE(at.ok());
    for (const LensSurface& surface : at->lens->surfaces()) EXPECT_TRUE(surface.coating.bare());
    // A rim that is fine by itself but not on its sphere is found when the lens is zoomed there.
    Prescription zoom = Zoom();
    zoom.states.semi_diameters.push_back({3, {10.0, 10.0, 10.0, 23.0}, "#3"});
    EXPECT_TRUE(SetState(Built(zoom), {{}, 90.0}).ok());
    const auto refused = SetState(Built(zoom), {{}, 115.0});
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, "bad_lens");
}

}  // namespace
}  // namespace flare
