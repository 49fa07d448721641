// SPDX-License-Identifier: Apache-2.0
#include "core/prescription/coating_reader.h"

#include <gtest/gtest.h>

#include "core/optics/lens.h"
#include "core/prescription/prescription_reader.h"

namespace flare {
namespace {

constexpr const char* kFile = R"(name = "amber"
notes = "warm"
source = "a test"
layers = [
    { material = "MgF2", thickness_nm = 82.0 },
    { n = 2.1, k = 0.001, thickness_nm = 20 },
    { material = "TiO2-Sarkar", thickness_nm = 12.5 },
]
)";

TEST(CoatingReader, ReadsLayersFromTheAirSide) {
    const Result<CoatingDesign> read = ReadCoatingToml(kFile);
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->name(), "amber");
    EXPECT_EQ(read->notes, "warm");
    EXPECT_EQ(read->source, "a test");
    ASSERT_EQ(read->layers().size(), 3U);
    EXPECT_EQ(read->layers()[0].material, *MaterialByName("MgF2"));
    EXPECT_EQ(read->layers()[0].thickness_nm, 82.0);
    EXPECT_EQ(read->layers()[1].material.Index(550.0), std::complex<double>(2.1, 0.001));
    EXPECT_EQ(read->layers()[1].thickness_nm, 20.0);
    EXPECT_EQ(read->layers()[2].material.name(), "TiO2-Sarkar");
}

std::string With(const std::string& layers) {
    return "name = \"x\"\nlayers = [\n" + layers + "\n]\n";
}

struct BadCoating {
    const char* what;
    std::string text;
    const char* where;
    const char* says;
};

TEST(CoatingReader, SaysWhatIsWrongAndWhere) {
    std::string many;
    for (int i = 0; i < 101; ++i) many += "{n = 1.5, thickness_nm = 1.0},\n";
    for (const BadCoating& bad :
         {BadCoating{"n 0", With("{n = 0, thickness_nm = 9.0}"), "line 3, column 1", "n is 0"},
          {"n negative", With("{n = -1.5, thickness_nm = 9.0}"), "line 3, column 1", "n is -1.5"},
          {"k negative", With("{n = 1.5, k = -0.1, thickness_nm = 9.0}"), "line 3, column 1",
           "k is -0.1"},
          {"negative thickness", With("{material = \"MgF2\", thickness_nm = -9.0}"),
           "line 3, column 1", "thickness_nm is -9"},
          {"infinite thickness", With("{material = \"MgF2\", thickness_nm = inf}"),
           "line 3, column 36", "not a finite number"},
          {"second layer", With("{n = 1.5, thickness_nm = 9.0},\n{n = 0, thickness_nm = 9.0}"),
           "line 4, column 1", "layer 1"},
          {"unknown material", With("{material = \"Cheese\", thickness_nm = 9.0}"),
           "line 3, column 13", "Cheese"},
          {"material a number", With("{material = 3, thickness_nm = 9.0}"), "line 3, column 13",
           "must be a string"},
          {"both", With("{material = \"MgF2\", n = 1.5, thickness_nm = 9.0}"), "line 3, column 1",
           "either"},
          {"material and k", With("{material = \"MgF2\", k = 0.1, thickness_nm = 9.0}"),
           "line 3, column 1", "either"},
          {"neither", With("{thickness_nm = 9.0}"), "line 3, column 1", "either"},
          {"k alone", With("{k = 0.1, thickness_nm = 9.0}"), "line 3, column 1", "either"},
          {"no thickness", With("{n = 1.5}"), "line 3, column 1", "needs \"thickness_nm\""},
          {"unknown key", With("{n = 1.5, thickness_nm = 9.0, colour = 1}"), "line 3, column 40",
           "colour"},
          {"not a table", With("7"), "line 3, column 1", "must be a table"},
          {"101 layers", With(many), "line 2, column 10", "limit is 100"},
          {"no layers", "name = \"x\"\n", "line 1, column 1", "needs \"layers\""},
          {"layers a number", "name = \"x\"\nlayers = 3\n", "line 2, column 10",
           "must be an array"},
          {"no name", "layers = []\n", "line 1, column 1", "needs \"name\""},
          {"empty name", "name = \"\"\nlayers = []\n", "line 1, column 8", "1 to 100 bytes"},
          {"the name none", "name = \"none\"\nlayers = []\n", "line 1, column 8", "none"},
          {"not TOML", "layers = [", "line 1, column 11", "not TOML"}}) {
        const Result<CoatingDesign> read = ReadCoatingToml(bad.text);
        ASSERT_FALSE(read.ok()) << bad.what;
        EXPECT_EQ(read.error().code, "bad_lens") << bad.what;
        EXPECT_EQ(read.error().where, bad.where) << bad.what;
        EXPECT_NE(read.error().message.find(bad.says), std::string::npos)
            << bad.what << ": " << read.error().message;
    }
}

constexpr const char* kLens = R"(name = "single"
default_coating = "amber"
[[surface]]
radius_mm = 50.0
gap_mm = 3.0
nd = 1.5
semi_diameter_mm = 10.0
[[surface]]
gap_mm = 1.0
semi_diameter_mm = 10.0
coating = "absorber"
[[surface]]
kind = "stop"
gap_mm = 90.0
semi_diameter_mm = 5.0
[coatings.amber]
layers = [{ material = "MgF2", thickness_nm = 82.0 }]
[coatings.absorber]
notes = "smoke"
layers = [{ n = 1.38, k = 0.1, thickness_nm = 50.0 }, { material = "SiO2", thickness_nm = 9.0 }]
)";

TEST(LensFile, MayDefineItsOwnCoatings) {
    const Result<Prescription> read = ReadPrescriptionToml(kLens);
    ASSERT_TRUE(read.ok()) << read.error().message;
    ASSERT_EQ(read->coatings.size(), 2U);
    EXPECT_EQ(read->coatings.at("absorber").notes, "smoke");
    const auto lens = Lens::Build(*read);
    ASSERT_TRUE(lens.ok()) << lens.error().message;
    EXPECT_EQ((*lens)->surfaces()[0].coating.name, "amber");
    EXPECT_EQ((*lens)->surfaces()[0].coating.layers, read->coatings.at("amber").layers());
    EXPECT_EQ((*lens)->surfaces()[1].coating.layers.size(), 2U);
}

TEST(LensFile, RefusesABadCoatingAtItsPlace) {
    const auto refused = [](const char* from, const char* to) {
        std::string text = kLens;
        text.replace(text.find(from), std::string(from).size(), to);
        const Result<Prescription> read = ReadPrescriptionToml(text);
        EXPECT_FALSE(read.ok()) << to;
        return read.ok() ? Error{} : read.error();
    };
    const Error layer = refused("thickness_nm = 9.0", "thickness_nm = -9.0");
    EXPECT_EQ(layer.where, "line 20, column 55");
    EXPECT_NE(layer.message.find("layer 1 of coating \"absorber\""), std::string::npos);
    EXPECT_EQ(refused("[coatings.amber]", "[coatings.none]").where, "line 16, column 1");
    EXPECT_EQ(refused("notes = ", "note = ").where, "line 19, column 8");
    EXPECT_NE(refused("[coatings.amber]\nlayers = [{ material = \"MgF2\", thickness_nm = 82.0 }]\n",
                      "[coatings]\namber = 3\n")
                  .message.find("must be a table"),
              std::string::npos);
}

}  // namespace
}  // namespace flare
