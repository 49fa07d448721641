// SPDX-License-Identifier: Apache-2.0
//
// What scripts rely on: exit codes, what goes to which stream, and messages that name the place.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "server/cli/app.h"
#include "server/cli/table.h"

namespace flare::cli {
namespace {

namespace fs = std::filesystem;

constexpr char kSeedFile[] = FLARE_SOURCE_DIR "/lenses/tronnier-double-gauss-50mm-f2.toml";

constexpr char kRequest[] =
    R"({"prescription":{"name":"singlet","surface":[
          {"kind":"sphere","radius_mm":50,"gap_mm":5,"nd":1.5168,"vd":64.2,"semi_diameter_mm":10},
          {"kind":"sphere","radius_mm":-50,"gap_mm":1,"semi_diameter_mm":10},
          {"kind":"stop","semi_diameter_mm":6}]},
        "image":{"width":32,"height":18,"sensor_width_mm":36},"quality":{"preset":"draft"},
        "lights":[{"direction":[0.1,0,1]}]})";

class Cli : public testing::Test {
  protected:
    Cli() : folder_(fs::temp_directory_path() / ("flare_cli_" + std::to_string(getpid()))) {
        fs::create_directories(folder_);
    }
    ~Cli() override { fs::remove_all(folder_); }

    std::string File(const std::string& name) const { return (folder_ / name).string(); }
    std::string Written(const std::string& name, const std::string& text) const {
        std::ofstream(File(name)) << text;
        return File(name);
    }
    static std::string Contents(const std::string& path) {
        std::ifstream file(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    }
    int Flare(const std::vector<std::string>& arguments) {
        std::vector<const char*> argv{"flare"};
        for (const std::string& argument : arguments) argv.push_back(argument.c_str());
        testing::internal::CaptureStdout();
        testing::internal::CaptureStderr();
        const int code = cli::Run(static_cast<int>(argv.size()), argv.data());
        out_ = testing::internal::GetCapturedStdout();
        err_ = testing::internal::GetCapturedStderr();
        return code;
    }

    fs::path folder_;
    std::string out_, err_;
};

TEST_F(Cli, AnswersHelpAndVersionOnStandardOutput) {
    EXPECT_EQ(Flare({"--help"}), kDone);
    EXPECT_NE(out_.find("render"), std::string::npos);
    EXPECT_EQ(Flare({"--version"}), kDone);
    EXPECT_EQ(out_.substr(0, 6), "flare ");
}

TEST_F(Cli, RefusesBadUsageWithExitCodeTwo) {
    const std::vector<std::vector<std::string>> bad{
        {},
        {"bogus"},
        {"lens"},
        {"lens", "bogus"},
        {"render"},
        {"render", "a.json"},
        {"render", "a.json", "-o", "a.exr", "--bogus"},
        {"render", "a.json", "-o", "a.exr", "--threads", "0"},
        {"render", "a.json", "-o", "a.exr", "--server", "nonsense"},
        {"render", "a.json", "-o", "a.exr", "--server", "unix:/x", "--threads", "2"},
        {"ghosts", kSeedFile, "--f-number", "0"},
        {"ghosts", kSeedFile, "--f-number", "nan"},
        {"ghosts", kSeedFile, "--field-deg", "1e9"},
        {"ghosts", kSeedFile, "--focus-m", "0"},
        {"ghosts", kSeedFile, "--focus-m", "nan"},
        {"ghosts", kSeedFile, "--reflections", "3"},
        {"ghosts", kSeedFile, "--threshold", "-1"},
        {"ghosts", kSeedFile, "--uncoated", "--coatings", "mgf2-550"},
        {"ghosts", kSeedFile, "--coatings", "magic"},
        {"ghosts", kSeedFile, "--sensor-reflection"},
        {"lens", "show", kSeedFile, "--zoom-mm", "-50"},
        {"glass"},
        {"glass", "show", "BK7"},
        {"glass", "list", "--maker", "NOBODY"},
        {"compare", "a.exr"},
    };
    for (const std::vector<std::string>& arguments : bad) {
        EXPECT_EQ(Flare(arguments), kBadInput) << testing::PrintToString(arguments);
        EXPECT_TRUE(out_.empty()) << testing::PrintToString(arguments) << out_;
        EXPECT_FALSE(err_.empty()) << testing::PrintToString(arguments);
    }
}

TEST_F(Cli, NamesFileAndPlaceOfBadInput) {
    const std::string syntax = Written("syntax.json", "{\"lens\":}");
    EXPECT_EQ(Flare({"render", syntax, "-o", File("a.exr")}), kBadInput);
    EXPECT_NE(err_.find(syntax + ": byte 9"), std::string::npos) << err_;

    std::string text = kRequest;
    text.replace(text.find("[0.1,0,1]"), 9, "[0,0,0]");
    EXPECT_EQ(Flare({"render", Written("zero.json", text), "-o", File("a.exr")}), kBadInput);
    EXPECT_NE(err_.find("zero.json: /lights/0/direction"), std::string::npos) << err_;

    const std::string lens = Written("broken.toml", "name = \"broken\"\nradius = = 3\n");
    EXPECT_EQ(Flare({"lens", "check", lens}), kBadInput);
    EXPECT_NE(err_.find("broken.toml: line 2, column"), std::string::npos) << err_;
    EXPECT_EQ(Flare({"lens", "show", lens}), kBadInput);
    EXPECT_NE(err_.find("broken.toml: line 2, column"), std::string::npos) << err_;

    EXPECT_EQ(Flare({"render", File("absent.json"), "-o", File("a.exr")}), kBadInput);
    EXPECT_EQ(Flare({"compare", Written("a.txt", "no"), File("a.txt")}), kBadInput);
    EXPECT_FALSE(fs::exists(File("a.exr")));
}

TEST_F(Cli, EndsWithThreeWhereNoServerIs) {
    const std::string request = Written("r.json", kRequest);
    const std::string server = "unix:" + File("no.sock");
    EXPECT_EQ(Flare({"render", request, "-o", File("a.exr"), "--server", server}), kServerFailed);
    EXPECT_NE(err_.find(server), std::string::npos) << err_;
}

TEST_F(Cli, EndsWithOneWhereTheOutputCannotBeWritten) {
    const std::string request = Written("r.json", kRequest);
    EXPECT_EQ(Flare({"render", request, "-o", File("no/folder/a.exr")}), kFailed);
}

TEST_F(Cli, RendersToFilesAndToStandardOutputAlike) {
    const std::string request = Written("r.json", kRequest);
    ASSERT_EQ(Flare({"render", request, "-o", File("a.exr"), "--report", File("a.report")}), kDone)
        << err_;
    const std::string exr = Contents(File("a.exr"));
    EXPECT_EQ(exr.substr(0, 4), "v/1\x01");
    EXPECT_NE(Contents(File("a.report")).find("\"request_hash\""), std::string::npos);
    ASSERT_EQ(Flare({"render", request, "-o", "-", "--threads", "3"}), kDone);
    EXPECT_TRUE(out_ == exr);
    ASSERT_EQ(Flare({"render", request, "-o", File("a.png")}), kDone);
    EXPECT_EQ(Contents(File("a.png")).substr(1, 3), "PNG");
    ASSERT_EQ(Flare({"compare", File("a.exr"), File("a.exr"), "--json"}), kDone);
    EXPECT_NE(out_.find("\"rel_l1\": 0,"), std::string::npos) << out_;
}

TEST_F(Cli, ShowsAndChecksLenses) {
    EXPECT_EQ(Flare({"lens", "list"}), kDone);
    EXPECT_NE(out_.find("tronnier-double-gauss-50mm-f2"), std::string::npos);
    EXPECT_EQ(Flare({"lens", "show", kSeedFile, "--json"}), kDone);
    EXPECT_NE(out_.find("\"efl_mm\": 50.358"), std::string::npos) << out_;
    EXPECT_EQ(Flare({"lens", "check", kSeedFile}), kDone);
    EXPECT_NE(out_.find("0 errors"), std::string::npos) << out_;
    EXPECT_EQ(Flare({"lens", "show", "no-such-lens"}), kBadInput);
}

TEST_F(Cli, ShowsALensInItsState) {
    ASSERT_EQ(Flare({"lens", "show", kSeedFile, "--focus-m", "1", "--json"}), kDone) << err_;
    EXPECT_NE(out_.find("\"focus_m\": 1,"), std::string::npos) << out_;
    EXPECT_NE(out_.find("\"focus_shift_mm\": 2.811"), std::string::npos) << out_;
    ASSERT_EQ(Flare({"lens", "show", kSeedFile, "--focus-m", "0.01", "--zoom-mm", "85"}), kDone);
    EXPECT_NE(out_.find("zoom_mm clamped from 85 to 50"), std::string::npos) << out_;
    EXPECT_NE(out_.find("focus_m clamped from 0.01 to 0.19"), std::string::npos) << out_;
    ASSERT_EQ(Flare({"lens", "show", "nikon-zoom-80-200mm-f2_8", "--zoom-mm", "200"}), kDone);
    EXPECT_NE(out_.find("zoom 200 mm"), std::string::npos) << out_;
    ASSERT_EQ(Flare({"lens", "show", "schneider-anamorphic-31mm-f2"}), kDone);
    EXPECT_NE(out_.find("EFL in x                31.48"), std::string::npos) << out_;
    EXPECT_NE(out_.find("EFL in y                60.55"), std::string::npos) << out_;
}

TEST_F(Cli, RanksTheGhostsThatAreAskedFor) {
    const std::string lens = Written("small.toml", R"(name = "small"
[[surface]]
kind = "stop"
gap_mm = 2.0
semi_diameter_mm = 5.0
[[surface]]
radius_mm = 50.0
gap_mm = 6.0
nd = 1.5
semi_diameter_mm = 10.0
[[surface]]
kind = "plane"
semi_diameter_mm = 10.0
[[surface]]
kind = "sensor"
reflectance = 0.1
semi_diameter_mm = 20.0
)");
    ASSERT_EQ(Flare({"ghosts", lens, "--field-deg", "-5"}), kDone) << err_;
    EXPECT_NE(out_.find("of 1 ghosts"), std::string::npos) << out_;
    ASSERT_EQ(
        Flare({"ghosts", lens, "--sensor-reflection", "--focus-m", "2", "--azimuth-deg", "45"}),
        kDone);
    EXPECT_NE(out_.find("of 3 ghosts"), std::string::npos) << out_;
    EXPECT_NE(out_.find("focus 2 m"), std::string::npos) << out_;
    ASSERT_EQ(Flare({"ghosts", lens, "--reflections", "4", "--threshold", "1e-14", "--coatings",
                     "mgf2-500", "--json"}),
              kDone);
    EXPECT_NE(out_.find("\"four_reflections\": {\"threshold\": 1e-14,"), std::string::npos) << out_;
    EXPECT_NE(out_.find("\"sequence\": [2, 1, 2, 1]"), std::string::npos) << out_;
    EXPECT_NE(out_.find("\"coatings\": \"mgf2-500\""), std::string::npos) << out_;
}

// The indices are those of the maker's data sheet.
TEST_F(Cli, ShowsGlasses) {
    ASSERT_EQ(Flare({"glass", "show", "n-bk7"}), kDone) << err_;
    EXPECT_EQ(out_.substr(0, out_.find('\n')), "SCHOTT N-BK7");
    for (const char* index : {"1.516800", "1.522376", "1.514322"}) {
        EXPECT_NE(out_.find(index), std::string::npos) << index << out_;
    }
    ASSERT_EQ(Flare({"glass", "list", "--maker", "SUMITA"}), kDone);
    EXPECT_NE(out_.find("SUMITA K-BaF8"), std::string::npos);
    EXPECT_EQ(out_.find("SCHOTT"), std::string::npos);
}

TEST(Table, AlignsNumbersRightAndWordsLeft) {
    Table table({"name", "n"});
    table.AddRow({"a", "1.5"});
    table.AddRow({"M\xc3\xbcller", "-10"});
    EXPECT_EQ(table.text(), "name      n\na       1.5\nM\xc3\xbcller  -10\n");
}

TEST(Fixed, ShowsNoMinusBeforeZero) {
    EXPECT_EQ(Fixed(-0.0001, 2), "0.00");
    EXPECT_EQ(Fixed(-0.01, 2), "-0.01");
}

TEST_F(Cli, ExplainsAPictureInWords) {
    std::string request = kRequest;
    const std::string draft = R"({"preset":"draft"})";
    request.replace(request.find(draft), draft.size(), R"({"max_error":0.1})");
    ASSERT_EQ(Flare({"render", Written("r.json", request), "-o", File("r.exr"), "--explain"}), 0);
    EXPECT_NE(err_.find("Asked for an error of at most 10 %; drawn: tolerance 0."),
              std::string::npos)
        << err_;
    EXPECT_NE(err_.find("Estimated error "), std::string::npos) << err_;
    EXPECT_NE(err_.find("Not modelled: ghosts of four reflections"), std::string::npos) << err_;
    EXPECT_EQ(out_, "");
    EXPECT_EQ(err_.find("artist"), std::string::npos) << err_;
}

TEST_F(Cli, SaysWhatCannotBeSeen) {
    std::string request = kRequest;
    request.insert(1, R"("visible": {"noise_floor": 4e9, "exposure_stops": 2}, )");
    ASSERT_EQ(Flare({"render", Written("r.json", request), "-o", File("r.exr"), "--explain"}), 0)
        << err_;
    EXPECT_NE(err_.find("Nothing fainter than 1e+09 can be seen"), std::string::npos) << err_;
    EXPECT_NE(err_.find("Left out: ghosts ("), std::string::npos) << err_;
    EXPECT_NE(err_.find("Together at most "), std::string::npos) << err_;
}

TEST_F(Cli, SaysWhatAnArtistHasChanged) {
    for (const auto& [ghost, words] :
         {std::pair{R"("gain": 2)", "changed the gain or tint of 1 ghost(s) and muted 0"},
          {R"("mute": true)", "changed the gain or tint of 0 ghost(s) and muted 1"}}) {
        std::string request = kRequest;
        request.insert(
            1, R"("artist": {"ghosts": [{"sequence": [1, 0], )" + std::string(ghost) + "}]}, ");
        ASSERT_EQ(Flare({"render", Written("r.json", request), "-o", File("r.exr"), "--explain"}),
                  0)
            << err_;
        EXPECT_NE(err_.find(words), std::string::npos) << err_;
    }
}

TEST_F(Cli, TradeoffNamesWhatItDoesNotKnow) {
    EXPECT_EQ(
        Flare({"tradeoff", "tronnier-double-gauss-50mm-f2", "-o", File("t"), "--knobs", "grid=7"}),
        kBadInput);
    EXPECT_NE(err_.find("grid=7 is no knob and no value of one"), std::string::npos) << err_;
    EXPECT_EQ(Flare({"tradeoff", "tronnier-double-gauss-50mm-f2", "-o", File("t"), "--size", "9"}),
              kBadInput);
    EXPECT_NE(err_.find("--size 9"), std::string::npos) << err_;
}

}  // namespace
}  // namespace flare::cli
