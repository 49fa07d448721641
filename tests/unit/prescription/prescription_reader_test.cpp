// SPDX-License-Identifier: Apache-2.0
#include "core/prescription/prescription_reader.h"

#include <gtest/gtest.h>

#include <ostream>
#include <string>

namespace flare {
namespace {

constexpr const char* kGood = R"(name = "doublet"
maker = "maker"
patent = "patent"
source = "source"
notes = "notes"
default_coating = "mgf2-550"
fisheye = true

[design]
focal_mm = 100
f_number = 10.0
image_circle_mm = 43.3

[[surface]]
kind = "stop"
gap_mm = 2
semi_diameter_mm = 5

[[surface]]
radius_mm = 50.0
gap_mm = 6.0
nd = 1.5
vd = 60.0
semi_diameter_mm = 10.0
coating = "bare"

[[surface]]
kind = "plane"
semi_diameter_mm = 10.0
)";

TEST(PrescriptionReader, ReadsEveryKey) {
    const Result<Prescription> read = ReadPrescriptionToml(kGood);
    ASSERT_TRUE(read.ok()) << read.error().where << ": " << read.error().message;
    EXPECT_EQ(read->name, "doublet");
    EXPECT_EQ(read->maker, "maker");
    EXPECT_EQ(read->patent, "patent");
    EXPECT_EQ(read->source, "source");
    EXPECT_EQ(read->notes, "notes");
    EXPECT_EQ(read->default_coating, "mgf2-550");
    EXPECT_TRUE(read->fisheye);
    EXPECT_EQ(read->design_focal_mm, 100.0);
    EXPECT_EQ(read->design_f_number, 10.0);
    EXPECT_EQ(read->design_image_circle_mm, 43.3);
    ASSERT_EQ(read->surfaces.size(), 3u);
    EXPECT_EQ(read->surfaces[0].kind, SurfaceKind::kStop);
    EXPECT_EQ(read->surfaces[0].gap_mm, 2.0);
    EXPECT_EQ(read->surfaces[0].where, "line 14, column 1");
    EXPECT_EQ(read->surfaces[1].kind, SurfaceKind::kSphere);
    EXPECT_EQ(read->surfaces[1].radius_mm, 50.0);
    EXPECT_EQ(read->surfaces[1].gap_mm, 6.0);
    EXPECT_EQ(read->surfaces[1].nd, 1.5);
    EXPECT_EQ(read->surfaces[1].vd, 60.0);
    EXPECT_EQ(read->surfaces[1].semi_diameter_mm, 10.0);
    EXPECT_EQ(read->surfaces[1].coating, "bare");
    EXPECT_EQ(read->surfaces[2].kind, SurfaceKind::kPlane);
    EXPECT_FALSE(read->surfaces[2].gap_given);
    EXPECT_FALSE(read->surfaces[2].nd.has_value());
    EXPECT_FALSE(read->surfaces[2].coating.has_value());
}

TEST(PrescriptionReader, OnlyNameAndSurfaceAreRequired) {
    const Result<Prescription> read =
        ReadPrescriptionToml("name = \"x\"\n[[surface]]\nsemi_diameter_mm = 1\n");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->default_coating, "bare");
    EXPECT_FALSE(read->fisheye);
    EXPECT_FALSE(read->design_focal_mm.has_value());
}

TEST(PrescriptionReader, WindowsLineEndsAndAByteOrderMarkAreRead) {
    std::string text = "\xEF\xBB\xBF";
    for (const char* c = kGood; *c != '\0'; ++c) {
        if (*c == '\n') text += '\r';
        text += *c;
    }
    const Result<Prescription> read = ReadPrescriptionToml(text);
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->surfaces[1].where, "line 19, column 1");
}

