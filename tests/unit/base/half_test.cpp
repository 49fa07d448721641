// SPDX-License-Identifier: Apache-2.0
//
// Against the definition: the value of each half, from Imath, and what lies between neighbours.
#include "core/base/half.h"

#include <Imath/half.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <vector>

namespace flare {
namespace {

using Convert = bool (*)(const float*, std::size_t, std::uint16_t*);
constexpr Convert kBoth[] = {ConvertToHalf, ConvertToHalfPortably};
constexpr float kInfinity = std::numeric_limits<float>::infinity();

float ValueOf(std::uint16_t bits) {
    return static_cast<float>(Imath::half(Imath::half::FromBits, bits));
}

TEST(ConvertToHalf, RoundsToTheNearestAndTiesToEven) {
    std::vector<float> values;
    std::vector<std::uint16_t> expected;
    const auto expect = [&](float value, unsigned bits) {
        values.push_back(value);
        expected.push_back(static_cast<std::uint16_t>(bits));
        values.push_back(-value);
        expected.push_back(static_cast<std::uint16_t>(bits | 0x8000u));
    };
    for (unsigned bits = 0; bits < 0x7bff; ++bits) {
        const float here = ValueOf(static_cast<std::uint16_t>(bits));
        const float next = ValueOf(static_cast<std::uint16_t>(bits + 1));
        const float middle = 0.5f * (here + next);  // exact in a float
        expect(here, bits);
        expect(std::nextafter(here, kInfinity), bits);
        expect(std::nextafter(middle, 0.0f), bits);
        expect(middle, bits + (bits & 1u));
        expect(std::nextafter(middle, kInfinity), bits + 1);
        expect(std::nextafter(next, 0.0f), bits + 1);
    }
    for (const Convert convert : kBoth) {
        std::vector<std::uint16_t> halves(values.size());
        EXPECT_FALSE(convert(values.data(), values.size(), halves.data()));
        for (std::size_t i = 0; i < values.size(); ++i) {
            ASSERT_EQ(halves[i], expected[i]) << values[i];
        }
    }
}

TEST(ConvertToHalf, SaturatesAndSaysSo) {
    const float beyond = std::nextafter(kLargestHalf, kInfinity);
    const std::pair<float, std::uint16_t> cases[] = {{beyond, 0x7bff},    {-beyond, 0xfbff},
                                                     {65520.0f, 0x7bff},  {-3e38f, 0xfbff},
                                                     {kInfinity, 0x7bff}, {-kInfinity, 0xfbff}};
    for (const Convert convert : kBoth) {
        for (const auto& [value, bits] : cases) {
            // At any place of a line, also behind the last whole vector.
            for (std::size_t at = 0; at < 19; ++at) {
                std::vector<float> line(19, -kLargestHalf);
                std::vector<std::uint16_t> halves(19);
                EXPECT_FALSE(convert(line.data(), line.size(), halves.data()));
                line[at] = value;
                EXPECT_TRUE(convert(line.data(), line.size(), halves.data())) << value << at;
                EXPECT_EQ(halves[at], bits) << value;
            }
        }
    }
}

TEST(ConvertToHalf, NanStaysNanAndIsNotSaturated) {
    std::vector<float> nans;
    for (std::uint32_t payload = 1; payload < 1u << 23; payload += 4099) {
        nans.push_back(std::bit_cast<float>(0x7f800000u | payload));
        nans.push_back(std::bit_cast<float>(0xff800000u | payload));
    }
    std::vector<std::uint16_t> halves(nans.size()), portable(nans.size());
    EXPECT_FALSE(ConvertToHalf(nans.data(), nans.size(), halves.data()));
    EXPECT_FALSE(ConvertToHalfPortably(nans.data(), nans.size(), portable.data()));
    EXPECT_EQ(halves, portable);
    for (std::size_t i = 0; i < nans.size(); ++i) {
        EXPECT_TRUE(Imath::half(Imath::half::FromBits, halves[i]).isNan());
        EXPECT_EQ(halves[i] >> 15, std::signbit(nans[i]) ? 1 : 0);
    }
}

TEST(ConvertToHalf, BothWaysAgreeOnFloatsOfEveryExponent) {
    std::vector<float> values;
    for (std::uint64_t bits = 0; bits < std::uint64_t{1} << 32; bits += 4093) {
        values.push_back(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    }
    std::vector<std::uint16_t> halves(values.size()), portable(values.size());
    ConvertToHalf(values.data(), values.size(), halves.data());
    ConvertToHalfPortably(values.data(), values.size(), portable.data());
    EXPECT_TRUE(halves == portable);
}

}  // namespace
}  // namespace flare
