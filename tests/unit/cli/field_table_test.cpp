// SPDX-License-Identifier: Apache-2.0
#include "server/cli/field_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "server/lens_library.h"

namespace flare::cli {
namespace {

std::string TablesOf(const std::string& name) {
    const auto lens = LoadLensFile(FLARE_SOURCE_DIR "/lenses/" + name + ".toml");
    EXPECT_TRUE(lens);
    return FieldTables(**lens, {.rows = 2, .wavelengths_nm = {450.0}});
}

TEST(FieldTables, SayWhatTheEdgeIs) {
    const std::string text = TablesOf("tronnier-double-gauss-50mm-f2");
    EXPECT_EQ(text.find("Field at f/2.03, to the edge of the image circle\nfield deg"), 0u) << text;
    EXPECT_NE(text.find("T 450\n"), std::string::npos);
    EXPECT_NE(text.find("\n   23.615    21.650 "), std::string::npos) << text;
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4);
}

TEST(FieldTables, HaveADashForWhatIsNot) {
    const std::string text = TablesOf("shimizu-fisheye-6mm-f2_8-220deg");
    EXPECT_NE(text.find("f-theta %"), std::string::npos);
    EXPECT_NE(text.find("  -  "), std::string::npos) << text;
}

TEST(FieldTables, AreTwoForAnAnamorphicLens) {
    const std::string text = TablesOf("schneider-anamorphic-31mm-f2");
    EXPECT_NE(text.find(", light in the x-z plane"), std::string::npos);
    EXPECT_NE(text.find("\n\nField at f/1.97, light in the y-z plane"), std::string::npos) << text;
}

}  // namespace
}  // namespace flare::cli