// The tree of a JSON body: places are JSON pointers and come back as they were given.
TEST(PrescriptionReader, ReportsThePlacesOfTheTreeItReads) {
    DocumentNode surface;
    surface.where = "/prescription/surface/0";
    surface.value = DocumentNode::Table{
        {"semi_diameter_mm", {std::string("wide"), "/prescription/surface/0/semi_diameter_mm"}}};
    DocumentNode root;
    root.where = "/prescription";
    root.value =
        DocumentNode::Table{{"name", {std::string("x"), "/prescription/name"}},
                            {"surface", {DocumentNode::Array{surface}, "/prescription/surface"}}};
    const Result<Prescription> read = ReadPrescription(root);
    ASSERT_FALSE(read.ok());
    EXPECT_EQ(read.error().where, "/prescription/surface/0/semi_diameter_mm");
    EXPECT_EQ(read.error().message,
              "\"semi_diameter_mm\" of surface 0 must be a number, not a string");

    const Result<Prescription> not_a_table =
        ReadPrescription(DocumentNode{std::monostate{}, "/prescription"});
    ASSERT_FALSE(not_a_table.ok());
    EXPECT_EQ(not_a_table.error().where, "/prescription");
}

// One line of the good file is replaced by another text.
struct BadFile {
    const char* what;
    const char* line;  // the line as it stands in kGood
    const char* instead;
    const char* code;
    const char* where;
    const char* says;
};

void PrintTo(const BadFile& file, std::ostream* out) {
    *out << file.what;
}

class RefusedFile : public ::testing::TestWithParam<BadFile> {};

TEST_P(RefusedFile, IsRefusedByLineAndColumn) {
    std::string text = kGood;
    const std::string line = std::string(GetParam().line) + "\n";
    const std::size_t at = text.find(line);
    ASSERT_NE(at, std::string::npos);
    text.replace(at, line.size(), std::string(GetParam().instead) + "\n");
    const Result<Prescription> read = ReadPrescriptionToml(text);
    ASSERT_FALSE(read.ok());
    EXPECT_EQ(read.error().code, GetParam().code);
    EXPECT_EQ(read.error().where, GetParam().where);
    EXPECT_NE(read.error().message.find(GetParam().says), std::string::npos)
        << read.error().message;
}

INSTANTIATE_TEST_SUITE_P(
    Syntax, RefusedFile,
    ::testing::Values(BadFile{"no value", "nd = 1.5", "nd =", "bad_lens", "line 22, column 5",
                              "not TOML"},
                      BadFile{"no equals sign", "nd = 1.5", "nd 1.5", "bad_lens",
                              "line 22, column 4", "not TOML"},
                      BadFile{"open string", "name = \"doublet\"", "name = \"doublet", "bad_lens",
                              "line 1, column 16", "not TOML"},
                      BadFile{"key twice", "nd = 1.5", "nd = 1.5\nnd = 1.6", "bad_lens",
                              "line 23, column 6", "not TOML"},
                      BadFile{"table twice", "[design]", "[design]\n[design]", "bad_lens",
                              "line 10, column 1", "not TOML"},
                      BadFile{"brace in a table's name", "[design]", "[}design]", "bad_lens",
                              "line 9, column 2", "not TOML"},
                      BadFile{"comma for a point", "nd = 1.5", "nd = 1,5", "bad_lens",
                              "line 22, column 7", "not TOML"},
                      BadFile{"not UTF-8", "notes = \"notes\"", "notes = \"\xff\"", "bad_lens",
                              "line 5, column 9", "not TOML"},
                      BadFile{"binary", "notes = \"notes\"", "\x01\x02", "bad_lens",
                              "line 5, column 1", "not TOML"}));

