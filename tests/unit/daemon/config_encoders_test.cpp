// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "server/config.h"

namespace flare {
namespace {

TEST(ConfigEncoders, ReadsEachKind) {
    const auto config = ReadConfig(R"(
workers = 2

[[encoder]]
name = "demo"
kind = "script"
file = "pull.csv"
loop = true
lens = "tronnier-double-gauss-50mm-f2"
stale_ms = 250

[[encoder]]
name = "A-cam"
kind = "freed"
port = 40001
camera_id = 3
address = "127.0.0.1"
[encoder.focus]
raw = [0, 5000, 10000]
value = [0.5, 1, inf]
zero = 100
reverse = true
wrap = 65536
smooth_ms = 20
[encoder.iris]
raw = [0, 100]
value = [2, 8]
scale = "f_number"

[[encoder]]
name = "B-cam"
kind = "opentrackio"
multicast = "235.135.1.1"
zoom.smooth_ms = 5
)",
                                   {});
    ASSERT_TRUE(config.ok()) << config.error().where << config.error().message;
    ASSERT_EQ(config->encoders.size(), 3u);
    const EncoderConfig& script = config->encoders[0];
    EXPECT_EQ(script.name, "demo");
    EXPECT_EQ(script.kind, EncoderKind::kScript);
    EXPECT_EQ(script.file, "pull.csv");
    EXPECT_TRUE(script.loop);
    EXPECT_EQ(script.lens, "tronnier-double-gauss-50mm-f2");
    EXPECT_EQ(script.stale_ms, 250.0);
    const EncoderConfig& freed = config->encoders[1];
    EXPECT_EQ(freed.port, 40001);
    EXPECT_EQ(freed.source, 3);
    EXPECT_EQ(freed.address, "127.0.0.1");
    const AxisCalibration& focus = freed.calibration.axes[0];
    ASSERT_TRUE(focus.table);
    EXPECT_EQ(focus.table->Value(100 - 5000), 1.0);
    EXPECT_TRUE(std::isinf(focus.table->Value(100 - 10000 + 65536)));
    EXPECT_EQ(focus.smooth_ms, 20.0);
    EXPECT_FALSE(freed.calibration.iris_is_t_stop);
    const EncoderConfig& tracker = config->encoders[2];
    EXPECT_EQ(tracker.port, 55'555);
    EXPECT_EQ(tracker.multicast, "235.135.1.1");
    EXPECT_FALSE(tracker.calibration.axes[2].table);
    EXPECT_EQ(tracker.calibration.axes[2].smooth_ms, 5.0);
}

TEST(ConfigEncoders, SaysWhereItIsWrong) {
    const std::string script = "[[encoder]]\nname=\"a\"\nkind=\"script\"\nfile=\"f\"\n";
    const struct {
        std::string text;
        const char* where;
    } kBad[] = {
        {"encoder = 1", "line 1, column 11"},
        {"encoder = [1]", "line 1, column 12"},
        {"[[encoder]]\nname=\"a\"", "line 1, column 1"},
        {"[[encoder]]\nname=\"a\"\nkind=\"abacus\"", "line 3, column 6"},
        {"[[encoder]]\nname=\"a\"\nkind=\"script\"", "line 1, column 1"},
        {"[[encoder]]\nkind=\"script\"\nfile=\"f\"", "line 1, column 1"},
        {script + "port=1", "line 5, column 1"},
        {script + "colour=1", "line 5, column 1"},
        {script + "loop=1", "line 5, column 1"},
        {script + "stale_ms=0", "line 5, column 1"},
        {script + "name2=\"\"", "line 5, column 1"},
        {script + script, "line 5, column 1"},
        {script + "focus=1", "line 5, column 1"},
        {script + "[encoder.focus]\nraw=[1,2]", "line 5, column 1"},
        {script + "[encoder.focus]\nraw=[1,\"2\"]", "line 6, column 1"},
        {script + "[encoder.focus]\nraw=[1,2]\nvalue=[2,2]", "line 7, column 7"},
        {script + "[encoder.focus]\nscale=\"t_stop\"", "line 6, column 1"},
        {script + "[encoder.focus]\nzero=4", "line 6, column 1"},
        {script + "[encoder.iris]\nscale=\"half\"", "line 6, column 1"},
        {"[[encoder]]\nname=\"a\"\nkind=\"freed\"\nport=65536", "line 4, column 1"},
    };
    for (const auto& row : kBad) {
        const auto config = ReadConfig(row.text, {});
        ASSERT_FALSE(config.ok()) << row.text;
        EXPECT_EQ(config.error().code, "bad_config") << row.text;
        EXPECT_EQ(config.error().where, row.where) << row.text << ": " << config.error().message;
    }
}

}  // namespace
}  // namespace flare
