// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/script_encoder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <thread>

#include "server/encoder/encoder_set.h"
#include "tests/support/temporary_folder.h"

namespace flare {
namespace {

TEST(ReadScript, ReadsValuesAndCounts) {
    const auto samples = ReadScript(
        "# a pull\n time_s, focus_m, t_stop, zoom\n0, inf, 2.8, 17\n\n0.5, 1.5, , -3\r\n");
    ASSERT_TRUE(samples) << samples.error().message;
    ASSERT_EQ(samples->size(), 2u);
    EXPECT_TRUE(std::isinf(*(*samples)[0].stated[LensAxis::kFocus]));
    EXPECT_EQ((*samples)[0].stated[LensAxis::kIris], 2.8);
    EXPECT_TRUE((*samples)[0].stated.iris_is_t_stop);
    EXPECT_EQ((*samples)[1].time_s, 0.5);
    EXPECT_EQ((*samples)[1].stated[LensAxis::kIris], std::nullopt);
    EXPECT_EQ((*samples)[1].raw[2], -3.0);
}

TEST(ReadScript, SaysWhichLineIsWrong) {
    const struct {
        const char* text;
        const char* where;
    } kBad[] = {
        {"", "line 0"},
        {"time_s,focus_m\n", "line 1"},
        {"focus_m\n1\n", "line 1"},
        {"time_s,time_s\n", "line 1"},
        {"time_s,f_number,t_stop\n", "line 1"},
        {"time_s,colour\n", "line 1"},
        {"time_s,focus_m\n0,1\n0,1\n", "line 3"},
        {"time_s,focus_m\n0\n", "line 2"},
        {"time_s,focus_m\n0,x\n", "line 2"},
        {"time_s,focus_m\n0,0\n", "line 2"},
        {"time_s,focus_m\n0,nan\n", "line 2"},
        {"time_s,t_stop\n0,inf\n", "line 2"},
        {"time_s,focus_m\n,1\n", "line 2"},
        {"time_s,focus_m\n-1,1\n", "line 2"},
    };
    for (const auto& row : kBad) {
        const auto samples = ReadScript(row.text);
        ASSERT_FALSE(samples.ok()) << row.text;
        EXPECT_EQ(samples.error().code, "bad_script");
        EXPECT_EQ(samples.error().where, row.where) << row.text << samples.error().message;
    }
}

class Script : public testing::Test {
  protected:
    Result<std::unique_ptr<EncoderSet>> Start(const std::string& text, bool loop = false) {
        EncoderConfig config;
        config.name = "demo";
        config.file = folder_ / "pull.csv";
        config.loop = loop;
        std::ofstream(config.file) << text;
        return EncoderSet::Start({config}, [](bool, const std::string&) {});
    }
    test::TemporaryFolder folder_;
};

TEST_F(Script, PlaysItsSamplesAtTheirTimes) {
    const auto set = Start("time_s,focus_m\n0,1\n0.02,2\n0.04,3\n");
    ASSERT_TRUE(set) << set.error().message;
    const EncoderTrack* track = (*set)->Find("demo");
    ASSERT_NE(track, nullptr);
    EXPECT_EQ((*set)->Find("other"), nullptr);
    while (track->samples() < 3) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const double end_s = track->Newest()->time_s;
    EXPECT_LE(end_s, EncoderClock::Now_s());
    EXPECT_EQ(track->Newest()->reading[LensAxis::kFocus], 3.0);
    EXPECT_NEAR(*track->At(end_s - 0.02)->reading[LensAxis::kFocus], 2.0, 1e-6);
    EXPECT_NEAR(1.0 / *track->At(end_s - 0.03)->reading[LensAxis::kFocus], 0.75, 1e-3);
}

TEST_F(Script, LoopsUntilItIsStopped) {
    const auto set = Start("time_s,focus_m\n0,1\n0.001,2\n", true);
    ASSERT_TRUE(set);
    while ((*set)->Find("demo")->samples() < 7) std::this_thread::yield();
}

TEST_F(Script, IsRefusedWithItsPlace) {
    const auto set = Start("time_s\n0,1\n");
    ASSERT_FALSE(set.ok());
    EXPECT_EQ(set.error().code, "bad_config");
    EXPECT_EQ(set.error().where, "encoder demo, file");
    EXPECT_NE(set.error().message.find("line 2"), std::string::npos);
}

}  // namespace
}  // namespace flare
