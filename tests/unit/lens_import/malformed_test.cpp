// SPDX-License-Identifier: Apache-2.0
//
// Broken files of every format: errors with their place, or a lens that the lint can judge and the
// writer can write; never a crash. FLARE_FUZZ_SECONDS in the environment lets each format's fuzzer
// run that long instead of a fixed number of rounds.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <ostream>
#include <random>
#include <string>

#include "core/prescription/prescription_check.h"
#include "core/prescription/prescription_writer.h"
#include "server/translate/lens_import_json.h"
#include "tests/support/foreign_lens_files.h"
#include "tests/support/lenses.h"

namespace flare {
namespace {

// Whatever comes out must be of use: an error in words, or a lens file that can be read or is
// refused in words. Returns whether it was a lens.
bool Survives(const std::string& text, std::optional<LensFormat> format) {
    const Result<ImportedLens> lens = ImportLensFile(text, format);
    if (!lens) {
        EXPECT_FALSE(lens.error().code.empty());
        EXPECT_FALSE(lens.error().message.empty());
        for (const char c : lens.error().message) {
            EXPECT_GE(static_cast<unsigned char>(c), 0x20) << lens.error().message;
        }
        return false;
    }
    for (const Finding& finding : CheckPrescription(lens->prescription)) {
        EXPECT_FALSE(finding.message.empty());
    }
    const Result<Prescription> back =
        ReadPrescriptionToml(TomlFromPrescription(lens->prescription));
    if (!back) {
        EXPECT_FALSE(back.error().where.empty()) << back.error().message;
    }
    return true;
}

class Broken : public ::testing::TestWithParam<std::size_t> {
  protected:
    const testing::ForeignFormat& format() const { return testing::ForeignFormats()[GetParam()]; }
    std::string text() const {
        return format().write(testing::LibraryPrescription(testing::kHeliarName));
    }
};

TEST_P(Broken, WhereverItIsCutOff) {
    std::string whole = text();
    while (whole.back() == '\n') whole.pop_back();
    const std::optional<LensFormat> named = FormatByName(format().name);
    int lenses = 0, cuts = 0;
    for (std::size_t size = 0; size < whole.size(); size += 1 + whole.size() / 97, ++cuts) {
        lenses += Survives(whole.substr(0, size), named) ? 1 : 0;
        Survives(whole.substr(0, size), std::nullopt);
    }
    // What opens must close: cut off it is never a lens.
    const std::string name = format().name;
    const bool marked = whole.back() == '}' || whole.back() == '>';
    EXPECT_EQ(marked, name == "openlensflare" || name == "realflare" || name == "lentil" ||
                          name == "optiland" || name == "rayoptics");
    if (marked) {
        EXPECT_EQ(lenses, 0) << "of " << cuts;
    }
}

TEST_P(Broken, IfItIsBinaryEmptyOrHuge) {
    const std::optional<LensFormat> named = FormatByName(format().name);
    std::mt19937 random(7);
    std::string binary(4096, '\0');
    for (char& c : binary) c = static_cast<char>(random() & 0xFF);
    for (const auto& form : {named, std::optional<LensFormat>()}) {
        EXPECT_FALSE(Survives(binary, form));
        EXPECT_FALSE(Survives("", form));
        EXPECT_FALSE(Survives(" \n\n ", form));
        EXPECT_FALSE(Survives(std::string(kMaxImportBytes + 1, ' '), form));
    }
    EXPECT_NE(ImportLensFile(std::string(kMaxImportBytes + 1, ' '), named)
                  .error()
                  .message.find("4194305"),
              std::string::npos);
    // Many times the surfaces that a lens may have.
    Prescription tall = testing::LibraryPrescription(testing::kHeliarName);
    const std::vector<SurfacePrescription> once = tall.surfaces;
    for (int i = 0; i < 40; ++i) {
        tall.surfaces.insert(tall.surfaces.begin(), once.begin(), once.begin() + 5);
    }
    const Result<ImportedLens> refused = ImportLensFile(format().write(tall), named);
    ASSERT_FALSE(refused.ok());
    const std::string& message = refused.error().message;
    // The JSON parser has a limit of its own on the members of one object.
    EXPECT_TRUE(message.find("100") != std::string::npos ||
                message.find("128 members") != std::string::npos)
        << message;
    EXPECT_FALSE(refused.error().where.empty());
}

// One semi-diameter (of tables one diameter) replaced by something that is no number.
TEST_P(Broken, IfANumberIsNone) {
    const std::string whole = text();
    const std::optional<LensFormat> named = FormatByName(format().name);
    std::string number = testing::Digits(12.3);
    if (whole.find(number) == std::string::npos) number = testing::Digits(2.0 * 12.3);
    const std::size_t at = whole.find(number);
    ASSERT_NE(at, std::string::npos);
    for (const char* wrong : {"1.85x", "nan", "1e999", "1,8.5", "--1.85"}) {
        std::string broken = whole;
        broken.replace(at, number.size(), wrong);
        const Result<ImportedLens> lens = ImportLensFile(broken, named);
        if (lens.ok()) {
            ADD_FAILURE() << wrong << " was taken for a number";
        } else {
            EXPECT_FALSE(lens.error().where.empty()) << lens.error().message;
        }
    }
}

// --- fuzz ----------------------------------------------------------------------------------------
class Fuzzer {
  public:
    Fuzzer(std::string seed, unsigned number) : seed_(std::move(seed)), random_(number) {}

