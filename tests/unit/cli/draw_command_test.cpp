// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/cli/app.h"

namespace flare::cli {
namespace {

constexpr char kSeed[] = FLARE_SOURCE_DIR "/lenses/tronnier-double-gauss-50mm-f2.toml";

struct Outcome {
    int code = 0;
    std::string out, err;
};

Outcome Draw(const std::vector<std::string>& more) {
    std::vector<const char*> argv{"flare", "lens", "draw", kSeed};
    for (const std::string& argument : more) argv.push_back(argument.c_str());
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    Outcome outcome;
    outcome.code = cli::Run(static_cast<int>(argv.size()), argv.data());
    outcome.out = testing::internal::GetCapturedStdout();
    outcome.err = testing::internal::GetCapturedStderr();
    return outcome;
}

TEST(LensDraw, WritesOneDrawingToStandardOutput) {
    const Outcome drawn =
        Draw({"-o", "-", "--ghost", "9,1", "--ghost", "(3, 1,2,0)", "--field-deg", "-5"});
    EXPECT_EQ(drawn.code, kDone);
    EXPECT_EQ(drawn.err, "");
    EXPECT_EQ(drawn.out.substr(0, 4), "<svg");
    EXPECT_EQ(drawn.out.substr(drawn.out.size() - 7), "</svg>\n");
    EXPECT_NE(drawn.out.find("data-sequence=\"(9,1)\""), std::string::npos);
    EXPECT_NE(drawn.out.find("data-sequence=\"(3,1,2,0)\""), std::string::npos);
    EXPECT_NE(drawn.out.find("light at -5"), std::string::npos);
}

TEST(LensDraw, SaysWhatItClamped) {
    const Outcome drawn = Draw({"-o", "-", "--f-number", "1", "--focus-m", "0.01"});
    EXPECT_EQ(drawn.code, kDone);
    EXPECT_NE(drawn.err.find("f_number clamped: 1 -> 2.0"), std::string::npos) << drawn.err;
    EXPECT_NE(drawn.err.find("focus_m clamped: 0.01 -> "), std::string::npos) << drawn.err;
    const Outcome wide = Draw({"-o", "-"});
    EXPECT_EQ(wide.err, "");
}

TEST(LensDraw, RefusesBadInputAndWritesNothing) {
    const std::vector<std::vector<std::string>> bad{
        {"--ghost", "9,5"},
        {"--ghost", "1,9"},
        {"--ghost", "9"},
        {"--ghost", "9,"},
        {"--ghost", "9 1"},
        {"--ghost", ""},
        {"--ghost", "nine,one"},
        {"--ghost", "9,99999999999999999999"},
        {"--ghost", "9,1,9,1,9,1,9,1,9,1"},
        {"--field-deg", "nan"},
        {"--field-deg", "181"},
        {"--focus-m", "0"},
        {"--zoom-mm", "-1"},
        {"--f-number", "inf"},
    };
    for (const auto& arguments : bad) {
        std::vector<std::string> all{"-o", "-"};
        all.insert(all.end(), arguments.begin(), arguments.end());
        const Outcome outcome = Draw(all);
        EXPECT_EQ(outcome.code, kBadInput) << arguments[1];
        EXPECT_EQ(outcome.out, "") << arguments[1];
        EXPECT_NE(outcome.err, "") << arguments[1];
    }
    EXPECT_EQ(Draw({}).code, kBadInput);  // no -o
    EXPECT_EQ(Draw({"-o", "/nowhere/at/all.svg"}).code, kFailed);
}

}  // namespace
}  // namespace flare::cli
