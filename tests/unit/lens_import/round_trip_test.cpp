// SPDX-License-Identifier: Apache-2.0
//
// Every rotational lens of the library, written as a file of each other program, comes back as the
// same lens: imported, written as a lens file and read again. First-order figures are worked out
// by the tests' own y-nu trace of the prescription that was written.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/prescription/prescription_writer.h"
#include "server/translate/lens_import_json.h"
#include "tests/support/foreign_lens_files.h"
#include "tests/support/lenses.h"

namespace flare {
namespace {

std::vector<std::string> LibraryFiles() {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(FLARE_SOURCE_DIR "/lenses")) {
        if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
    }
    return names;
}

bool Rotational(const Prescription& lens) {
    for (const SurfacePrescription& surface : lens.surfaces) {
        if (surface.kind == SurfaceKind::kCylinderX || surface.kind == SurfaceKind::kCylinderY ||
            surface.kind == SurfaceKind::kToroid) {
            return false;
        }
    }
    return true;
}

// Import, lens file, reader.
Prescription ThroughToml(const std::string& text, const char* format) {
    const Result<ImportedLens> imported = ImportLensFile(text, std::nullopt);
    if (!imported) {
        ADD_FAILURE() << imported.error().where << ": " << imported.error().message;
        return {};
    }
    EXPECT_EQ(FormatName(imported->format), format);
    const Result<Prescription> back =
        ReadPrescriptionToml(TomlFromPrescription(imported->prescription));
    if (!back) {
        ADD_FAILURE() << back.error().where << ": " << back.error().message;
        return {};
    }
    return *back;
}

void ExpectSameLens(const Prescription& lens, const Prescription& back,
                    const testing::ForeignFormat& format) {
    ASSERT_EQ(back.surfaces.size(), lens.optical_count());
    const testing::TableFigures figures = testing::FiguresOf(lens);
    const Result<std::shared_ptr<const Lens>> built = Lens::Build(back);
    ASSERT_TRUE(built.ok()) << built.error().message;
    const FirstOrder& first = (*built)->first_order();
    EXPECT_NEAR(first.efl_mm / figures.efl_mm, 1.0, 1e-6);
    EXPECT_NEAR(first.bfl_mm / figures.bfl_mm, 1.0, 1e-6);
    EXPECT_NEAR(first.f_number / figures.f_number, 1.0, 1e-6);
    EXPECT_NEAR((*built)->sensor_gap_mm() / testing::LastGap(lens), 1.0, 1e-9);
    for (std::size_t i = 0; i < lens.optical_count(); ++i) {
        const SurfacePrescription &was = lens.surfaces[i], &is = back.surfaces[i];
        EXPECT_NEAR(is.semi_diameter_mm, was.semi_diameter_mm, 1e-12 * was.semi_diameter_mm) << i;
        const Glass glass = MediumOf(was).value(), now = MediumOf(is).value();
        EXPECT_NEAR(now.nd(), glass.nd(), 1e-12) << i;
        if (format.v_numbers && testing::VNumberBehind(was) > 0.0) {
            // n_d and V_d say this and no more of a glass by name.
            EXPECT_NEAR(now.Index(kLineF) - now.Index(kLineC),
                        glass.Index(kLineF) - glass.Index(kLineC), 1e-9)
                << i;
        }
        if (format.aspheres && was.kind == SurfaceKind::kAsphere) {
            EXPECT_EQ(is.conic, was.conic) << i;
            EXPECT_EQ(is.asphere, was.asphere) << i;
        }
    }
}

class RoundTrip : public ::testing::TestWithParam<std::size_t> {};

TEST_P(RoundTrip, OfEveryLibraryLensKeepsItsFigures) {
    const testing::ForeignFormat& format = testing::ForeignFormats()[GetParam()];
    int lenses = 0;
    for (const std::string& name : LibraryFiles()) {
        SCOPED_TRACE(name);
        const Prescription lens = testing::LibraryPrescription(name);
        if (!Rotational(lens)) continue;
        ExpectSameLens(lens, ThroughToml(format.write(lens), format.name), format);
        ++lenses;
    }
    EXPECT_GE(lenses, 15);
}

// Cylinders, too, where the format has them.
TEST(RoundTripOfAnAnamorphicLens, KeepsBothSections) {
    const Prescription lens = testing::LibraryPrescription("schneider-anamorphic-31mm-f2");
    const Prescription back = ThroughToml(testing::LentilText(lens), "lentil");
    const auto built = testing::BuildLens(back);
    for (const Section section : {Section::kX, Section::kY}) {
        const testing::TableFigures figures = testing::FiguresOf(lens, section);
        EXPECT_NEAR(built->first_order(section).efl_mm / figures.efl_mm, 1.0, 1e-6);
    }
}

// Glass by name: found under the name that the other program has for it.
TEST(RoundTripOfNamedGlass, FindsItByItsForeignName) {
    Prescription lens = testing::LibraryPrescription(testing::kSeedName);
    for (const auto& [surface, glass] :
         {std::pair(0, "SCHOTT N-LAK9"), std::pair(2, "OHARA S-LAH59"), std::pair(3, "SCHOTT SF15"),
          std::pair(9, "HIKARI E-SK16")}) {
        SurfacePrescription& to = lens.surfaces[static_cast<std::size_t>(surface)];
        to.nd.reset();
        to.vd.reset();
        to.glass = glass;
    }
    int formats = 0;
    for (const testing::ForeignFormat& format : testing::ForeignFormats()) {
        if (!format.aspheres) continue;  // tables have no names
        SCOPED_TRACE(format.name);
        const Prescription back = ThroughToml(format.write(lens), format.name);
        ASSERT_EQ(back.surfaces.size(), lens.surfaces.size());
        for (std::size_t i = 0; i < lens.surfaces.size(); ++i) {
            EXPECT_EQ(MediumOf(back.surfaces[i]).value().nd(),
                      MediumOf(lens.surfaces[i]).value().nd());
        }
        EXPECT_EQ(back.surfaces[0].glass, "SCHOTT N-LAK9");
        ++formats;
    }
    EXPECT_EQ(formats, 4);
}

INSTANTIATE_TEST_SUITE_P(Formats, RoundTrip, ::testing::Range<std::size_t>(0, 10),
                         [](const auto& shown) {
                             return std::string(testing::ForeignFormats()[shown.param].name);
                         });

// The writer alone: every lens of the library, zooms and coatings included, out and in again.
TEST(PrescriptionWriter, WritesWhatTheReaderReadsBackTheSame) {
    for (const std::string& name : LibraryFiles()) {
        SCOPED_TRACE(name);
        Prescription lens = testing::LibraryPrescription(name);
        Result<Prescription> back = ReadPrescriptionToml(TomlFromPrescription(lens));
        ASSERT_TRUE(back.ok()) << back.error().where << ": " << back.error().message;
        const auto forget_places = [](Prescription& file) {
            for (SurfacePrescription& surface : file.surfaces) surface.where.clear();
            for (auto* rows : {&file.states.gaps, &file.states.semi_diameters}) {
                for (StateTable::Row& row : *rows) row.where.clear();
            }
            file.states.where.clear();
        };
        forget_places(lens);
        forget_places(*back);
        EXPECT_TRUE(*back == lens);
    }
}

TEST(PrescriptionWriter, EscapesTextAndKeepsLayersAndEveryBit) {
    Prescription lens = testing::LibraryPrescription(testing::kSeedName);
    lens.notes = "a \"quoted\"\nline with \\ and \t in it";
    lens.maker = "\"\\";
    lens.surfaces[0].radius_mm = 0.1 + 0.2;
    lens.surfaces[0].coating = "odd \"one\"";
    lens.coatings.emplace(
        "odd \"one\"",
        CoatingDesign::Stack("odd \"one\"", {{MaterialByName("MgF2").value(), 1.0 / 3.0},
                                             {std::complex<double>(2.1, 1e-3), 20.0}})
            .value());
    lens.coatings.begin()->second.source = "nobody";
    const Result<Prescription> back = ReadPrescriptionToml(TomlFromPrescription(lens));
    ASSERT_TRUE(back.ok()) << back.error().where << ": " << back.error().message;
    EXPECT_EQ(back->notes, lens.notes);
    EXPECT_EQ(back->maker, lens.maker);
    EXPECT_EQ(back->surfaces[0].radius_mm, lens.surfaces[0].radius_mm);
    EXPECT_EQ(back->coatings, lens.coatings);
}

}  // namespace
}  // namespace flare
