// SPDX-License-Identifier: Apache-2.0
#include "core/image/huffman_code.h"

#include <gtest/gtest.h>

#include <functional>
#include <queue>
#include <random>

namespace flare {
namespace {

std::uint64_t Cost(const std::vector<std::uint32_t>& counts, const HuffmanCode& code) {
    std::uint64_t bits = 0;
    for (std::size_t s = 0; s < counts.size(); ++s) {
        bits += std::uint64_t{counts[s]} * code.lengths[s];
    }
    return bits;
}

// The least cost of any prefix code: each joining of the two rarest adds a bit to both.
std::uint64_t LeastCost(const std::vector<std::uint32_t>& counts) {
    std::priority_queue<std::uint64_t, std::vector<std::uint64_t>, std::greater<>> nodes;
    for (const std::uint32_t count : counts) {
        if (count > 0) nodes.push(count);
    }
    std::uint64_t cost = 0;
    while (nodes.size() > 1) {
        std::uint64_t sum = nodes.top();
        nodes.pop();
        sum += nodes.top();
        nodes.pop();
        cost += sum;
        nodes.push(sum);
    }
    return cost;
}

// Kraft's sum in units of 2^-15: a complete prefix code has 2^15.
unsigned KraftSum(const HuffmanCode& code) {
    unsigned sum = 0;
    for (const std::uint8_t length : code.lengths) {
        if (length > 0) sum += 1u << (15 - length);
    }
    return sum;
}

TEST(MakeHuffmanCode, IsCompleteAndCostsTheLeast) {
    std::mt19937 random(1);
    for (std::size_t symbols = 2; symbols < 287; symbols += 3) {
        std::vector<std::uint32_t> counts(symbols);
        for (std::uint32_t& count : counts)
            count = 200 + static_cast<std::uint32_t>(random() % 800);
        counts.push_back(0);
        const HuffmanCode code = MakeHuffmanCode(counts, 15);
        EXPECT_EQ(code.lengths.back(), 0);
        EXPECT_EQ(KraftSum(code), 1u << 15) << symbols;
        EXPECT_EQ(Cost(counts, code), LeastCost(counts)) << symbols;
    }
}

TEST(MakeHuffmanCode, KeepsToTheLongestLength) {
    std::vector<std::uint32_t> fibonacci = {1, 1};
    while (fibonacci.size() < 40) {
        fibonacci.push_back(fibonacci.back() + fibonacci[fibonacci.size() - 2]);
    }
    for (const int longest : {6, 7, 14}) {
        const HuffmanCode code = MakeHuffmanCode(fibonacci, longest);
        for (const std::uint8_t length : code.lengths) {
            EXPECT_GE(length, 1);
            EXPECT_LE(length, longest);
        }
        EXPECT_EQ(KraftSum(code), 1u << 15);
    }
}

TEST(MakeHuffmanCode, OneSymbolTakesOneBitAndNoneTakesNone) {
    EXPECT_EQ(MakeHuffmanCode({0, 9, 0}, 14).lengths, (std::vector<std::uint8_t>{0, 1, 0}));
    EXPECT_EQ(MakeHuffmanCode({0, 0}, 14).lengths, (std::vector<std::uint8_t>{0, 0}));
}

// RFC 1951, 3.2.2: lengths (3, 3, 3, 3, 3, 2, 4, 4) give 010 ... 110, 00, 1110, 1111.
TEST(MakeHuffmanCode, CodesAreThoseOfTheRfcExampleReversed) {
    const HuffmanCode code = MakeHuffmanCode({12, 12, 12, 12, 12, 20, 6, 6}, 14);
    ASSERT_EQ(code.lengths, (std::vector<std::uint8_t>{3, 3, 3, 3, 3, 2, 4, 4}));
    EXPECT_EQ(code.codes, (std::vector<std::uint16_t>{0b010, 0b110, 0b001, 0b101, 0b011, 0b00,
                                                      0b0111, 0b1111}));
}

}  // namespace
}  // namespace flare
