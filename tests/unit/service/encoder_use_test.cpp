// SPDX-License-Identifier: Apache-2.0
//
// A request that names an encoder is the request with its numbers written out.
#include "server/translate/encoder_use.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <thread>

#include "core/image/exr.h"
#include "core/optics/glass.h"
#include "core/optics/paraxial.h"
#include "server/service.h"
#include "tests/support/temporary_folder.h"

namespace flare {
namespace {

constexpr char kLens[] = "kodak-petzval-100mm-f2_2";

class EncoderInRequest : public testing::Test {
  protected:
    EncoderInRequest() {
        // Two states 50 ms apart; the second is held.
        Write("focus_m,t_stop", "1.5,4", "2.5,2.8");
    }
    void Write(const std::string& columns, const std::string& first, const std::string& second,
               const std::string& lens = "") {
        encoders_.reset();
        EncoderConfig config;
        config.name = "A-cam";
        config.file = folder_ / "pull.csv";
        config.lens = lens;
        std::ofstream(config.file)
            << "time_s," << columns << "\n0," << first << "\n0.05," << second << "\n";
        auto set = EncoderSet::Start({config}, [](bool, const std::string&) {});
        ASSERT_TRUE(set) << set.error().message;
        encoders_ = std::move(*set);
        while (encoders_->Find("A-cam")->samples() < 2) std::this_thread::yield();
    }
    std::string Body(const std::string& more, bool with_lens = true) const {
        return std::string("{") + (with_lens ? "\"lens\":\"" + std::string(kLens) + "\"," : "") +
               R"("quality":{"preset":"draft"},"output":{"pixel":"float"},
                  "image":{"width":32,"height":18,"sensor_width_mm":36},
                  "lights":)" +
               (lit_ ? R"([{"direction":[0.1,0.05,1]}])" : "[]") + more + "}";
    }
    Result<ServiceReply> Serve(const std::string& body) {
        static const LensLibrary library = *LensLibrary::Load(FLARE_SOURCE_DIR "/lenses");
        ThreadPool threads(1);
        return ServeFlare(body, ReplyFormat::kExr, "",
                          {library, threads, meshes_, CancelToken(), [] { return 0.0; }, nullptr,
                           encoders_.get()});
    }
    static FlareImage Picture(const Result<ServiceReply>& reply) {
        EXPECT_TRUE(reply) << reply.error().where << reply.error().message;
        return *DecodeExr(reply->bytes);
    }

