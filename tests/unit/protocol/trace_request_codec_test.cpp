// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/trace_request_codec.h"

#include <gtest/gtest.h>

#include <string>

namespace flare::wire {
namespace {

TEST(TraceRequestCodec, ReadsEveryField) {
    const auto decoded = DecodeTraceRequest(
        R"({"lens":"x","wavelength_nm":486.1327,"sequence":[9,1],"precision":"double",
            "clip":false,"coatings":{"surfaces":{"2":"mgf2-550"}},"f_number":5.6,"focus_m":0.5,
            "zoom_mm":80,
            "rays":[{"origin":[1,2,-3],"direction":[0,0.5,1]}]})");
    ASSERT_EQ(RefusalOf(decoded), nullptr);
    const TraceRequest& request = std::get<TraceRequest>(decoded);
    EXPECT_EQ(request.lens.name, "x");
    EXPECT_EQ(request.wavelength_nm, 486.1327);
    EXPECT_EQ(request.sequence, (std::vector<int>{9, 1}));
    EXPECT_FALSE(request.clip);
    EXPECT_EQ(request.lens.coatings.surfaces.at(2), "mgf2-550");
    EXPECT_EQ(request.lens.f_number, 5.6);
    EXPECT_EQ(request.lens.focus_m, 0.5);
    EXPECT_EQ(request.lens.zoom_mm, 80.0);
    ASSERT_EQ(request.rays.size(), 1u);
    EXPECT_EQ(request.rays[0].origin, (std::array<double, 3>{1, 2, -3}));
    EXPECT_EQ(request.rays[0].direction, (std::array<double, 3>{0, 0.5, 1}));
}

TEST(TraceRequestCodec, DefaultsToTheDirectPathAtTheDesignWavelength) {
    const auto decoded = DecodeTraceRequest(R"({"lens":"x","rays":[]})");
    ASSERT_EQ(RefusalOf(decoded), nullptr);
    const TraceRequest& request = std::get<TraceRequest>(decoded);
    EXPECT_EQ(request.wavelength_nm, 587.5618);
    EXPECT_TRUE(request.sequence.empty());
    EXPECT_TRUE(request.clip);
    EXPECT_FALSE(request.lens.f_number.has_value());
    EXPECT_FALSE(request.lens.focus_m.has_value());
}

TEST(TraceRequestCodec, RefusesBadInputWithCodeAndPlace) {
    const struct {
        const char* body;
        const char* code;
        const char* where;
    } table[] = {
        {R"({"rays":[]})", "missing_field", "/lens"},
        {R"({"lens":"x"})", "missing_field", "/rays"},
        {R"({"lens":"x","rays":[],"ray":[]})", "unknown_field", "/ray"},
        {R"({"lens":"x","rays":[{"origin":[0,0,0]}]})", "missing_field", "/rays/0/direction"},
        {R"({"lens":"x","rays":[{"origin":[0,0],"direction":[0,0,1]}]})", "bad_value",
         "/rays/0/origin"},
        {R"({"lens":"x","rays":[{"origin":[0,0,0],"direction":[0,0,0]}]})", "bad_value",
         "/rays/0/direction"},
        {R"({"lens":"x","rays":[],"precision":"float"})", "unsupported", "/precision"},
        {R"({"lens":"x","rays":[],"precision":"half"})", "bad_value", "/precision"},
        {R"({"lens":"x","rays":[],"sequence":[1.5,0]})", "bad_type", "/sequence/0"},
        {R"({"lens":"x","rays":[],"sequence":[-1,0]})", "bad_value", "/sequence/0"},
        {R"({"lens":"x","rays":[],"sequence":[9,8,7,6,5,4,3,2,1]})", "limit", "/sequence"},
        {R"({"lens":"x","rays":[],"wavelength_nm":0})", "bad_value", "/wavelength_nm"},
        {R"({"lens":"x","rays":[],"clip":1})", "bad_type", "/clip"},
        {R"({"lens":"x","rays":[],"focus_m":-1})", "bad_value", "/focus_m"},
        {R"({"lens":"x","rays":[],"zoom_mm":"80"})", "bad_type", "/zoom_mm"},
        {R"({"lens":"x","rays":[],"coatings":{"surfaces":{"x":"bare"}}})", "bad_value",
         "/coatings/surfaces/x"},
        {R"({"lens":"x","rays":[]}})", "bad_json", "byte 23"},
    };
    for (const auto& row : table) {
        const auto decoded = DecodeTraceRequest(row.body);
        const Refusal* refusal = RefusalOf(decoded);
        ASSERT_NE(refusal, nullptr) << row.body;
        EXPECT_EQ(refusal->code, row.code) << row.body;
        EXPECT_EQ(refusal->where, row.where) << row.body;
    }
}

}  // namespace
}  // namespace flare::wire
