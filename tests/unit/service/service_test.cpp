// SPDX-License-Identifier: Apache-2.0
//
// The service's one door: a body in, the bytes of a reply out.
#include "server/service.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

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
    EXPECT_EQ(text("flareModels"), "edge_profile: 5; geometric: 1");
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
    EXPECT_EQ(root.Find("model")->Find("ringing")->string(), "auto");
    EXPECT_EQ(root.Find("model")->Find("culling")->string(), "auto");
    const wire::JsonView error = *root.Find("estimated_error");
    double parts = 0.0;
    for (const char* part : {"culling", "dispersion", "colour", "mesh", "pieces", "source"}) {
        parts += error.Find(part)->number();
    }
    EXPECT_GT(parts, 0.0);
    EXPECT_NEAR(error.Find("rel_l1")->number(), parts, 1e-5 * parts);
    EXPECT_GT(root.Find("work")->Find("rays_traced")->number(), 0.0);
    EXPECT_EQ(root.Find("work")->Find("rays_traced")->number(),
              static_cast<double>(reply->work.rays_traced));
}

double NumberAttribute(const FlareImage& image, const std::string& name) {
    for (const auto& [key, value] : image.number_attributes) {
        if (key == name) return value;
    }
    return std::numeric_limits<double>::quiet_NaN();
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

TEST_F(Service, TellsTheStateOfTheLens) {
    const auto far = Serve(kBody, ReplyFormat::kExr);
    const auto near =
        Serve(Replaced(kBody, "\"f_number\"", R"("focus_m":0.5,"zoom_mm":7,"f_number")"),
              ReplyFormat::kExr);
    ASSERT_TRUE(far);
    ASSERT_TRUE(near) << near.error().message;
    EXPECT_TRUE(std::isnan(NumberAttribute(*DecodeExr(far->bytes), "focus")));
    EXPECT_EQ(NumberAttribute(*DecodeExr(near->bytes), "focus"), 0.5);
    const wire::JsonDocument told = Parsed(near->report);
    EXPECT_EQ(told.root().Find("state")->Find("focus_m")->number(), 0.5);
    EXPECT_EQ(told.root().Find("state")->Find("zoom_mm")->kind(), wire::JsonKind::kNull);
    EXPECT_NE(near->report.find("\"/zoom_mm: 7.0"), std::string::npos) << near->report;
    const wire::JsonDocument summary = Parsed(near->report_summary);
    EXPECT_EQ(summary.root().Find("state")->Find("focus_m")->number(), 0.5);
}

constexpr char kFourReflections[] =
    R"("model":{"reflections":4,"four_reflection_threshold":1e-6},)";

TEST_F(Service, CountsWhatFourReflectionsHoldAndLose) {
    const auto reply =
        Serve(Replaced(kBody, "\"quality\"", std::string(kFourReflections) + "\"quality\""),
              ReplyFormat::kExr);
    ASSERT_TRUE(reply) << reply.error().message;
    const wire::JsonDocument report = Parsed(reply->report);
    const wire::JsonView root = report.root();
    EXPECT_EQ(root.Find("model")->Find("reflections")->number(), 4.0);
    const wire::JsonView four = *root.Find("four_reflections");
    EXPECT_EQ(four.Find("threshold")->number(), 1e-6);
    // r1 > r2 < r3 > r4 among four surfaces.
    const double sequences = four.Find("sequences")->number();
    const double rendered = four.Find("rendered")->number();
    int expected = 0;
    for (int r1 = 0; r1 < 4; ++r1)
        for (int r2 = 0; r2 < r1; ++r2)
            for (int r3 = r2 + 1; r3 < 4; ++r3) expected += r3;
    EXPECT_EQ(sequences, expected);
    EXPECT_GT(rendered, 0.0);
    EXPECT_LE(rendered, sequences);
    EXPECT_EQ(root.Find("ghost_count")->number(), 6.0 + rendered);
    double of_four = 0.0;
    std::size_t rows = 0;
    const wire::JsonView ghosts = *root.Find("ghosts");
    for (auto ghost = ghosts.FirstChild(); ghost; ghost = ghost->NextSibling()) {
        const std::size_t reflections = ghost->Find("sequence")->child_count();
        if (rows++ < 6) {
            EXPECT_EQ(reflections, 2u);
        } else {
            EXPECT_EQ(reflections, 4u);
            of_four += ghost->Find("flux_mm2")->number();
        }
    }
    // The choice goes by coarse meshes, the list by those that were drawn.
    const double chosen = four.Find("rendered_flux_mm2")->number();
    EXPECT_NEAR(of_four, chosen, 0.1 * chosen);
    EXPECT_DOUBLE_EQ(root.Find("culled_flux_mm2")->number(),
                     four.Find("lost_flux_mm2")->number() +
                         root.Find("culling")->Find("lost_flux_mm2")->number());
}

// Between a plane and a cylinder on either side, an afocal attachment of 0.5 in x: f in x is half
// of f in y exactly, since the inner vertices stand 2 R2 - 2 R1 apart (n = 1.5).
constexpr char kAnamorphicBody[] =
    R"({"prescription":{"name":"anamorphic","surface":[
          {"kind":"plane","gap_mm":3,"nd":1.5,"semi_diameter_mm":25},
          {"kind":"cylinder_x","radius_mm":50,"gap_mm":100,"semi_diameter_mm":25},
          {"kind":"cylinder_x","radius_mm":100,"gap_mm":6,"nd":1.5,"semi_diameter_mm":25},
          {"kind":"plane","gap_mm":5,"semi_diameter_mm":25},
          {"kind":"stop","gap_mm":1,"semi_diameter_mm":6},
          {"kind":"sphere","radius_mm":50,"gap_mm":4,"nd":1.5168,"vd":64.2,"semi_diameter_mm":12},
          {"kind":"sphere","radius_mm":-200,"semi_diameter_mm":12}]},
        "quality":{"preset":"draft"},
        "image":{"width":48,"height":40,"sensor_width_mm":36},
        "lights":[{"direction":[0.1,0.05,1]}]})";

