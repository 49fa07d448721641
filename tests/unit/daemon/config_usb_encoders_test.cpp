// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "server/config.h"

namespace flare {
namespace {

TEST(ConfigUsbEncoders, ReadsEachKind) {
    const auto config = ReadConfig(R"(
[[encoder]]
name = "ring"
kind = "qsb"
axis = "iris"
index = -500
[[encoder]]
name = "lens"
kind = "cooke"
serial = "FT1"
product = 0x6015
[[encoder]]
name = "box"
kind = "hid"
vendor = 0x16c0
product = 0x27d9
report = 3
zoom_field = { byte = 2, bits = 24, signed = true, big_endian = true }
)",
                                   {});
    ASSERT_TRUE(config.ok()) << config.error().where << config.error().message;
    ASSERT_EQ(config->encoders.size(), 3u);
    EXPECT_EQ(config->encoders[0].axis, LensAxis::kIris);
    EXPECT_EQ(config->encoders[0].index_count, -500);
    EXPECT_FALSE(config->encoders[0].vendor);
    EXPECT_EQ(config->encoders[1].serial, "FT1");
    EXPECT_EQ(config->encoders[1].product, 0x6015);
    const EncoderConfig& box = config->encoders[2];
    EXPECT_EQ(box.vendor, 0x16c0);
    EXPECT_EQ(box.hid.report, 3);
    EXPECT_FALSE(box.hid.fields[0]);
    ASSERT_TRUE(box.hid.fields[2]);
    EXPECT_EQ(box.hid.fields[2]->byte, 2);
    EXPECT_EQ(box.hid.fields[2]->bits, 24);
    EXPECT_TRUE(box.hid.fields[2]->is_signed);
    EXPECT_TRUE(box.hid.fields[2]->big_endian);
}

TEST(ConfigUsbEncoders, SaysWhereItIsWrong) {
    const std::string hid = "[[encoder]]\nname=\"a\"\nkind=\"hid\"\nvendor=1\nproduct=2\n";
    const struct {
        std::string text;
        const char* where;
    } kBad[] = {
        {"[[encoder]]\nname=\"a\"\nkind=\"cooke\"", "line 1, column 1"},  // whose cable?
        {"[[encoder]]\nname=\"a\"\nkind=\"hid\"\nvendor=1", "line 1, column 1"},
        {"[[encoder]]\nname=\"a\"\nkind=\"qsb\"\naxis=\"height\"", "line 4, column 1"},
        {"[[encoder]]\nname=\"a\"\nkind=\"qsb\"\nport=1", "line 4, column 1"},
        {hid + "report=256", "line 6, column 1"},
        {hid + "axis=\"focus\"", "line 6, column 1"},
        {hid + "index=1", "line 6, column 1"},
        {"[[encoder]]\nname=\"a\"\nkind=\"qsb\"\nindex=0.5", "line 4, column 1"},
        {hid + "focus_field=1", "line 6, column 1"},
        {hid + "focus_field={bits=8}", "line 6, column 1"},
        {hid + "focus_field={byte=1,bits=12}", "line 6, column 1"},
        {hid + "focus_field={byte=-1}", "line 6, column 1"},
        {hid + "focus_field={byte=1,width=2}", "line 6, column 1"},
    };
    for (const auto& row : kBad) {
        const auto config = ReadConfig(row.text, {});
        ASSERT_FALSE(config.ok()) << row.text;
        EXPECT_EQ(config.error().where, row.where) << row.text << ": " << config.error().message;
    }
}

}  // namespace
}  // namespace flare
