// SPDX-License-Identifier: Apache-2.0
#include "protocol/openapi.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "protocol/codec/flare_request_codec.h"

namespace flare {
namespace {

TEST(OpenApiDocument, IsTheFileOfTheSourceTreeToTheLastByte) {
    std::ifstream file(FLARE_SOURCE_DIR "/protocol/openapi.yaml", std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)),
                           std::istreambuf_iterator<char>());
    ASSERT_GT(text.size(), 10'000u);
    EXPECT_TRUE(OpenApiDocument() == text);
}

// Each member with a value that suits it; the codec knows it and the document describes it.
TEST(OpenApiDocument, DescribesTheFieldsThatTheCodecKnows) {
    const struct {
        const char* parent;
        const char* member;
        const char* value;
    } kFields[] = {
        {"", "coatings", R"("none")"},
        {"", "f_number", "4"},
        {"", "focus_m", "2"},
        {"", "zoom_mm", "85"},
        {"", "iris", R"({"blades":6})"},
        {"", "layers", R"(["ghosts"])"},
        {"", "starburst", R"({"core":false})"},
        {"starburst", "core", "true"},
        {"starburst", "jitter_deg", "2"},
        {"starburst", "jitter_count", "4"},
        {"starburst", "seed", "7"},
        {"", "split", R"("ghost")"},
        {"", "artist", R"({"ghosts":[{"sequence":[9,1]}]})"},
        {"artist", "ghosts", R"([{"sequence":[9,1],"gain":2,"tint":[1,1,0],"mute":false}])"},
        {"", "units", R"("scene_linear")"},
        {"", "color_space", R"("lin_rec709")"},
        {"", "camera", R"({"wavelengths_nm":[550],"red":[1],"green":[2],"blue":[3]})"},
        {"", "quality", R"({"preset":"draft"})"},
        {"quality", "preset", R"("draft")"},
        {"quality", "tolerance", "0.01"},
        {"quality", "max_error", "0.02"},
        {"quality", "time_budget_ms", "40"},
        {"", "quality", R"({"preset":"reference","method":"photon","samples":64,"seed":1,
                            "estimate":"kernel","kernel_px":2.5,"nearest":8})"},
        {"", "model", "{}"},
        {"", "output", "{}"},
        {"", "encoder", R"("A-cam")"},
        {"coatings", "default", R"("bare")"},
        {"coatings", "surfaces", R"({"3":"bare"})"},
        {"model", "reflections", "4"},
        {"model", "four_reflection_threshold", "0.5"},
        {"model", "ringing", R"("auto")"},
        {"model", "culling", R"("none")"},
        {"model", "sensor_reflection", "true"},
        {"output", "compression", R"("zip")"},
        {"output", "pixel", R"("half")"},
    };
    const std::string_view document = OpenApiDocument();
    for (const auto& field : kFields) {
        const std::string member = std::string("\"") + field.member + "\":" + field.value;
        const std::string nested = *field.parent == '\0'
                                       ? member
                                       : std::string("\"") + field.parent + "\":{" + member + "}";
        const auto decoded = wire::DecodeFlareRequest(
            R"({"lens":"x","image":{"width":1,"height":1,"sensor_width_mm":36},"lights":[],)" +
            nested + "}");
        const wire::Refusal* refusal = wire::RefusalOf(decoded);
        EXPECT_EQ(refusal, nullptr) << nested << refusal->message;
        EXPECT_NE(document.find(std::string(" ") + field.member + ":"), std::string_view::npos)
            << field.member;
    }
    for (const char* member : {" desqueeze:", " temperature_k:", " spectrum:", " method:",
                               " samples:", " estimate:", " kernel_px:", " nearest:"}) {
        EXPECT_NE(document.find(member), std::string_view::npos) << member;
    }
}

}  // namespace
}  // namespace flare
