// SPDX-License-Identifier: Apache-2.0
#include "server/lens_library.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace flare {
namespace {

namespace fs = std::filesystem;

constexpr char kSinglet[] = R"(
[[surface]]
kind = "sphere"
radius_mm = 50.0
gap_mm = 5.0
nd = 1.5168
vd = 64.2
semi_diameter_mm = 10.0
[[surface]]
kind = "sphere"
radius_mm = -50.0
gap_mm = 1.0
semi_diameter_mm = 10.0
[[surface]]
kind = "stop"
semi_diameter_mm = 6.0
)";

class LensFolder : public testing::Test {
  protected:
    LensFolder()
        : folder_(fs::temp_directory_path() / ("flare_lenses_" + std::to_string(getpid()))) {
        fs::create_directories(folder_);
    }
    ~LensFolder() override { fs::remove_all(folder_); }

    void Write(const std::string& file, const std::string& text) const {
        std::ofstream(folder_ / file) << text;
    }
    LensLibrary Loaded() const {
        const auto library = LensLibrary::Load(folder_.string());
        EXPECT_TRUE(library);
        return *library;
    }

    fs::path folder_;
};

TEST_F(LensFolder, KeepsGoodLensesBesideBrokenFiles) {
    Write("good.toml", std::string("name = \"good\"\n") + kSinglet);
    Write("syntax.toml", "name = \"syntax\"\nname == 3\n");
    Write("other.toml", std::string("name = \"another\"\n") + kSinglet);
    Write("notes.txt", "not a lens");
    const LensLibrary library = Loaded();
    EXPECT_EQ(library.Names(), (std::vector<std::string>{"good"}));
    ASSERT_EQ(library.broken().size(), 2u);
    EXPECT_EQ(library.broken().at("syntax").where.substr(0, 6), "line 2");
    EXPECT_NE(library.broken().at("other").message.find("another"), std::string::npos);
    EXPECT_TRUE(library.Find("good"));
}

TEST_F(LensFolder, SaysWhyABrokenLensCannotBeHad) {
    Write("syntax.toml", "name = \"syntax\"\nname == 3\n");
    const auto lens = Loaded().Find("syntax");
    ASSERT_FALSE(lens);
    EXPECT_EQ(lens.error().code, "bad_lens");
    EXPECT_NE(lens.error().message.find("line 2"), std::string::npos) << lens.error().message;
}

TEST_F(LensFolder, NamesTheNearestLensesForAnUnknownName) {
    Write("heliar.toml", std::string("name = \"heliar\"\n") + kSinglet);
    Write("planar.toml", std::string("name = \"planar\"\n") + kSinglet);
    const auto lens = Loaded().Find("helia");
    ASSERT_FALSE(lens);
    EXPECT_EQ(lens.error().code, "unknown_lens");
    EXPECT_NE(lens.error().message.find("heliar"), std::string::npos);
    EXPECT_EQ(lens.error().message.find("planar"), std::string::npos);
}

TEST_F(LensFolder, ReadsPathsOnlyWhenTheyAreAllowed) {
    Write("good.toml", std::string("name = \"good\"\n") + kSinglet);
    LensLibrary library;
    const std::string path = (folder_ / "good.toml").string();
    ASSERT_FALSE(library.Find(path));
    EXPECT_EQ(library.Find(path).error().code, "unknown_lens");
    library.AllowPaths();
    ASSERT_TRUE(library.Find(path));
    EXPECT_EQ((*library.Find(path))->name(), "good");
}

TEST(LensLibrary, RefusesAFolderThatIsNotThere) {
    const auto library = LensLibrary::Load("/no/such/folder");
    ASSERT_FALSE(library);
    EXPECT_EQ(library.error().code, "bad_library");
}

TEST(LensLibrary, HoldsTheLensesOfTheSourceTree) {
    const auto library = LensLibrary::Load(FLARE_SOURCE_DIR "/lenses");
    ASSERT_TRUE(library);
    EXPECT_GE(library->Names().size(), 4u);
    for (const auto& [name, error] : library->broken()) {
        ADD_FAILURE() << name << ": " << error.where << ": " << error.message;
    }
}

TEST(DefaultLensDirectory, IsTheOneTheEnvironmentNames) {
    setenv("FLARE_LENSES", "/somewhere", 1);
    EXPECT_EQ(DefaultLensDirectory(), "/somewhere");
    unsetenv("FLARE_LENSES");
    EXPECT_TRUE(
        fs::exists(fs::path(DefaultLensDirectory()) / "tronnier-double-gauss-50mm-f2.toml"));
}

}  // namespace
}  // namespace flare
