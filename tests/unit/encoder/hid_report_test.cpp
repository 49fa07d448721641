// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/hid_report.h"

#include <gtest/gtest.h>

#include <vector>

#include "server/encoder/line_splitter.h"
#include "tests/support/fuzz_bytes.h"
#include "tests/support/random.h"

namespace flare {
namespace {

const std::vector<std::uint8_t> kReport{1, 0xfe, 0xff, 0x12, 0x34, 0x56, 0x80, 0x00, 0x01};

double Count(const HidField& field) {
    HidMap map;
    map.fields[0] = field;
    const auto sample = DecodeHidReport(kReport, map);
    EXPECT_TRUE(sample && *sample);
    return *(*sample)->raw[0];
}

TEST(HidReport, ReadsCountsOfEveryForm) {
    EXPECT_EQ(Count({1, 8, false, false}), 0xfe);
    EXPECT_EQ(Count({1, 8, true, false}), -2);
    EXPECT_EQ(Count({1, 16, false, false}), 0xfffe);
    EXPECT_EQ(Count({1, 16, true, false}), -2);
    EXPECT_EQ(Count({3, 16, false, true}), 0x1234);
    EXPECT_EQ(Count({3, 24, false, false}), 0x563412);
    EXPECT_EQ(Count({3, 24, true, true}), 0x123456);
    EXPECT_EQ(Count({4, 24, true, false}), 0x805634 - 0x1000000);
    EXPECT_EQ(Count({5, 32, false, false}), 0x01008056);
    EXPECT_EQ(Count({5, 32, false, true}), 0x56800001);
    EXPECT_EQ(Count({1, 32, true, true}), static_cast<std::int32_t>(0xfeff1234));
}

TEST(HidReport, PassesOverOtherReportsAndRefusesShortOnes) {
    HidMap map;
    map.report = 2;
    map.fields[1] = HidField{7, 16, false, false};
    const auto other = DecodeHidReport(kReport, map);
    ASSERT_TRUE(other);
    EXPECT_FALSE(*other);
    map.report = 1;
    ASSERT_TRUE(DecodeHidReport(kReport, map));
    EXPECT_EQ((**DecodeHidReport(kReport, map)).raw[1], 0x0100);
    EXPECT_EQ((**DecodeHidReport(kReport, map)).raw[0], std::nullopt);
    EXPECT_FALSE(DecodeHidReport(std::span(kReport).first(8), map).ok());
    EXPECT_FALSE(DecodeHidReport({}, map).ok());
}

TEST(HidReport, NoReportHarms) {
    testing::Random random(9);
    for (int bytes = 0; bytes < test::kFuzzBytes;) {
        std::vector<std::uint8_t> report(static_cast<std::size_t>(random.Below(64)));
        bytes += static_cast<int>(report.size()) + 1;
        for (std::uint8_t& byte : report) byte = static_cast<std::uint8_t>(random.Below(256));
        HidMap map;
        const int size = 8 * (1 + random.Below(4));
        map.fields[2] =
            HidField{random.Below(64), size, random.Below(2) == 0, random.Below(2) == 0};
        const auto sample = DecodeHidReport(report, map);
        const bool fits = static_cast<std::size_t>(map.fields[2]->byte + size / 8) <= report.size();
        EXPECT_EQ(sample.ok(), fits);
    }
}

TEST(LineSplitter, TakesAnyLineEndAndDropsWhatHasNone) {
    LineSplitter lines(5);
    lines.Push("ab\n\rcd");
    EXPECT_EQ(lines.Next(), "ab");
    EXPECT_EQ(lines.Next(), std::nullopt);
    EXPECT_TRUE(lines.in_a_line());
    lines.Push("e\r\n\r12345\r");
    EXPECT_EQ(lines.Next(), "cde");
    EXPECT_EQ(lines.Next(), "12345");
    EXPECT_EQ(lines.Next(), std::nullopt);
    lines.Push("1234567890");
    EXPECT_EQ(lines.Next(), std::nullopt);
    EXPECT_EQ(lines.dropped(), 1u);
    lines.Push("1234567890\nok\n");
    EXPECT_EQ(lines.Next(), "ok");
    EXPECT_EQ(lines.dropped(), 1u);
}

}  // namespace
}  // namespace flare
