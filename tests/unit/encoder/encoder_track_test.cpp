// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/encoder_track.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <thread>
#include <vector>

#include "protocol/limits.h"

namespace flare {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

EncoderConfig Config() {
    EncoderConfig config;
    config.name = "A-cam";
    config.stale_ms = 100.0;
    return config;
}

EncoderSample Sample(double time_s, double focus_m, double stop = 2.8, double raw = 7.0) {
    EncoderSample sample;
    sample.time_s = time_s;
    sample.raw = {raw, std::nullopt, std::nullopt};
    sample.stated.values = {focus_m, stop, std::nullopt};
    sample.stated.iris_is_t_stop = true;
    return sample;
}

class Track : public testing::Test {
  protected:
    std::vector<std::string> lines_;
    EncoderTrack track_{Config(), [this](bool warning, const std::string& text) {
                            lines_.push_back((warning ? "! " : "  ") + text);
                        }};
};

TEST_F(Track, HoldsTheNewestReading) {
    EXPECT_FALSE(track_.Newest());
    EXPECT_EQ(track_.At(1.0).error().code, "encoder_stale");
    track_.Add(Sample(1.0, 2.0));
    track_.Add(Sample(2.0, kInfinity));
    const auto newest = track_.Newest();
    ASSERT_TRUE(newest);
    EXPECT_EQ(newest->time_s, 2.0);
    EXPECT_EQ(newest->reading[LensAxis::kFocus], kInfinity);
    EXPECT_EQ(newest->reading[LensAxis::kIris], 2.8);
    EXPECT_EQ(newest->reading[LensAxis::kZoom], std::nullopt);
    EXPECT_TRUE(newest->reading.iris_is_t_stop);
    EXPECT_EQ(newest->raw[0], 7.0);
    EXPECT_EQ(newest->raw[1], std::nullopt);
}

TEST_F(Track, InterpolatesInTimeInTheEvenVariables) {
    track_.Add(Sample(10.0, 1.0, 2.0, 100.0));
    track_.Add(Sample(11.0, kInfinity, 8.0, 200.0));
    track_.Add(Sample(12.0, kInfinity, 8.0, 200.0));
    const auto half = track_.At(10.5);
    ASSERT_TRUE(half);
    EXPECT_NEAR(*half->reading[LensAxis::kFocus], 2.0, 1e-12);
    EXPECT_NEAR(*half->reading[LensAxis::kIris], 4.0, 1e-12);
    EXPECT_EQ(half->raw[0], 150.0);
    EXPECT_EQ(half->time_s, 10.0);  // the age counts from the older of the two
    EXPECT_EQ(track_.At(10.0)->reading[LensAxis::kFocus], 1.0);
    EXPECT_EQ(track_.At(11.5)->reading[LensAxis::kFocus], kInfinity);
    EXPECT_EQ(track_.At(99.0)->time_s, 12.0);
    EXPECT_EQ(track_.At(9.99).error().code, "encoder_time");
}

TEST_F(Track, ForgetsWhatIsOlderThanItsHistory) {
    const auto count = static_cast<int>(limits::kEncoderHistory) + 10;
    for (int i = 0; i < count; ++i) track_.Add(Sample(i, 1.0 + i));
    EXPECT_EQ(track_.At(9.0).error().code, "encoder_time");
    ASSERT_TRUE(track_.At(10.0));
    EXPECT_EQ(track_.At(10.0)->reading[LensAxis::kFocus], 11.0);
    EXPECT_EQ(track_.Newest()->reading[LensAxis::kFocus], count);
}

TEST_F(Track, NeverGoesBackInTime) {
    track_.Add(Sample(5.0, 1.0));
    track_.Add(Sample(4.0, 2.0));
    EXPECT_EQ(track_.Newest()->time_s, 5.0);
    EXPECT_EQ(track_.Newest()->reading[LensAxis::kFocus], 2.0);
}

TEST_F(Track, KnowsItsHealth) {
    const double now_s = EncoderClock::Now_s();
    EXPECT_EQ(track_.Status(now_s).health, EncoderHealth::kWaiting);
    track_.Disconnected(EncoderFault::kDenied, "no permission");
    EXPECT_EQ(track_.Status(now_s).health, EncoderHealth::kFailed);
    EXPECT_EQ(track_.Status(now_s).problem, "no permission");
    track_.Connected("a device", "its lens");
    track_.Add(Sample(now_s, 1.0));
    EncoderStatus status = track_.Status(now_s + 0.05);
    EXPECT_EQ(status.health, EncoderHealth::kLive);
    EXPECT_EQ(status.rate_hz, 1.0);
    EXPECT_EQ(status.problem, "");
    EXPECT_EQ(status.lens, "its lens");
    status = track_.Status(now_s + 2.0);
    EXPECT_EQ(status.health, EncoderHealth::kStale);
    EXPECT_EQ(status.rate_hz, 0.0);
    track_.Disconnected(EncoderFault::kUnplugged, "gone");
    EXPECT_EQ(track_.Status(now_s).health, EncoderHealth::kLost);
    EXPECT_EQ(track_.Newest()->reading[LensAxis::kFocus], 1.0) << "the last state is held";
}

TEST_F(Track, CountsEveryFaultAndLogsEachChangeOnce) {
    track_.Connected("a device");
    for (int i = 0; i < 5; ++i) track_.Fault(EncoderFault::kBadData, "noise");
    track_.Fault(EncoderFault::kLostData, "3 lost", 3);
    track_.Fault(EncoderFault::kBadData, "noise");
    const EncoderFaultCounts faults = track_.Status(0.0).faults;
    EXPECT_EQ(faults[static_cast<std::size_t>(EncoderFault::kBadData)], 6u);
    EXPECT_EQ(faults[static_cast<std::size_t>(EncoderFault::kLostData)], 3u);
    const std::vector<std::string> expected{"  encoder A-cam: connected to a device",
                                            "! encoder A-cam: noise", "! encoder A-cam: 3 lost",
                                            "! encoder A-cam: noise"};
    EXPECT_EQ(lines_, expected);
}

// A reading is made of parts that belong together, however fast they are overwritten.
TEST_F(Track, ReadersNeverSeeHalfAReading) {
    std::atomic<bool> done = false;
    std::vector<std::thread> readers;
    std::atomic<int> torn = 0, read = 0;
    for (int i = 0; i < 2; ++i) {
        readers.emplace_back([&] {
            while (!done) {
                const auto newest = track_.Newest();
                if (!newest) continue;
                ++read;
                const double t = newest->time_s;
                if (newest->reading[LensAxis::kFocus] != t || newest->raw[0] != t) ++torn;
                const auto past = track_.At(t - 0.5);
                if (past && std::abs(*past->reading[LensAxis::kFocus] - (t - 0.5)) > 0.6) ++torn;
            }
        });
    }
    for (int i = 1; i < 100'000; ++i) track_.Add(Sample(i, i, 2.8, i));
    done = true;
    for (std::thread& reader : readers) reader.join();
    EXPECT_EQ(torn, 0);
    EXPECT_EQ(track_.Newest()->time_s, 99'999.0);
}

}  // namespace
}  // namespace flare