INSTANTIATE_TEST_SUITE_P(
    Keys, RefusedFile,
    ::testing::Values(BadFile{"unknown key of the lens", "maker = \"maker\"", "makr = \"maker\"",
                              "bad_lens", "line 2, column 8", "no key \"makr\""},
                      BadFile{"unknown key of a surface", "nd = 1.5", "n = 1.5", "bad_lens",
                              "line 22, column 5", "surface 1 has no key \"n\""},
                      BadFile{"unit in another key", "radius_mm = 50.0", "radius = 50.0",
                              "bad_lens", "line 20, column 10", "no key \"radius\""},
                      BadFile{"unknown key of design", "f_number = 10.0", "fnumber = 10.0",
                              "bad_lens", "line 11, column 11", "design has no key"},
                      BadFile{"no name", "name = \"doublet\"", "", "bad_lens", "line 1, column 1",
                              "needs \"name\""},
                      BadFile{"no rim", "semi_diameter_mm = 5", "", "bad_lens", "line 14, column 1",
                              "surface 0 needs \"semi_diameter_mm\""},
                      BadFile{"no gap inside", "gap_mm = 6.0", "", "bad_lens", "line 19, column 1",
                              "surface 1 needs \"gap_mm\""},
                      BadFile{"upper case", "nd = 1.5", "ND = 1.5", "bad_lens", "line 22, column 6",
                              "no key \"ND\""}));

INSTANTIATE_TEST_SUITE_P(
    Types, RefusedFile,
    ::testing::Values(BadFile{"name a number", "name = \"doublet\"", "name = 7", "bad_lens",
                              "line 1, column 8", "must be a string, not a number"},
                      BadFile{"name empty", "name = \"doublet\"", "name = \"\"", "bad_lens",
                              "line 1, column 8", "1 to 100 bytes"},
                      BadFile{"name with a control character", "name = \"doublet\"",
                              "name = \"a\\nb\"", "bad_lens", "line 1, column 8", "control"},
                      BadFile{"radius a string", "radius_mm = 50.0", "radius_mm = \"50\"",
                              "bad_lens", "line 20, column 13", "must be a number, not a string"},
                      BadFile{"radius a date", "radius_mm = 50.0", "radius_mm = 1950-01-01",
                              "bad_lens", "line 20, column 13", "date"},
                      BadFile{"radius an array", "radius_mm = 50.0", "radius_mm = [50.0]",
                              "bad_lens", "line 20, column 13", "not an array"},
                      BadFile{"radius infinite", "radius_mm = 50.0", "radius_mm = inf", "bad_lens",
                              "line 20, column 13", "not a finite number"},
                      BadFile{"index NaN", "nd = 1.5", "nd = nan", "bad_lens", "line 22, column 6",
                              "not a finite number"},
                      BadFile{"gap minus infinite", "gap_mm = 6.0", "gap_mm = -inf", "bad_lens",
                              "line 21, column 10", "not a finite number"},
                      BadFile{"coating a number", "coating = \"bare\"", "coating = 550", "bad_lens",
                              "line 25, column 11", "must be a string"},
                      BadFile{"fisheye a string", "fisheye = true", "fisheye = \"yes\"", "bad_lens",
                              "line 7, column 11", "true or false"},
                      BadFile{"unknown kind", "kind = \"plane\"", "kind = \"flat\"", "bad_lens",
                              "line 28, column 8", "\"flat\""},
                      BadFile{"kind a boolean", "kind = \"plane\"", "kind = true", "bad_lens",
                              "line 28, column 8", "must be a string, not a boolean"},
                      BadFile{"design an array and a table", "fisheye = true",
                              "fisheye = true\n[[design]]", "bad_lens", "line 10, column 1",
                              "not TOML"},
                      BadFile{"focal length 0", "focal_mm = 100", "focal_mm = 0", "bad_lens",
                              "line 10, column 12", "above 0"},
                      BadFile{"focal length a boolean", "focal_mm = 100", "focal_mm = false",
                              "bad_lens", "line 10, column 12", "must be a number, not a boolean"},
                      BadFile{"surface a number and tables", "fisheye = true", "surface = 3\n#",
                              "bad_lens", "line 15, column 1", "not TOML"}));