TEST_F(Service, SqueezesOrDesqueezesThePictureOfAnAnamorphicLens) {
    const auto squeezed = Serve(kAnamorphicBody, ReplyFormat::kExr);
    ASSERT_TRUE(squeezed) << squeezed.error().where << squeezed.error().message;
    const auto desqueezed = Serve(
        Replaced(kAnamorphicBody, "\"width\"", "\"desqueeze\":true,\"width\""), ReplyFormat::kExr);
    ASSERT_TRUE(desqueezed);
    const FlareImage one = *DecodeExr(squeezed->bytes);
    const FlareImage other = *DecodeExr(desqueezed->bytes);
    EXPECT_NEAR(one.pixel_aspect, 2.0, 1e-6);
    EXPECT_NEAR(other.pixel_aspect, 1.0, 1e-6);
    EXPECT_NEAR(NumberAttribute(one, "flareSqueeze"), 2.0, 1e-6);
    EXPECT_EQ(NumberAttribute(one, "flareDesqueezed"), 0.0);
    EXPECT_EQ(NumberAttribute(other, "flareDesqueezed"), 1.0);
    const wire::JsonDocument first = Parsed(squeezed->report), second = Parsed(desqueezed->report);
    EXPECT_NEAR(first.root().Find("squeeze")->number(), 2.0, 1e-9);
    EXPECT_TRUE(second.root().Find("desqueezed")->boolean());
    // The light's place: as far right, half as far from the middle row.
    const auto place = [](const wire::JsonDocument& report) {
        const wire::JsonView pixel =
            *report.root().Find("lights")->FirstChild()->Find("pixel")->FirstChild();
        return std::pair(pixel.number() - 24.0, 20.0 - pixel.NextSibling()->number());
    };
    EXPECT_NEAR(place(second).first, place(first).first, 1e-9);
    EXPECT_NEAR(place(second).second, 0.5 * place(first).second, 1e-9);
    EXPECT_GT(place(first).second, 1.0);
}

