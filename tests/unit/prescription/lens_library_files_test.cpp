// SPDX-License-Identifier: Apache-2.0
//
// Every lens file that comes with the program keeps its word.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <set>
#include <sstream>
#include <string>

#include "core/optics/lens.h"
#include "core/optics/lens_state.h"
#include "core/prescription/prescription_check.h"
#include "core/prescription/prescription_reader.h"
#include "tests/support/paraxial_table.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

namespace fs = std::filesystem;

const fs::path kLenses = fs::path(FLARE_SOURCE_DIR) / "lenses";

Result<Prescription> ReadFile(const std::string& name) {
    std::ifstream file(kLenses / (name + ".toml"), std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    Result<Prescription> read = ReadPrescriptionToml(text.str());
    // Nothing here sees a coating.
    if (read.ok()) read->default_coating = "bare";
    return read;
}

// What is known of a lens from elsewhere: figures that an independent program computed from the
// source's table, at the first position and in y.
struct Known {
    const char* name;
    std::size_t surfaces;
    double efl_mm, bfl_mm;
    std::set<std::string> warnings;
};

void PrintTo(const Known& known, std::ostream* out) {
    *out << known.name;
}

class LibraryLens : public ::testing::TestWithParam<Known> {};

// The file's own claim, within the tolerance that the file itself states.
void ExpectDesign(const Prescription& file, const Lens& lens, double focal_mm, double f_number) {
    const testing::TableFigures figures =
        testing::FiguresOf(lens.prescription(), file.design_section);
    EXPECT_NEAR(figures.efl_mm / focal_mm, 1.0, file.focal_tolerance.value()) << focal_mm;
    EXPECT_NEAR(figures.efl_mm, lens.first_order(file.design_section).efl_mm, 1e-9);
    double product = 1.0;
    for (const Section section : {Section::kX, Section::kY}) {
        const double n = testing::FiguresOf(lens.prescription(), section).f_number;
        EXPECT_NEAR(n / f_number, 1.0, file.f_number_tolerance.value()) << focal_mm;
        product *= n;
    }
    EXPECT_NEAR(lens.f_number(), std::sqrt(product), 1e-9);
}

TEST_P(LibraryLens, BuildsAndMeetsItsDesignInEveryState) {
    const Known& known = GetParam();
    const Result<Prescription> file = ReadFile(known.name);
    ASSERT_TRUE(file.ok()) << file.error().where << ": " << file.error().message;
    EXPECT_EQ(file->name, known.name);
    for (const std::string* text : {&file->maker, &file->patent, &file->source, &file->notes}) {
        EXPECT_FALSE(text->empty());
    }
    ASSERT_TRUE(file->design_focal_mm && file->design_f_number);
    // No design is known better than to half a percent, and none is off by a twentieth.
    ASSERT_TRUE(file->focal_tolerance && file->f_number_tolerance);
    EXPECT_LE(*file->focal_tolerance, 0.02);
    EXPECT_LT(*file->f_number_tolerance, 0.05);

    const auto lens = Lens::Build(*file);
    ASSERT_TRUE(lens.ok()) << lens.error().where << ": " << lens.error().message;
    EXPECT_EQ((*lens)->surfaces().size(), known.surfaces);
    EXPECT_NEAR((*lens)->first_order().efl_mm, known.efl_mm, 6e-5);
    EXPECT_NEAR((*lens)->first_order().bfl_mm, known.bfl_mm, 6e-5);
    ExpectDesign(*file, **lens, *file->design_focal_mm, *file->design_f_number);
    for (std::size_t i = 0; i < file->states.focal_mm.size(); ++i) {
        const double nominal = file->states.focal_mm[i];
        const auto set = SetState(*lens, {{}, nominal});
        ASSERT_TRUE(set.ok()) << set.error().message;
        EXPECT_TRUE(set->clamped.empty());
        ASSERT_EQ(file->states.f_number.size(), file->states.focal_mm.size());
        ExpectDesign(*file, *set->lens, nominal, file->states.f_number[i]);
    }
}

// Of a real lens at its tabulated positions the image stands on the sensor: within 0.06 mm on the
// axis, the most that the files' notes admit.
TEST_P(LibraryLens, IsInFocusInEveryState) {
    const Result<Prescription> file = ReadFile(GetParam().name);
    ASSERT_TRUE(file.ok());
    const auto base = *Lens::Build(*file);
    for (const double zoom : file->states.focal_mm) {
        const LensInState set = *SetState(base, {{}, zoom});
        const Lens& lens = *set.lens;
        EXPECT_NEAR(lens.sensor_gap_mm(), testing::FiguresOf(lens.prescription()).bfl_mm, 0.06)
            << zoom;
    }
    for (const double focus : file->states.focus_m) {
        if (std::isinf(focus)) continue;
        const LensInState set = *SetState(base, {focus, {}});
        const Lens& lens = *set.lens;
        EXPECT_EQ(lens.nominal_sensor_gap_mm(), base->nominal_sensor_gap_mm());
        EXPECT_NEAR(testing::ImageOfObject(lens.prescription(), lens.sensor_gap_mm(), 1e3 * focus),
                    lens.sensor_gap_mm(), 0.06)
            << focus;
    }
}

TEST_P(LibraryLens, HasOnlyTheWarningsItsNotesExplain) {
    const Result<Prescription> file = ReadFile(GetParam().name);
    ASSERT_TRUE(file.ok());
    std::set<std::string> warnings;
    std::string said;
    for (const Finding& finding : CheckPrescription(*file)) {
        EXPECT_EQ(finding.severity, Severity::kWarning) << finding.message;
        warnings.insert(finding.code);
        said += finding.message + "\n";
    }
    EXPECT_EQ(warnings, GetParam().warnings) << said;
}

const Known kKnown[] = {
    {"angenieux-double-gauss-50mm-f1_1", 15, 49.9699, 27.9885, {}},
    {"angenieux-retrofocus-35mm-f2_5", 12, 35.3255, 37.0708, {}},
    {"canon-600mm-f4", 31, 585.3345, 103.2896, {}},
    {"canon-85mm-f1_2-spherical", 17, 85.0038, 38.3503, {"rim"}},
    {"canon-retrofocus-14mm-f2_8", 26, 14.2794, 36.3015, {}},
    {"canon-rf-85mm-f1_2", 24, 86.5264, 14.9009, {"rim"}},
    {"canon-serenar-50mm-f1_8", 11, 49.9876, 25.4181, {}},
    {"canon-zoom-200-400mm-f4-at-205mm", 44, 204.9911, 68.4566, {}},
    {"canon-zoom-70-200mm-f2_8", 34, 72.0912, 52.5028, {}},
    {"cooke-speed-panchro-25mm-f2", 11, 25.9588, 19.6578, {}},
    {"kodak-petzval-100mm-f2_2", 8, 99.9712, 56.4963, {}},
    {"kreitzer-telephoto-400mm-f5_6", 13, 400.9275, 76.1486, {}},
    {"leica-summicron-50mm-f2", 11, 50.0149, 29.4568, {}},
    {"minolta-fisheye-16mm-f2_8", 17, 16.0025, 37.1934, {}},
    {"nikon-24mm-f2_8", 17, 23.9987, 37.4363, {}},
    {"nikon-85mm-f1_4", 13, 85.0112, 42.6451, {}},
    {"nikon-zoom-80-200mm-f2_8", 22, 80.0886, 40.2265, {}},
    {"petzval-portrait-86mm-f3_4", 8, 86.1902, 50.3818, {}},
    {"sasian-triplet-50mm-f4", 7, 50.0003, 41.2371, {}},
    {"schneider-anamorphic-31mm-f2", 19, 60.5546, 43.3545, {}},
    {"shimizu-fisheye-6mm-f2_8-220deg", 24, 6.2955, 37.6576, {"semi_diameter", "v_number"}},
    {"textbook-cooke-triplet-50mm-f5", 7, 50.0216, 42.4367, {}},
    {"textbook-heliar-100mm-f5", 9, 100.0653, 85.2103, {}},
    {"tronnier-color-heliar-100mm-f3_5", 9, 100.5941, 82.5977, {}},
    {"tronnier-double-gauss-50mm-f2", 11, 50.3582, 36.1059, {}},
    {"zeiss-biogon-35mm-f2_8", 12, 34.7106, 15.7599, {}},
    {"zeiss-biotar-50mm-f1_4", 11, 49.9567, 32.6643, {"rim"}},
    {"zeiss-master-prime-100mm-t1_3", 23, 99.7949, 40.1221, {}},
    {"zeiss-master-prime-50mm-t1_3", 24, 49.9926, 35.9824, {"rim"}},
    {"zeiss-sonnar-50mm-f2", 10, 50.0148, 24.1830, {}},
};

INSTANTIATE_TEST_SUITE_P(Files, LibraryLens, ::testing::ValuesIn(kKnown));

TEST(LibraryLenses, EveryFileIsInTheTableAbove) {
    std::set<std::string> files, known;
    for (const fs::directory_entry& entry : fs::directory_iterator(kLenses)) {
        if (entry.path().extension() == ".toml") files.insert(entry.path().stem().string());
    }
    for (const Known& lens : kKnown) known.insert(lens.name);
    EXPECT_EQ(files, known);
}

TEST(LibraryLenses, TheAnamorphicSqueezesInX) {
    const auto lens = *Lens::Build(*ReadFile("schneider-anamorphic-31mm-f2"));
    EXPECT_FALSE(lens->rotational());
    EXPECT_NEAR(lens->first_order(Section::kX).efl_mm, 31.4876, 6e-5);
    EXPECT_NEAR(lens->first_order(Section::kX).bfl_mm, 43.3304, 6e-5);
    EXPECT_NEAR(lens->squeeze(), 60.5546 / 31.4876, 1e-5);
}

// Between the positions of a zoom: the nominal focal length to the file's tolerance, and the focus.
TEST(LibraryLenses, ZoomsMeetTheFocalLengthAndKeepTheFocusBetweenTheirPositions) {
    for (const char* name : {"canon-zoom-70-200mm-f2_8", "nikon-zoom-80-200mm-f2_8"}) {
        const Result<Prescription> file = ReadFile(name);
        const auto base = *Lens::Build(*file);
        const double lo = file->states.focal_mm.front(), hi = file->states.focal_mm.back();
        for (int i = 0; i <= 60; ++i) {
            const double asked = lo * std::pow(hi / lo, i / 60.0);
            const auto set = SetState(base, {{}, asked});
            ASSERT_TRUE(set.ok()) << set.error().message;
            const testing::TableFigures figures = testing::FiguresOf(set->lens->prescription());
            EXPECT_NEAR(figures.efl_mm / asked, 1.0, *file->focal_tolerance) << asked;
            EXPECT_NEAR(set->lens->sensor_gap_mm(), figures.bfl_mm, 0.06) << asked;
        }
    }
}

TEST(LibraryLenses, TheSeedLensFileIsTheSeedLens) {
    const Result<Prescription> file = ReadFile("tronnier-double-gauss-50mm-f2");
    ASSERT_TRUE(file.ok());
    const auto lens = Lens::Build(*file);
    ASSERT_TRUE(lens.ok());
    Prescription numbers = testing::SeedLens();
    numbers.default_coating = "bare";
    const auto seed = *Lens::Build(numbers);
    EXPECT_EQ((*lens)->fingerprint(), seed->fingerprint());
}

TEST(LibraryLenses, OnlyTheFisheyesAreFisheyes) {
    EXPECT_TRUE(ReadFile("shimizu-fisheye-6mm-f2_8-220deg")->fisheye);
    EXPECT_TRUE(ReadFile("minolta-fisheye-16mm-f2_8")->fisheye);
    EXPECT_FALSE(ReadFile("tronnier-double-gauss-50mm-f2")->fisheye);
}

}  // namespace
}  // namespace flare