    std::string Next() {
        std::string text = seed_;
        for (std::size_t edits = 1 + Below(4); edits > 0; --edits) Edit(text);
        return text;
    }

  private:
    std::size_t Below(std::size_t limit) { return limit == 0 ? 0 : random_() % limit; }

    void Edit(std::string& text) {
        static constexpr std::array<const char*, 24> kPieces = {
            "0",    "-1",   "1e308", "-1e-308", "nan",  "inf",  "1e-400", "99999999999999999999",
            "\n",   "\"",   "{",     "]",       "<",    "/>",   ";",      "&",
            "stop", "SURF", "S ",    "MIRROR",  "null", "\x01", "\xFF",   "#"};
        const std::size_t at = Below(text.size() + 1), size = Below(40);
        switch (Below(6)) {
            case 0:
                if (!text.empty()) text[Below(text.size())] = static_cast<char>(random_() & 0xFF);
                break;
            case 1:
                text.erase(at, size);
                break;
            case 2:
                text.insert(at, kPieces[Below(kPieces.size())]);
                break;
            case 3:
                text.insert(Below(text.size() + 1), text.substr(at, size));
                break;
            case 4:
                text.resize(at);
                break;
            default:
                ReplaceNumber(text, at);
        }
    }

    // Wrong numbers go deeper than wrong letters.
    void ReplaceNumber(std::string& text, std::size_t from) {
        static constexpr std::string_view kDigits = "0123456789.-+eE";
        const std::size_t begin = text.find_first_of("0123456789", from);
        if (begin == std::string::npos) return;
        const std::size_t end = std::min(text.find_first_not_of(kDigits, begin), text.size());
        static constexpr std::array<const char*, 10> kNumbers = {
            "0", "-0.0", "1", "-5", "1e-300", "1e300", "1e9", "2.5", "100000", "-1e-12"};
        text.replace(begin, end - begin, kNumbers[Below(kNumbers.size())]);
    }

