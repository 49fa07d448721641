// SPDX-License-Identifier: Apache-2.0
//
// The service's one door: a body in, the bytes of a reply out.
#include "server/service.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/image/exr.h"
#include "protocol/codec/json_document.h"
#include "protocol/limits.h"

namespace flare {
namespace {

// Two singlets with a stop between them: few ghosts, quick to trace.
constexpr char kBody[] =
    R"({"prescription":{"name":"pair","surface":[
          {"kind":"sphere","radius_mm":60,"gap_mm":4,"nd":1.5168,"vd":64.2,"semi_diameter_mm":10},
          {"kind":"sphere","radius_mm":-200,"gap_mm":3,"semi_diameter_mm":10},
          {"kind":"stop","gap_mm":3,"semi_diameter_mm":5},
          {"kind":"sphere","radius_mm":200,"gap_mm":4,"nd":1.5168,"vd":64.2,"semi_diameter_mm":10},
          {"kind":"sphere","radius_mm":-60,"semi_diameter_mm":10}]},
        "f_number":1.0,"quality":{"preset":"draft"},
        "image":{"width":96,"height":54,"sensor_width_mm":36},
        "lights":[{"direction":[0.1,0.05,1],"irradiance":[1e3,1e3,1e3]}]})";

class Service : public testing::Test {
  protected:
    static const LensLibrary& Library() {
        static const LensLibrary library = *LensLibrary::Load(FLARE_SOURCE_DIR "/lenses");
        return library;
    }
    static Result<ServiceReply> Serve(const std::string& body, ReplyFormat format,
                                      const std::string& id = "", int thread_count = 1,
                                      const CancelToken& cancel = {}) {
        ThreadPool threads(thread_count);
        TracingMeshProvider meshes;
        double clock_ms = 0.0;
        return ServeFlare(body, format, id,
                          {Library(), threads, meshes, cancel, [&] { return clock_ms += 0.5; }});
    }
    static wire::JsonDocument Parsed(const std::string& json) {
        auto parsed = wire::JsonDocument::Parse(json);
        EXPECT_EQ(wire::RefusalOf(parsed), nullptr) << json;
        return std::get<wire::JsonDocument>(std::move(parsed));
    }
};

TEST_F(Service, GivesThePictureWithTheFactsOfTheRequestInItsHeader) {
    const auto reply = Serve(kBody, ReplyFormat::kExr);
    ASSERT_TRUE(reply) << reply.error().where << reply.error().message;
    EXPECT_EQ(reply->content_type, "image/x-exr");
    const auto image = DecodeExr(reply->bytes);
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_EQ(image->data.width, 96);
    EXPECT_EQ(image->data.height, 54);
    const auto text = [&](const std::string& name) {
        for (const auto& [key, value] : image->text_attributes) {
            if (key == name) return value;
        }
        return std::string();
    };
    EXPECT_EQ(text("lensModel"), "pair");
    EXPECT_EQ(text("flareRequestHash"), reply->request_hash);
    EXPECT_EQ(text("flareUnits"), "scene_linear");
    EXPECT_EQ(text("flareModels"), "geometric: 6");
    EXPECT_NE(text("flareClamped").find("/f_number"), std::string::npos) << text("flareClamped");
    for (const auto& [key, value] : image->number_attributes) {
        if (key == "aperture") {
            EXPECT_GT(value, 2.0);  // what the stop of 10 mm allows
        }
    }
    for (const char* channel : {"R", "G", "B", "ghosts.R", "ghosts.G", "ghosts.B"}) {
        EXPECT_TRUE(std::any_of(image->planes.begin(), image->planes.end(),
                                [&](const ImagePlane& plane) { return plane.name == channel; }))
            << channel;
    }
}

TEST_F(Service, GivesTheSameBytesOnAnyNumberOfThreadsAndWithAnyReportId) {
    const auto one = Serve(kBody, ReplyFormat::kExr, "", 1);
    const auto three = Serve(kBody, ReplyFormat::kExr, "an-id", 3);
    ASSERT_TRUE(one);
    ASSERT_TRUE(three);
    EXPECT_TRUE(one->bytes == three->bytes);
    EXPECT_EQ(one->request_hash, three->request_hash);
}

