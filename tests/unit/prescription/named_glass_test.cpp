// SPDX-License-Identifier: Apache-2.0
//
// Glass by name, from the text of a lens file to the lens.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "core/optics/lens.h"
#include "core/prescription/prescription_check.h"
#include "core/prescription/prescription_reader.h"

namespace flare {
namespace {

// A plano-convex lens whose focal length is 50 mm / (n - 1).
std::string File(const std::string& medium) {
    return "name = \"x\"\nsource = \"s\"\ndesign = { focal_mm = 96.75, f_number = 9.7 }\n"
           "[[surface]]\nkind = \"stop\"\ngap_mm = 2\nsemi_diameter_mm = 5\n"
           "[[surface]]\nradius_mm = 50\ngap_mm = 6\n" +
           medium + "\nsemi_diameter_mm = 10\n[[surface]]\nsemi_diameter_mm = 10\n";
}

std::shared_ptr<const Lens> Built(const std::string& medium) {
    const Result<Prescription> read = ReadPrescriptionToml(File(medium));
    EXPECT_TRUE(read.ok()) << read.error().message;
    const auto lens = Lens::Build(*read);
    EXPECT_TRUE(lens.ok()) << lens.error().message;
    return *lens;
}

TEST(NamedGlass, BuildsTheLensThatItsIndexSays) {
    const auto named = Built("glass = \"SCHOTT N-BK7\"");
    EXPECT_EQ(named->prescription().surfaces[1].glass, "SCHOTT N-BK7");
    EXPECT_NEAR(named->first_order().efl_mm, 50.0 / 0.516800, 1e-4);
    const auto by_index = Built("nd = 1.5168\nvd = 64.17");
    EXPECT_NEAR(named->first_order().efl_mm, by_index->first_order().efl_mm, 1e-5);
    // The two-term formula is off by up to 1.5e-4 away from the d line, but not by nothing.
    const double off = named->MediumBehind(1).Index(404.7) - by_index->MediumBehind(1).Index(404.7);
    EXPECT_LT(std::abs(off), 1.5e-4);
    EXPECT_GT(std::abs(off), 1e-5);
    EXPECT_NE(named->geometry_fingerprint(), by_index->geometry_fingerprint());
    EXPECT_EQ(named->geometry_fingerprint(), Built("glass = \"n-bk7\"")->geometry_fingerprint());
}

// The plain and the high-transmission melt bend alike and absorb differently.
TEST(NamedGlass, AbsorptionIsPartOfTheLensAndNotOfItsGeometry) {
    const auto plain = Built("glass = \"N-SF6\""), clear = Built("glass = \"N-SF6HT\"");
    EXPECT_EQ(plain->geometry_fingerprint(), clear->geometry_fingerprint());
    EXPECT_NE(plain->fingerprint(), clear->fingerprint());
}

TEST(NamedGlass, NeedsNoVNumber) {
    const std::vector<Finding> findings =
        CheckPrescription(*ReadPrescriptionToml(File("glass = \"N-BK7\"")));
    EXPECT_TRUE(findings.empty()) << findings.front().message;
}

TEST(NamedGlass, MayStandOnBothSidesOfTheStop) {
    const auto file = [](const std::string& behind_stop) {
        return ReadPrescriptionToml(
            "name = \"x\"\n[[surface]]\nradius_mm = 50\ngap_mm = 3\nsemi_diameter_mm = 9\n"
            "glass = \"SCHOTT N-BK7\"\n[[surface]]\nkind = \"stop\"\ngap_mm = 3\n"
            "semi_diameter_mm = 5\n" +
            behind_stop + "\n[[surface]]\nsemi_diameter_mm = 9\n");
    };
    EXPECT_TRUE(Lens::Build(*file("glass = \"N-BK7\"")).ok());
    EXPECT_FALSE(Lens::Build(*file("glass = \"N-SF6\"")).ok());
    EXPECT_FALSE(Lens::Build(*file("nd = 1.5168\nvd = 64.17")).ok());
}

struct BadMedium {
    const char* medium;
    const char* says;
};

void PrintTo(const BadMedium& bad, std::ostream* out) {
    *out << bad.medium;
}

class RefusedMedium : public ::testing::TestWithParam<BadMedium> {};

TEST_P(RefusedMedium, IsRefusedAtItsSurface) {
    const Result<Prescription> read = ReadPrescriptionToml(File(GetParam().medium));
    ASSERT_TRUE(read.ok()) << read.error().message;
    const std::vector<Finding> findings = CheckPrescription(*read);
    ASSERT_FALSE(findings.empty());
    EXPECT_EQ(findings.front().severity, Severity::kError);
    EXPECT_EQ(findings.front().code, "glass");
    EXPECT_EQ(findings.front().where, "line 8, column 1");
    EXPECT_NE(findings.front().message.find(GetParam().says), std::string::npos)
        << findings.front().message;
    EXPECT_EQ(findings.size(), 1u) << "an unknown glass is no lens without glass";
    const auto lens = Lens::Build(*read);
    ASSERT_FALSE(lens.ok());
    EXPECT_EQ(lens.error().code, "bad_lens");
    EXPECT_EQ(lens.error().where, "line 8, column 1");
}

INSTANTIATE_TEST_SUITE_P(
    Table, RefusedMedium,
    ::testing::Values(BadMedium{"glass = \"NBK7\"",
                                "surface 1: there is no glass \"NBK7\"; the "
                                "nearest names are SCHOTT N-BK7"},
                      BadMedium{"glass = \"F2\"", "HIKARI F2"},
                      BadMedium{"glass = \"\"", "there is no glass \"\""},
                      BadMedium{"glass = \"N-BK7\"\nnd = 1.5168", "together with nd or vd"},
                      BadMedium{"glass = \"N-BK7\"\nvd = 64.17", "together with nd or vd"}));

TEST(NamedGlass, IsAString) {
    const Result<Prescription> read = ReadPrescriptionToml(File("glass = 1.5"));
    ASSERT_FALSE(read.ok());
    EXPECT_EQ(read.error().message, "\"glass\" of surface 1 must be a string, not a number");
    EXPECT_EQ(read.error().where, "line 11, column 9");
}

}  // namespace
}  // namespace flare