    std::string seed_;
    std::mt19937 random_;
};

TEST_P(Broken, InAnyWayAFuzzerThinksOf) {
    const std::optional<LensFormat> named = FormatByName(format().name);
    const char* asked = std::getenv("FLARE_FUZZ_SECONDS");
    const double seconds = asked == nullptr ? 0.0 : std::atof(asked);
    const auto begin = std::chrono::steady_clock::now();
    const auto spent = [&begin] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    Fuzzer fuzzer(text(), static_cast<unsigned>(GetParam()) + 1);
    constexpr int kRounds = 200;
    int rounds = 0, lenses = 0;
    while (seconds > 0.0 ? spent() < seconds : rounds < kRounds) {
        const std::string broken = fuzzer.Next();
        lenses += Survives(broken, rounds % 2 == 0 ? named : std::nullopt) ? 1 : 0;
        ++rounds;
        if (HasFailure()) {
            FAIL() << "round " << rounds << ":\n" << broken;
        }
    }
    RecordProperty("rounds", rounds);
    RecordProperty("lenses", lenses);
    if (seconds > 0.0) {
        std::printf("%s: %d texts, %d of them lenses\n", format().name, rounds, lenses);
    }
    // A fuzzer that never gets through tests only the first line.
    EXPECT_GT(lenses, 0);
    EXPECT_LT(lenses, rounds);
}

INSTANTIATE_TEST_SUITE_P(Formats, Broken, ::testing::Range<std::size_t>(0, 10),
                         [](const auto& shown) {
                             return std::string(testing::ForeignFormats()[shown.param].name);
                         });

struct BadFile {
    const char* what;
    const char* text;
    const char* code;
    const char* where;
    const char* says;
};

void PrintTo(const BadFile& file, std::ostream* out) {
    *out << file.what;
}

class BadFiles : public ::testing::TestWithParam<BadFile> {};

TEST_P(BadFiles, AreRefusedWithPlaceAndReason) {
    const BadFile& file = GetParam();
    const Result<ImportedLens> lens = ImportLensFile(file.text, std::nullopt);
    ASSERT_FALSE(lens.ok());
    EXPECT_EQ(lens.error().code, file.code) << lens.error().message;
    EXPECT_EQ(lens.error().where, file.where) << lens.error().message;
    EXPECT_NE(lens.error().message.find(file.says), std::string::npos) << lens.error().message;
}

INSTANTIATE_TEST_SUITE_P(
    Table, BadFiles,
    ::testing::Values(
        BadFile{"a table row short of a column", "# t\n50 3 1.5 20\n-50 90 1\n", "bad_lens",
                "line 3", "3 columns, not 4"},
        BadFile{"six columns without names", "1 2 3 4 5 6\n", "bad_lens", "line 1", "6 columns"},
        BadFile{"a flaresim row with a word", "surfaces:\n  50 3 1.5 60 ten 0\n", "bad_lens",
                "line 2", "semi_ap is \"ten\""},
        BadFile{"flaresim without rows", "name: x\nsurfaces:\n", "bad_lens", "", "no rows"},
        BadFile{"zemax: a tilt",
                "UNIT MM\nSURF 0\nDISZ INFINITY\nSURF 1\nTYPE COORDBRK\nDISZ 1\nSURF 2\nDISZ 0\n",
                "unsupported", "line 4", "COORDBRK"},
        BadFile{"zemax: not sequential", "MODE NSC\nSURF 0\nSURF 1\nSURF 2\n", "unsupported",
                "line 1", "not sequential"},
        BadFile{"zemax: surfaces out of order", "SURF 0\nSURF 2\n", "bad_lens", "line 2",
                "SURF 1 should stand here"},
        BadFile{"zemax: a glass nobody knows",
                "SURF 0\nDISZ INFINITY\nSURF 1\nCURV 0.02\nDISZ 3\nGLAS XYZ99 0 0 1.5 40\nSURF 2\n"
                "DISZ 1\nSURF 3\nDISZ 0\n",
                "bad_lens", "line 3", "\"XYZ99\" is in no catalogue"},
        BadFile{"zemax: an unknown unit", "UNIT FURLONG\nSURF 0\nSURF 1\nSURF 2\n", "bad_lens",
                "line 1", "FURLONG"},
        BadFile{"codev: a mirror", "RDM;LEN\nSO 0 1e14\nS 100 5 REFL\nSI 0 0\n", "unsupported",
                "line 3", "mirror"},
        BadFile{"codev: a thickness set afterwards",
                "RDM;LEN\nSO 0 1e14\nS 100 5 NBK7_SCHOTT\nS 0 90\nTHI S1 7\nSI 0 0\n",
                "unsupported", "line 5", "another lens"},
        BadFile{"codev: a glass that the maker does not have",
                "RDM\nSO 0 1e14\nS 100 5 NBK7_OHARA\nS 0 9\nSI 0 0\n", "bad_lens", "line 3",
                "SCHOTT N-BK7"},
        BadFile{"codev: no image", "RDM\nSO 0 1e14\nS 100 5 NBK7_SCHOTT\nS 0 9\n", "bad_lens", "",
                "no image surface"},
        BadFile{"XML cut off", "<opticalSystem>\n<elements>\n<element>\n", "bad_lens", "line 3",
                "not XML"},
        BadFile{"XML of something else", "<html><body/></html>", "bad_lens", "line 1",
                "no <opticalSystem>"},
        BadFile{"an element without height",
                "<opticalSystem><elements>\n<element><type>lensSpherical</type></element>\n"
                "</elements></opticalSystem>",
                "bad_lens", "line 2", "no <height>"},
        BadFile{"realflare: a stop that is no row",
                "{\"aperture_index\": 5, \"lens_elements\": [{\"radius\": 1}]}", "bad_lens",
                "/aperture_index", "which is no row"},
        BadFile{"realflare: a radius in quotes",
                "{\"aperture_index\": 0, \"lens_elements\": [{\"radius\": \"1\"}]}", "bad_lens",
                "/lens_elements/0/radius", "no finite number"},
        BadFile{"lentil: an asphere",
                "{\"optical-elements-patent\": [{\"radius\": 9, \"thickness\": 1, "
                "\"housing-radius\": 3, \"aspherical-equation\": \"z\"}]}",
                "unsupported", "/optical-elements-patent/0/aspherical-equation", "cannot be read"},
        BadFile{"optiland: a mirror",
                "{\"surface_group\": {\"surfaces\": [{}, {\"geometry\": {\"type\": \"Plane\", "
                "\"cs\": {\"z\": 0}}, \"is_reflective\": true}, {}]}}",
                "unsupported", "/surface_group/surfaces/1", "mirror"},
        BadFile{"rayoptics: a thin lens",
                "{\"optical_model\": {\"attributes\": {\"seq_model\": {\"attributes\": {\"ifcs\": "
                "[{}, {\"__instance_type__\": [\"m\", \"ThinLens\"], \"attributes\": {}}, {}], "
                "\"gaps\": [{}, {\"attributes\": {}}]}}}}}",
                "unsupported", "/optical_model/attributes/seq_model/attributes/ifcs/1", "ThinLens"},
        BadFile{"JSON with a comma too many", "{\"lens_elements\": [\n1,\n]}", "bad_json",
                "byte 24", "line 3"}));

}  // namespace
}  // namespace flare