TEST_F(Service, GivesTheOtherFormsOfThePicture) {
    const auto png = Serve(kBody, ReplyFormat::kPng);
    ASSERT_TRUE(png);
    EXPECT_EQ(png->content_type, "image/png");
    EXPECT_EQ(png->bytes.substr(0, 8), "\x89PNG\r\n\x1a\n");
    const auto half = Serve(kBody, ReplyFormat::kHalfPlanes);
    ASSERT_TRUE(half);
    EXPECT_EQ(half->content_type, "application/x-flare-half");
    EXPECT_EQ(half->bytes.substr(0, 4), "FLRH");
}

TEST_F(Service, ReportsWhatItDid) {
    const auto reply = Serve(kBody, ReplyFormat::kExr, "r-17");
    ASSERT_TRUE(reply);
    const wire::JsonDocument report = Parsed(reply->report);
    const wire::JsonView root = report.root();
    EXPECT_EQ(root.Find("id")->string(), "r-17");
    EXPECT_EQ(root.Find("request_hash")->string(), reply->request_hash);
    EXPECT_EQ(root.Find("bytes")->number(), static_cast<double>(reply->bytes.size()));
    EXPECT_EQ(root.Find("clamped")->child_count(), 1u);
    EXPECT_EQ(root.Find("ghosts")->child_count(), 6u);
    EXPECT_EQ(root.Find("lights")->child_count(), 1u);
    EXPECT_EQ(root.Find("model")->Find("ringing")->string(), "off");
    EXPECT_GT(root.Find("work")->Find("rays_traced")->number(), 0.0);
    EXPECT_EQ(root.Find("work")->Find("rays_traced")->number(),
              static_cast<double>(reply->work.rays_traced));
}

TEST_F(Service, SumsUpInOneHeaderLine) {
    const auto reply = Serve(kBody, ReplyFormat::kExr, "r-17");
    ASSERT_TRUE(reply);
    EXPECT_LE(reply->report_summary.size(), limits::kReportSummaryBytes);
    EXPECT_TRUE(std::all_of(reply->report_summary.begin(), reply->report_summary.end(),
                            [](char c) { return c >= 0x20 && c < 0x7f; }));
    EXPECT_EQ(Parsed(reply->report_summary).root().Find("id")->string(), "r-17");
    EXPECT_FALSE(Parsed(Serve(kBody, ReplyFormat::kExr)->report_summary).root().Find("id"));
}

TEST_F(Service, CountsPixelsThatHalfFloatsCannotHold) {
    std::string blinding = kBody;
    blinding.replace(blinding.find("1e3,1e3,1e3"), 11, "1e9,1e9,1e9");
    for (const ReplyFormat format : {ReplyFormat::kExr, ReplyFormat::kHalfPlanes}) {
        const auto reply = Serve(blinding, format);
        ASSERT_TRUE(reply);
        EXPECT_GT(Parsed(reply->report).root().Find("saturated_pixels")->number(), 0.0);
        const auto modest = Serve(kBody, format);
        ASSERT_TRUE(modest);
        EXPECT_EQ(Parsed(modest->report).root().Find("saturated_pixels")->number(), 0.0);
    }
}

TEST_F(Service, RefusesWhatTheCodecRefuses) {
    const auto reply = Serve(R"({"lens":"x"})", ReplyFormat::kExr);
    ASSERT_FALSE(reply);
    EXPECT_EQ(reply.error().code, "missing_field");
    EXPECT_EQ(reply.error().where, "/image");
}

TEST_F(Service, StopsWhenNobodyWaits) {
    const CancelToken cancel;
    cancel.Cancel();
    const auto reply = Serve(kBody, ReplyFormat::kExr, "", 1, cancel);
    ASSERT_FALSE(reply);
    EXPECT_EQ(reply.error().code, "cancelled");
}

}  // namespace
}  // namespace flare
