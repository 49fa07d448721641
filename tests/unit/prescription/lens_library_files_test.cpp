// SPDX-License-Identifier: Apache-2.0
//
// Every lens file that comes with the program keeps its word.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <set>
#include <sstream>
#include <string>

#include "core/optics/lens.h"
#include "core/prescription/prescription_check.h"
#include "core/prescription/prescription_reader.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

namespace fs = std::filesystem;

const fs::path kLenses = fs::path(FLARE_SOURCE_DIR) / "lenses";

Result<Prescription> ReadFile(const std::string& name) {
    std::ifstream file(kLenses / (name + ".toml"), std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    return ReadPrescriptionToml(text.str());
}

// What is known of a lens from elsewhere: the maker's or patent's figures and how far the table may
// be from them, and figures that an independent program computed from the source's table.
struct Known {
    const char* name;
    std::size_t surfaces;
    double design_focal_mm, focal_tolerance;
    double design_f_number, f_number_tolerance;
    double efl_mm, bfl_mm;
    std::set<std::string> warnings;
};

void PrintTo(const Known& known, std::ostream* out) {
    *out << known.name;
}

class LibraryLens : public ::testing::TestWithParam<Known> {};

TEST_P(LibraryLens, BuildsAndMeetsItsDesign) {
    const Known& known = GetParam();
    const Result<Prescription> file = ReadFile(known.name);
    ASSERT_TRUE(file.ok()) << file.error().where << ": " << file.error().message;
    EXPECT_EQ(file->name, known.name);
    EXPECT_EQ(file->design_focal_mm, known.design_focal_mm);
    EXPECT_EQ(file->design_f_number, known.design_f_number);
    for (const std::string* text : {&file->maker, &file->patent, &file->source, &file->notes}) {
        EXPECT_FALSE(text->empty());
    }
    const auto lens = Lens::Build(*file);
    ASSERT_TRUE(lens.ok()) << lens.error().where << ": " << lens.error().message;
    const FirstOrder& first_order = (*lens)->first_order();
    EXPECT_EQ((*lens)->surfaces().size(), known.surfaces);
    EXPECT_NEAR(first_order.efl_mm / known.design_focal_mm, 1.0, known.focal_tolerance);
    EXPECT_NEAR(first_order.f_number / known.design_f_number, 1.0, known.f_number_tolerance);
    EXPECT_NEAR(first_order.efl_mm, known.efl_mm, 6e-5);
    EXPECT_NEAR(first_order.bfl_mm, known.bfl_mm, 6e-5);
}

TEST_P(LibraryLens, HasOnlyTheWarningsItsNotesExplain) {
    const Result<Prescription> file = ReadFile(GetParam().name);
    ASSERT_TRUE(file.ok());
    std::set<std::string> warnings;
    for (const Finding& finding : CheckPrescription(*file)) {
        EXPECT_EQ(finding.severity, Severity::kWarning) << finding.message;
        warnings.insert(finding.code);
    }
    EXPECT_EQ(warnings, GetParam().warnings);
}

INSTANTIATE_TEST_SUITE_P(
    Files, LibraryLens,
    ::testing::Values(
        Known{"tronnier-double-gauss-50mm-f2", 11, 50.0, 0.01, 2.0, 0.02, 50.3582, 36.1059, {}},
        Known{"tronnier-color-heliar-100mm-f3_5", 9, 100.0, 0.01, 3.5, 0.01, 100.5941, 82.5977, {}},
        Known{"angenieux-retrofocus-35mm-f2_5", 12, 35.0, 0.01, 2.5, 0.03, 35.3255, 37.0708, {}},
        Known{"kreitzer-telephoto-400mm-f5_6", 13, 400.0, 0.01, 5.6, 0.001, 400.9275, 76.1486, {}},
        Known{
            "zeiss-master-prime-50mm-t1_3", 24, 50.0, 0.001, 1.3, 0.01, 49.9926, 35.9824, {"rim"}},
        Known{"shimizu-fisheye-6mm-f2_8-220deg",
              24,
              6.3,
              0.001,
              2.8,
              0.02,
              6.2955,
              37.6576,
              {"semi_diameter", "v_number"}}));

TEST(LibraryLenses, EveryFileIsInTheTableAbove) {
    std::set<std::string> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(kLenses)) {
        if (entry.path().extension() == ".toml") files.insert(entry.path().stem().string());
    }
    EXPECT_EQ(files, (std::set<std::string>{
                         "angenieux-retrofocus-35mm-f2_5", "kreitzer-telephoto-400mm-f5_6",
                         "shimizu-fisheye-6mm-f2_8-220deg", "tronnier-color-heliar-100mm-f3_5",
                         "tronnier-double-gauss-50mm-f2", "zeiss-master-prime-50mm-t1_3"}));
}

TEST(LibraryLenses, TheSeedLensFileIsTheSeedLens) {
    const Result<Prescription> file = ReadFile("tronnier-double-gauss-50mm-f2");
    ASSERT_TRUE(file.ok());
    const auto lens = Lens::Build(*file);
    ASSERT_TRUE(lens.ok());
    const auto seed = *Lens::Build(testing::SeedLens());
    EXPECT_EQ((*lens)->fingerprint(), seed->fingerprint());
}

TEST(LibraryLenses, OnlyTheFisheyeIsAFisheye) {
    EXPECT_TRUE(ReadFile("shimizu-fisheye-6mm-f2_8-220deg")->fisheye);
    EXPECT_FALSE(ReadFile("tronnier-double-gauss-50mm-f2")->fisheye);
}

}  // namespace
}  // namespace flare