INSTANTIATE_TEST_SUITE_P(
    RealLenses, RefusedFile,
    ::testing::Values(BadFile{"conic a string", "nd = 1.5", "conic = \"-1\"", "bad_lens",
                              "line 22, column 9", "must be a number"},
                      BadFile{"aspheric terms a number", "nd = 1.5", "asphere = 1e-6", "bad_lens",
                              "line 22, column 11", "an array of numbers"},
                      BadFile{"aspheric term infinite", "nd = 1.5", "asphere = [inf]", "bad_lens",
                              "line 22, column 12", "not finite"},
                      BadFile{"sensor without reflectance", "kind = \"plane\"", "kind = \"sensor\"",
                              "bad_lens", "line 27, column 1", "needs \"reflectance\""},
                      BadFile{"states a number", "[design]", "states = 1\n[design]", "bad_lens",
                              "line 9, column 10", "states must be a table"},
                      BadFile{"states with an unknown key", "[design]",
                              "[states]\nfocal = [1]\n[design]", "bad_lens", "line 10, column 9",
                              "no key \"focal\""},
                      BadFile{"focus axis of words", "[design]",
                              "[states]\nfocus_m = [\"far\"]\n[design]", "bad_lens",
                              "line 10, column 12", "no distance"},
                      BadFile{"rows of unequal length", "[design]",
                              "[states]\ngap = [{surface = 1, gap_mm = [[1, 2], [3]]}]\n[design]",
                              "bad_lens", "line 10, column 40", "rows of equal length"},
                      BadFile{"surface of a gap not a whole number", "[design]",
                              "[states]\ngap = [{surface = 1.5, gap_mm = [1]}]\n[design]",
                              "bad_lens", "line 10, column 19", "surface's number"},
                      BadFile{"year with a month", "[design]", "year = 1950.5\n[design]",
                              "bad_lens", "line 9, column 8", "must be a year"},
                      BadFile{"section z", "focal_mm = 100", "focal_mm = 100\nsection = \"z\"",
                              "bad_lens", "line 11, column 11", "\"x\" or \"y\""}));

struct WholeFile {
    const char* what;
    std::string text;
    const char* where;
    const char* says;
};

void PrintTo(const WholeFile& file, std::ostream* out) {
    *out << file.what;
}

class RefusedWhole : public ::testing::TestWithParam<WholeFile> {};

TEST_P(RefusedWhole, IsRefused) {
    const Result<Prescription> read = ReadPrescriptionToml(GetParam().text);
    ASSERT_FALSE(read.ok());
    EXPECT_EQ(read.error().code, "bad_lens");
    EXPECT_EQ(read.error().where, GetParam().where);
    EXPECT_NE(read.error().message.find(GetParam().says), std::string::npos)
        << read.error().message;
}

std::string Repeat(const std::string& text, int count) {
    std::string out;
    for (int i = 0; i < count; ++i) out += text;
    return out;
}

INSTANTIATE_TEST_SUITE_P(
    Table, RefusedWhole,
    ::testing::Values(
        WholeFile{"empty", "", "line 1, column 1", "needs \"name\""},
        WholeFile{"no surfaces", "name = \"x\"", "line 1, column 1", "needs \"surface\""},
        WholeFile{"an empty array of surfaces", "name = \"x\"\nsurface = []", "line 2, column 11",
                  "not 0"},
        WholeFile{"surface a table", "name = \"x\"\n[surface]\n", "line 2, column 1",
                  "array of tables, not a table"},
        WholeFile{"surface an array of numbers", "name = \"x\"\nsurface = [1, 2]",
                  "line 2, column 12", "surface 0 must be a table, not a number"},
        WholeFile{"design a number", "name = \"x\"\ndesign = 50\nsurface = []", "line 2, column 10",
                  "design must be a table"},
        WholeFile{"101 surfaces",
                  "name = \"x\"\n" + Repeat("[[surface]]\ngap_mm = 1\nsemi_diameter_mm = 1\n", 101),
                  "line 2, column 1", "1 to 100 surfaces, not 101"},
        WholeFile{"a megabyte and one byte", std::string((1u << 20) + 1, '#'), "", "1048576"},
        WholeFile{"a name of 101 bytes", "name = \"" + std::string(101, 'x') + "\"",
                  "line 1, column 8", "100"},
        WholeFile{"deep nesting", "name = \"x\"\nnotes = " + std::string(100000, '['),
                  "line 2, column 265", "not TOML"}));

}  // namespace
}  // namespace flare