    test::TemporaryFolder folder_;
    TracingMeshProvider meshes_;
    std::unique_ptr<EncoderSet> encoders_;
    bool lit_ = true;  // without a light no ray is traced
};

template <class Attributes>
Attributes WithoutEncoder(Attributes attributes) {
    std::erase_if(attributes, [](const auto& a) { return a.first.starts_with("encoder"); });
    return attributes;
}

TEST_F(EncoderInRequest, GivesThePictureOfTheNumbersWrittenOut) {
    const FlareImage live = Picture(Serve(Body(R"(,"encoder":"A-cam")")));
    // N = T sqrt(t_axis), with the picture's own t_axis.
    double t_axis = 0.0, f_number = 0.0;
    for (const auto& [name, value] : live.number_attributes) {
        if (name == "flareAxialTransmittance") t_axis = value;
        if (name == "aperture") f_number = value;
    }
    EXPECT_NEAR(f_number, 2.8 * std::sqrt(t_axis), 1e-5);
    const auto lens = LoadLensFile(std::string(FLARE_SOURCE_DIR "/lenses/") + kLens + ".toml");
    ASSERT_TRUE(lens);
    char written[80];
    std::snprintf(written, sizeof written, ",\"focus_m\":2.5,\"f_number\":%.17g",
                  2.8 * std::sqrt(AxialTransmittance(**lens, kLineD)));
    const FlareImage numbers = Picture(Serve(Body(written)));
    ASSERT_EQ(live.planes.size(), numbers.planes.size());
    for (std::size_t i = 0; i < live.planes.size(); ++i) {
        EXPECT_EQ(live.planes[i].values, numbers.planes[i].values);
    }
    EXPECT_EQ(WithoutEncoder(live.text_attributes), numbers.text_attributes);
    EXPECT_EQ(WithoutEncoder(live.number_attributes), numbers.number_attributes);
    EXPECT_EQ(live.text_attributes.size(), numbers.text_attributes.size() + 4);
    // The header says it to the last digit.
    const auto state = std::find_if(live.text_attributes.begin(), live.text_attributes.end(),
                                    [](const auto& a) { return a.first == "encoderState"; });
    ASSERT_NE(state, live.text_attributes.end());
    const std::string members = state->second.substr(1, state->second.size() - 2);
    const FlareImage stated = Picture(Serve(Body("," + members)));
    EXPECT_EQ(live.planes[0].values, stated.planes[0].values) << members;
    const FlareImage other = Picture(Serve(Body(R"(,"focus_m":1.5,"f_number":4)")));
    EXPECT_NE(live.planes[0].values, other.planes[0].values);
}

TEST_F(EncoderInRequest, TakesThePastAndTheLensFromTheEncoder) {
    Write("focus_m,f_number", "1.5,4", "inf,4", kLens);
    const double newest_s = encoders_->Find("A-cam")->Newest()->time_s;
    const auto at = [&](double time_s) {
        char more[120];
        std::snprintf(more, sizeof more, ",\"encoder\":\"A-cam\",\"encoder_time\":%.9f", time_s);
        return Serve(Body(more, false));
    };
    lit_ = false;
    const auto past = at(newest_s - 0.025);
    ASSERT_TRUE(past) << past.error().message;
    const auto focus_at = past->report.find("\"state\": {\"focus_m\": ");
    ASSERT_NE(focus_at, std::string::npos) << past->report;
    EXPECT_NEAR(std::stod(past->report.substr(focus_at + 21)), 3.0, 1e-3);  // halfway in 1/m
    lit_ = true;
    const FlareImage now = Picture(Serve(Body(R"(,"encoder":"A-cam")", false)));
    const FlareImage written = Picture(Serve(Body(R"(,"focus_m":null,"f_number":4)")));
    EXPECT_EQ(now.planes[0].values, written.planes[0].values);
    EXPECT_EQ(at(newest_s - 10.0).error().code, "encoder_time");
    EXPECT_EQ(at(newest_s - 10.0).error().where, "/encoder_time");
}

TEST_F(EncoderInRequest, RefusesWhatCannotBeMeant) {
    lit_ = false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const struct {
        std::string body;
        const char* code;
        const char* where;
    } kRows[] = {
        {Body(R"(,"encoder":"B-cam")"), "unknown_encoder", "/encoder"},
        {Body(R"(,"encoder":"A-cam","focus_m":2)"), "bad_value", "/focus_m"},
        {Body(R"(,"encoder":"A-cam","f_number":2)"), "bad_value", "/f_number"},
        {Body(R"(,"encoder":"A-cam","encoder_max_age_ms":1)"), "encoder_stale",
         "/encoder_max_age_ms"},
        {Body(R"(,"encoder":"A-cam")", false), "missing_field", "/lens"},
    };
    for (const auto& row : kRows) {
        const auto reply = Serve(row.body);
        ASSERT_FALSE(reply.ok()) << row.body;
        EXPECT_EQ(reply.error().code, row.code) << row.body;
        EXPECT_EQ(reply.error().where, row.where) << row.body;
    }
    EXPECT_TRUE(Serve(Body(R"(,"encoder":"A-cam","encoder_max_age_ms":60000)")));
    EXPECT_TRUE(Serve(Body(R"(,"encoder":"A-cam","zoom_mm":50)"))) << "it measures no zoom";
    Write("focus", "100", "200");  // counts without a table
    const auto counts = Serve(Body(R"(,"encoder":"A-cam")"));
    ASSERT_FALSE(counts.ok());
    EXPECT_EQ(counts.error().where, "/encoder");
    EXPECT_NE(counts.error().message.find("no table"), std::string::npos);
}

}  // namespace
}  // namespace flare