// A lens that bends light in one section alone has no squeeze, and an afocal one neither.
TEST_F(Service, RendersLensesWithoutAFocalLength) {
    for (const char* kind : {"cylinder_x", "plane"}) {
        const std::string radius = std::string(kind) == "plane" ? "" : R"("radius_mm":60,)";
        const auto reply =
            Serve(R"({"prescription":{"name":"p","surface":[{"kind":")" + std::string(kind) +
                      "\"," + radius + R"("gap_mm":4,"nd":1.5,"semi_diameter_mm":10},
                {"kind":"plane","gap_mm":1,"semi_diameter_mm":10},
                {"kind":"stop","gap_mm":50,"semi_diameter_mm":5}]},
                "units":"sensor_irradiance","quality":{"preset":"draft"},"f_number":8,
                "image":{"width":16,"height":9,"sensor_width_mm":36},
                "lights":[{"direction":[0,0,1]}]})",
                  ReplyFormat::kExr);
        ASSERT_TRUE(reply) << kind << reply.error().message;
        EXPECT_EQ(DecodeExr(reply->bytes)->pixel_aspect, 1.0) << kind;
    }
}

TEST_F(Service, RefusesASensorReflectionThatTheLensHasNot) {
    const auto reply =
        Serve(Replaced(kBody, "\"quality\"", R"("model":{"sensor_reflection":true},"quality")"),
              ReplyFormat::kExr);
    ASSERT_FALSE(reply);
    EXPECT_EQ(reply.error().where, "/model/sensor_reflection");
}

// Layers for single ghosts, and the mark that a picture bears once an artist has changed it.
TEST_F(Service, MarksWhatAnArtistHasChanged) {
    std::string body(kBody);
    body.insert(body.rfind('}'), R"(,"layers":["ghosts","bokeh"],"split":"ghost",
        "artist":{"ghosts":[{"sequence":[1,0],"gain":2.5,"tint":[1,0.5,0.25]},
                            {"sequence":[4,3],"mute":true}]})");
    const auto reply = Serve(body, ReplyFormat::kExr);
    ASSERT_TRUE(reply) << reply.error().where << reply.error().message;
    const auto image = DecodeExr(reply->bytes);
    ASSERT_TRUE(image) << image.error().message;
    const auto has = [&](const std::string& name) {
        return std::any_of(image->planes.begin(), image->planes.end(),
                           [&](const ImagePlane& plane) { return plane.name == name; });
    };
    EXPECT_TRUE(has("bokeh.R") && has("ghosts.R") && has("ghosts.1_0.R"));
    EXPECT_FALSE(has("ghosts.4_3.R"));
    const std::pair<std::string, std::string> mark{"flareArtist",
                                                   "1_0: gain 2.5, tint 1 0.5 0.25; 4_3: mute"};
    EXPECT_EQ(std::count(image->text_attributes.begin(), image->text_attributes.end(), mark), 1);
    const wire::JsonDocument report = Parsed(reply->report);
    EXPECT_EQ(report.root().Find("artist")->child_count(), 2U);
    EXPECT_EQ(report.root().Find("artist_ghosts")->number(), 2.0);
    EXPECT_GT(report.root().Find("bokeh")->Find("flux_mm2")->number(), 0.0);
    EXPECT_TRUE(Parsed(reply->report_summary).root().Find("artist_ghosts"));

    const auto plain = Serve(kBody, ReplyFormat::kExr);
    const auto untouched = DecodeExr(plain->bytes);
    EXPECT_TRUE(
        std::none_of(untouched->text_attributes.begin(), untouched->text_attributes.end(),
                     [](const auto& attribute) { return attribute.first == "flareArtist"; }));
    EXPECT_FALSE(Parsed(plain->report).root().Find("artist"));
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
