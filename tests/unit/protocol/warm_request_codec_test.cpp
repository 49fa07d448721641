// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/warm_request_codec.h"

#include <gtest/gtest.h>

#include "protocol/limits.h"

namespace flare::wire {
namespace {

WarmRequest Read(const std::string& body) {
    const Decoded<WarmRequest> decoded = DecodeWarmRequest(body);
    const Refusal* const refusal = RefusalOf(decoded);
    EXPECT_EQ(refusal, nullptr) << body << ": " << (refusal ? refusal->message : "");
    return refusal ? WarmRequest{} : std::get<WarmRequest>(decoded);
}

TEST(WarmRequestCodec, ReadsLights) {
    const WarmRequest request = Read(R"({"lens": "x", "zoom_mm": 85, "focus_m": 2,
        "quality": {"preset": "final"}, "model": {"sensor_reflection": true},
        "image": {"width": 100, "height": 50, "sensor_width_mm": 36},
        "lights": [{"direction": [0, 0, 1]}, {"pixel": [10, 20], "distance_m": 3}]})");
    EXPECT_EQ(request.lens.name, "x");
    EXPECT_EQ(request.lens.zoom_mm, 85.0);
    EXPECT_EQ(request.lens.focus_m, 2.0);
    EXPECT_EQ(request.quality.preset, Preset::kFinal);
    EXPECT_TRUE(request.model.sensor_reflection);
    ASSERT_EQ(request.lights.size(), 2U);
    EXPECT_EQ(request.lights[1].distance_m, 3.0);
    EXPECT_EQ(request.image->width, 100);
    EXPECT_FALSE(request.field);
}

TEST(WarmRequestCodec, CountsFieldAngles) {
    const struct {
        const char* field;
        int count;
    } kRows[] = {{"[0, 20, 5]", 5},          {"[0, 19.9, 5]", 4},  {"[-3, 3, 1]", 7},
                 {"[4, 4, 1]", 1},           {"[0, 0.3, 0.1]", 4}, {"[0, 1, 180]", 1},
                 {"[0, 4.095, 0.001]", 4096}};
    for (const auto& row : kRows) {
        const std::string body = R"({"lens": "x", "field_deg": )" + std::string(row.field) + "}";
        const WarmRequest request = Read(body);
        ASSERT_TRUE(request.field) << row.field;
        EXPECT_EQ(request.field->count, row.count) << row.field;
        EXPECT_TRUE(request.lights.empty());
    }
    EXPECT_EQ(Read(R"({"lens": "x", "field_deg": [0, 1, 1], "azimuth_deg": 30})").azimuth_deg, 30);
}

TEST(WarmRequestCodec, RefusesAndSaysWhere) {
    std::string crowd = R"({"lens": "x", "lights": [)";
    for (std::size_t i = 0; i <= limits::kWarmLights; ++i) {
        crowd += std::string(i == 0 ? "" : ",") + R"({"direction": [0, 0, 1]})";
    }
    crowd += "]}";
    const struct {
        std::string body;
        const char* code;
        const char* where;
    } kRows[] = {
        {"", "bad_json", "byte 1"},
        {"[]", "bad_type", ""},
        {R"({"field_deg": [0, 1, 1]})", "missing_field", "/lens"},
        {R"({"lens": "x"})", "missing_field", "/lights"},
        {R"({"lens": "x", "lights": []})", "bad_value", "/lights"},
        {R"({"lens": "x", "lights": [{"direction": [0, 0, 1]}], "field_deg": [0, 1, 1]})",
         "bad_value", "/lights"},
        {R"({"lens": "x", "lights": [{"direction": [0, 0, 0]}]})", "bad_value",
         "/lights/0/direction"},
        {R"({"lens": "x", "lights": [{"pixel": [1, 2]}]})", "missing_field", "/image"},
        {R"({"lens": "x", "lights": [{"direction": [0, 0, 1]}], "azimuth_deg": 3})", "bad_value",
         "/azimuth_deg"},
        {crowd, "limit", "/lights"},
        {R"({"lens": "x", "field_deg": [0, 1]})", "bad_value", "/field_deg"},
        {R"({"lens": "x", "field_deg": [1, 0, 1]})", "bad_value", "/field_deg"},
        {R"({"lens": "x", "field_deg": [0, 1, 0]})", "bad_value", "/field_deg"},
        {R"({"lens": "x", "field_deg": [0, 1, -1]})", "bad_value", "/field_deg"},
        {R"({"lens": "x", "field_deg": [0, 181, 1]})", "bad_value", "/field_deg/1"},
        {R"({"lens": "x", "field_deg": [0, 4.096, 0.001]})", "limit", "/field_deg"},
        {R"({"lens": "x", "field_deg": [0, 1, 1e-300]})", "limit", "/field_deg"},
        {R"({"lens": "x", "field_deg": [0, 1, 1], "output": {}})", "unknown_field", "/output"},
        {R"({"lens": "x", "field_deg": [0, 1, 1], "model": {"reflections": 4}})", "unsupported",
         "/model/reflections"},
    };
    for (const auto& row : kRows) {
        const Decoded<WarmRequest> decoded = DecodeWarmRequest(row.body);
        const Refusal* const refusal = RefusalOf(decoded);
        const std::string shown = row.body.substr(0, 100);
        ASSERT_NE(refusal, nullptr) << shown;
        EXPECT_EQ(refusal->code, row.code) << shown;
        EXPECT_EQ(refusal->where, row.where) << shown;
    }
}

}  // namespace
}  // namespace flare::wire
