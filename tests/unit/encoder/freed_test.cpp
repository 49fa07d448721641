// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/freed.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "tests/support/fuzz_bytes.h"
#include "tests/support/random.h"

namespace flare {
namespace {

std::vector<std::uint8_t> Message(int camera, std::uint32_t zoom, std::uint32_t focus) {
    std::vector<std::uint8_t> bytes(kFreeDBytes, 0);
    bytes[0] = 0xd1;
    bytes[1] = static_cast<std::uint8_t>(camera);
    for (std::size_t i = 0; i < 3; ++i) {
        bytes[20 + i] = static_cast<std::uint8_t>(zoom >> (16 - 8 * i));
        bytes[23 + i] = static_cast<std::uint8_t>(focus >> (16 - 8 * i));
    }
    bytes[28] = FreeDChecksum(std::span(bytes).first(28));
    return bytes;
}

// By hand: 0x40 - 0xd1 - 0xff is 0x70 modulo 256.
TEST(FreeD, ChecksumIsFortyHexLessTheSum) {
    EXPECT_EQ(FreeDChecksum(std::vector<std::uint8_t>{0xd1, 0xff}), 0x70);
    const std::vector<std::uint8_t> bytes = Message(3, 0x123456, 0xfedcba);
    EXPECT_EQ(std::accumulate(bytes.begin(), bytes.end(), 0u) % 256, 0x40u);
}

TEST(FreeD, ReadsTheCountsOfTheLens) {
    const auto message = DecodeFreeD(Message(3, 0x123456, 0xfedcba));
    ASSERT_TRUE(message);
    EXPECT_EQ(message->camera, 3);
    EXPECT_EQ(message->zoom, 0x123456u);
    EXPECT_EQ(message->focus, 0xfedcbau);
}

TEST(FreeD, RefusesEveryMessageWithOneWrongByte) {
    const std::vector<std::uint8_t> good = Message(1, 1000, 2000);
    for (std::size_t i = 0; i < good.size(); ++i) {
        std::vector<std::uint8_t> bad = good;
        bad[i] ^= 0x10;
        EXPECT_FALSE(DecodeFreeD(bad).ok()) << i;
    }
    for (std::size_t size = 0; size < good.size(); ++size) {
        EXPECT_FALSE(DecodeFreeD(std::span(good).first(size)).ok()) << size;
    }
}

TEST(FreeD, NoiseIsRefusedAndNeverHarms) {
    testing::Random random(7);
    std::vector<std::uint8_t> bytes(kFreeDBytes);
    int taken = 0;
    for (std::size_t done = 0; done < test::kFuzzBytes; done += bytes.size()) {
        for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.Below(256));
        bytes[0] = 0xd1;
        if (DecodeFreeD(bytes)) ++taken;
    }
    EXPECT_GT(taken, 0);  // one in 256 has a checksum that fits
    EXPECT_LT(taken, test::kFuzzBytes / 5'000);
}

}  // namespace
}  // namespace flare
