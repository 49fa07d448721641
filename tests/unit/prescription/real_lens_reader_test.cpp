// SPDX-License-Identifier: Apache-2.0
//
// Reading what goes beyond spheres: aspheres, toroids, cylinders, a sensor, design tolerances and
// the tables of zoom and focus; and building a lens from it.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/optics/lens_state.h"
#include "core/prescription/prescription_reader.h"

namespace flare {
namespace {

constexpr const char* kRich = R"(name = "rich"
year = 1987
source = "a table"

[design]
focal_mm = 60
section = "x"
focal_tolerance = 0.02
f_number = 5
f_number_tolerance = 0.04

[states]
focal_mm = [50.0, 80.0]
focus_m = [inf, 3, 0.9]
f_number = [4.0, 5.6]

[[states.gap]]
surface = 1
gap_mm = [[4.0, 5.0, 6.0], [7.0, 8.0, 9.5]]

[[states.gap]]
surface = 6
gap_mm = [[80.0, 80.0, 80.0], [80.5, 80.5, 81]]

[[states.semi_diameter]]
surface = 2
semi_diameter_mm = [[5.0, 5.0, 5.0], [6.0, 6.0, 6.0]]

[[surface]]
kind = "asphere"
radius_mm = 40.0
conic = -0.8
asphere = [1e-6, -2e-9, 0.0, 3e-15]
gap_mm = 3.0
nd = 1.6
semi_diameter_mm = 10.0

[[surface]]
kind = "toroid"
radius_x_mm = -900.0
radius_y_mm = 700.0
gap_mm = 4.0
semi_diameter_mm = 10.0

[[surface]]
kind = "stop"
gap_mm = 1.0
semi_diameter_mm = 5.0

[[surface]]
kind = "cylinder_x"
radius_mm = 300.0
gap_mm = 2.0
nd = 1.5
semi_diameter_mm = 9.0

[[surface]]
kind = "cylinder_y"
radius_mm = -250.0
gap_mm = 1.0
semi_diameter_mm = 9.0

[[surface]]
kind = "plane"
gap_mm = 1.0
nd = 1.5
semi_diameter_mm = 20.0

[[surface]]
kind = "plane"
gap_mm = 80.0
semi_diameter_mm = 20.0

[[surface]]
kind = "sensor"
reflectance = 0.08
semi_diameter_mm = 21.6
)";

Prescription Rich() {
    const Result<Prescription> read = ReadPrescriptionToml(kRich);
    EXPECT_TRUE(read.ok()) << read.error().where << ": " << read.error().message;
    return read.ok() ? *read : Prescription{};
}

TEST(RealLensReader, ReadsSurfacesOfEveryKind) {
    const Prescription lens = Rich();
    ASSERT_EQ(lens.surfaces.size(), 8U);
    EXPECT_EQ(lens.optical_count(), 7U);
    const auto kind = [&](std::size_t i) { return lens.surfaces[i].kind; };
    EXPECT_EQ(kind(0), SurfaceKind::kAsphere);
    EXPECT_EQ(lens.surfaces[0].radius_mm, 40.0);
    EXPECT_EQ(lens.surfaces[0].conic, -0.8);
    EXPECT_EQ(lens.surfaces[0].asphere, (std::vector<double>{1e-6, -2e-9, 0.0, 3e-15}));
    EXPECT_EQ(kind(1), SurfaceKind::kToroid);
    EXPECT_EQ(lens.surfaces[1].radius_x_mm, -900.0);
    EXPECT_EQ(lens.surfaces[1].radius_y_mm, 700.0);
    EXPECT_EQ(kind(3), SurfaceKind::kCylinderX);
    EXPECT_EQ(kind(4), SurfaceKind::kCylinderY);
    EXPECT_EQ(kind(7), SurfaceKind::kSensor);
    EXPECT_EQ(lens.surfaces[7].reflectance, 0.08);
    EXPECT_EQ(lens.surfaces[7].semi_diameter_mm, 21.6);
    EXPECT_EQ(lens.year, 1987);
}

TEST(RealLensReader, ReadsWhatTheDesignClaimsAndHowWell) {
    const Prescription lens = Rich();
    EXPECT_EQ(lens.design_focal_mm, 60.0);
    EXPECT_EQ(lens.design_section, Section::kX);
    EXPECT_EQ(lens.focal_tolerance, 0.02);
    EXPECT_EQ(lens.design_f_number, 5.0);
    EXPECT_EQ(lens.f_number_tolerance, 0.04);
}

TEST(RealLensReader, ReadsTheTablesOfZoomAndFocus) {
    const StateTable table = Rich().states;
    EXPECT_EQ(table.where, "line 12, column 1");
    EXPECT_EQ(table.focal_mm, (std::vector<double>{50.0, 80.0}));
    ASSERT_EQ(table.focus_m.size(), 3U);
    EXPECT_TRUE(std::isinf(table.focus_m[0]));
    EXPECT_EQ(table.focus_m[2], 0.9);
    EXPECT_EQ(table.f_number, (std::vector<double>{4.0, 5.6}));
    ASSERT_EQ(table.gaps.size(), 2U);
    // Zoom by zoom, laid end to end.
    EXPECT_EQ(table.gaps[0].surface, 1);
    EXPECT_EQ(table.gaps[0].values, (std::vector<double>{4.0, 5.0, 6.0, 7.0, 8.0, 9.5}));
    EXPECT_EQ(table.gaps[0].where, "line 17, column 1");
    ASSERT_EQ(table.semi_diameters.size(), 1U);
    EXPECT_EQ(table.semi_diameters[0].surface, 2);
    EXPECT_EQ(table.semi_diameters[0].values[5], 6.0);
}

TEST(RealLensReader, MakesALensWithThoseShapesStatesAndSensor) {
    const auto lens = Lens::Build(Rich());
    ASSERT_TRUE(lens.ok()) << lens.error().where << ": " << lens.error().message;
    const std::vector<LensSurface>& surfaces = (*lens)->surfaces();
    ASSERT_EQ(surfaces.size(), 7U);
    EXPECT_FALSE((*lens)->rotational());
    EXPECT_EQ((*lens)->sensor_index(), 7);
    ASSERT_TRUE((*lens)->sensor().has_value());
    EXPECT_EQ((*lens)->sensor()->reflectance, 0.08);
    EXPECT_EQ((*lens)->sensor()->semi_diameter_mm, 21.6);
    EXPECT_NEAR((*lens)->sensor_z_mm(), 12.0 + 80.0, 1e-12);
    // The sags by the formulas of FORMAT.md: c r^2 / (1 + sqrt(1 - (1 + k) c^2 r^2)) + a4 r^4 + ...
    const double r2 = 9.0 + 16.0, c = 1.0 / 40.0;
    EXPECT_NEAR(surfaces[0].shape.Sag(3.0, 4.0),
                c * r2 / (1.0 + std::sqrt(1.0 - 0.2 * c * c * r2)) + 1e-6 * r2 * r2 -
                    2e-9 * r2 * r2 * r2 + 3e-15 * std::pow(r2, 5.0),
                1e-14);
    EXPECT_EQ(surfaces[1].shape.curvature_x(), -1.0 / 900.0);
    EXPECT_EQ(surfaces[1].shape.curvature_y(), 1.0 / 700.0);
    EXPECT_EQ(surfaces[3].shape.curvature_x(), 1.0 / 300.0);
    EXPECT_EQ(surfaces[3].shape.curvature_y(), 0.0);
    EXPECT_EQ(surfaces[4].shape.curvature_x(), 0.0);
    EXPECT_EQ(surfaces[4].shape.curvature_y(), -1.0 / 250.0);

    const auto set = SetState(*lens, {0.9, 80.0});
    ASSERT_TRUE(set.ok());
    EXPECT_EQ(set->lens->prescription().surfaces[1].gap_mm, 9.5);
    EXPECT_EQ(set->lens->prescription().surfaces[2].semi_diameter_mm, 6.0);
    EXPECT_EQ(set->lens->prescription().surfaces[6].gap_mm, 81.0);
    EXPECT_TRUE(set->lens->sensor().has_value());
}

TEST(RealLensReader, TheLastGapMayBeLeftOutInFrontOfASensor) {
    std::string text = kRich;
    text.erase(text.find("gap_mm = 80.0\n"), std::string("gap_mm = 80.0\n").size());
    const Result<Prescription> read = ReadPrescriptionToml(text);
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_FALSE(read->surfaces[6].gap_given);
    // But a table that moves the sensor then has nothing to begin with.
    const auto lens = Lens::Build(*read);
    ASSERT_FALSE(lens.ok());
    EXPECT_EQ(lens.error().where, "line 21, column 1");
}

TEST(RealLensReader, OneAxisNeedsNoNestedRows) {
    const Result<Prescription> read = ReadPrescriptionToml(
        "name = \"x\"\nsurface = [{semi_diameter_mm = 1}]\n[states]\nfocus_m = [\"inf\", 2]\n"
        "gap = [{surface = 0, gap_mm = [1, 2]}]\n");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_TRUE(std::isinf(read->states.focus_m[0]));
    EXPECT_EQ(read->states.gaps[0].values, (std::vector<double>{1.0, 2.0}));
    EXPECT_EQ(read->states.gaps[0].where, "line 5, column 8");
}

// What the reader lets through and the numbers forbid: named with its place when the lens is built.
struct BadShape {
    const char* what;
    const char* text;
    const char* instead;
    const char* where;
    const char* says;
};

void PrintTo(const BadShape& shape, std::ostream* out) {
    *out << shape.what;
}

class RefusedShape : public ::testing::TestWithParam<BadShape> {};

TEST_P(RefusedShape, IsRefusedAtItsPlace) {
    std::string text = kRich;
    const std::size_t at = text.find(GetParam().text);
    ASSERT_NE(at, std::string::npos);
    text.replace(at, std::string(GetParam().text).size(), GetParam().instead);
    const Result<Prescription> read = ReadPrescriptionToml(text);
    ASSERT_TRUE(read.ok()) << read.error().message;
    const auto lens = Lens::Build(*read);
    ASSERT_FALSE(lens.ok());
    EXPECT_EQ(lens.error().where, GetParam().where);
    EXPECT_NE(lens.error().message.find(GetParam().says), std::string::npos)
        << lens.error().message;
}

INSTANTIATE_TEST_SUITE_P(
    Table, RefusedShape,
    ::testing::Values(
        BadShape{"nine coefficients", "[1e-6, -2e-9, 0.0, 3e-15]", "[0,0,0,0,0,0,0,0,1e-30]",
                 "line 29, column 1", "at most 8 coefficients"},
        BadShape{"a power of ten", "[1e-6, ", "[1e-2, ", "line 29, column 1", "power of ten"},
        BadShape{"a toroid with one radius more", "radius_x_mm", "radius_mm = 3\nradius_x_mm",
                 "line 38, column 1", "a toroid has two radii"},
        BadShape{"a conic cylinder", "\"cylinder_x\"", "\"cylinder_x\"\nconic = -1.0",
                 "line 50, column 1", "for the kind \"asphere\""},
        BadShape{"a cylinder that is wider than itself", "radius_mm = 300.0", "radius_mm = 8.0",
                 "line 50, column 1", "stands upright"},
        BadShape{"a mirror brighter than its light", "reflectance = 0.08", "reflectance = 1.2",
                 "line 74, column 1", "not within 0 .. 1"},
        BadShape{"glass on the sensor", "reflectance = 0.08", "reflectance = 0.08\nnd = 1.5",
                 "line 74, column 1", "neither glass nor coating"},
        BadShape{"a table for the sensor", "surface = 6\n", "surface = 7\n", "line 21, column 1",
                 "surface 7, which the lens has not"},
        BadShape{"too few rows", "[[80.0, 80.0, 80.0], [80.5, 80.5, 81]]", "[[80.0, 80.0, 80.0]]",
                 "line 21, column 1", "needs 6 values, not 3"}));

}  // namespace
}  // namespace flare
