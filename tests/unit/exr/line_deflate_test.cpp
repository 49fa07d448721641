// SPDX-License-Identifier: Apache-2.0
//
// What LineDeflater writes is read by zlib.
#include "core/image/line_deflate.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <random>
#include <string>

namespace flare {
namespace {

using Bytes = std::vector<unsigned char>;

// The stream, "" where it does not fit into `room`; nothing behind it but the slack is touched.
Bytes Deflated(const Bytes& bytes, std::size_t segment, std::size_t repeat, std::size_t room) {
    constexpr std::size_t kGuard = 64;
    Bytes to(room + LineDeflater::kSlack + kGuard, 0xa5);
    const std::size_t size =
        LineDeflater().Deflate(bytes.data(), bytes.size(), segment, repeat, to.data(), room);
    EXPECT_LE(size, room);
    EXPECT_EQ(std::count(to.end() - kGuard, to.end(), 0xa5), static_cast<int>(kGuard));
    to.resize(size);
    return to;
}

Bytes Inflated(const Bytes& stream, std::size_t count) {
    Bytes bytes(count + 1);
    uLongf size = bytes.size();
    EXPECT_EQ(uncompress(bytes.data(), &size, stream.data(), stream.size()), Z_OK);
    bytes.resize(size);
    return bytes;
}

void ExpectRoundTrip(const Bytes& bytes, std::size_t segment, std::size_t repeat,
                     const std::string& what) {
    const Bytes stream = Deflated(bytes, segment, repeat, 2 * bytes.size() + 500);
    ASSERT_FALSE(stream.empty()) << what;
    EXPECT_TRUE(Inflated(stream, bytes.size()) == bytes) << what;
    // Exactly as much room as it takes is enough, and a byte less is not.
    EXPECT_TRUE(Deflated(bytes, segment, repeat, stream.size()) == stream) << what;
    EXPECT_TRUE(Deflated(bytes, segment, repeat, stream.size() - 1).empty()) << what;
}

TEST(LineDeflater, ZlibReadsRunsOfEveryLength) {
    std::mt19937 random(1);
    Bytes bytes;
    for (std::size_t length = 1; length < 600; ++length) {
        bytes.insert(bytes.end(), length, static_cast<unsigned char>(random()));
    }
    bytes.resize(bytes.size() / 2 * 2);
    ExpectRoundTrip(bytes, bytes.size() / 2, 0, "one segment a half");
    bytes.resize(bytes.size() / 20 * 20);
    ExpectRoundTrip(bytes, 10, 0, "segments of 10");
    ExpectRoundTrip(bytes, 1, 1, "segments of 1");
}

TEST(LineDeflater, ZlibReadsRepeatedSegments) {
    std::mt19937 random(2);
    for (const std::size_t segment : {2u, 3u, 4u, 5u, 100u, 258u, 259u, 260u, 261u, 262u, 519u}) {
        for (const std::size_t channels : {1u, 3u, 17u}) {
            // Lines of a root and of a layer that repeats it, all but a few.
            Bytes bytes;
            for (int line = 0; line < 8; ++line) {
                Bytes root(segment * channels);
                for (unsigned char& byte : root) byte = static_cast<unsigned char>(random() % 97);
                bytes.insert(bytes.end(), root.begin(), root.end());
                if (line == 3) root[root.size() / 2] ^= 1;
                bytes.insert(bytes.end(), root.begin(), root.end());
            }
            ExpectRoundTrip(bytes, segment, segment * channels,
                            std::to_string(segment) + " x " + std::to_string(channels));
        }
    }
}

TEST(LineDeflater, RepeatsAsFarAsTheWindowAndNoFarther) {
    std::mt19937 random(3);
    for (const std::size_t distance : {32768u, 32770u}) {
        Bytes bytes(2 * distance);
        for (std::size_t i = 0; i < distance; ++i) {
            bytes[i] = bytes[i + distance] = static_cast<unsigned char>(random());
        }
        ExpectRoundTrip(bytes, distance, distance, std::to_string(distance));
        const std::size_t size = Deflated(bytes, distance, distance, 4 * distance).size();
        EXPECT_EQ(size < distance + distance / 4, distance == 32768) << size;
    }
}

TEST(LineDeflater, ZlibReadsManyBlocksAndSkewedCounts) {
    std::mt19937 random(4);
    Bytes bytes(3 << 20);
    // A count of a byte is about half of the next one's: codes would be longer than allowed.
    for (unsigned char& byte : bytes) {
        byte = static_cast<unsigned char>(std::countr_zero(random() | 1u << 24) * 3);
    }
    ExpectRoundTrip(bytes, 1 << 10, 0, "skewed");
    for (unsigned char& byte : bytes) byte = static_cast<unsigned char>(random());
    ExpectRoundTrip(bytes, 1 << 19, 0, "noise");
    EXPECT_TRUE(Deflated(bytes, 1 << 10, 0, bytes.size() - 1).empty());
}

TEST(LineDeflater, ZlibReadsTheSmallest) {
    ExpectRoundTrip({0, 0}, 1, 0, "two zeros");
    ExpectRoundTrip({255, 0}, 1, 1, "two bytes");
    EXPECT_TRUE(Deflated({1, 2}, 1, 0, 0).empty());
    EXPECT_TRUE(Deflated({1, 2}, 1, 0, 6).empty());
}

TEST(Adler32, AgreesWithZlib) {
    std::mt19937 random(5);
    for (const std::size_t count : {0u, 1u, 255u, 256u, 257u, 5551u, 5553u, 1u << 20}) {
        Bytes bytes(count);
        for (unsigned char& byte : bytes) byte = static_cast<unsigned char>(random());
        EXPECT_EQ(Adler32(bytes.data(), count), adler32(1, bytes.data(), static_cast<uInt>(count)));
        std::fill(bytes.begin(), bytes.end(), static_cast<unsigned char>(255));
        EXPECT_EQ(Adler32(bytes.data(), count), adler32(1, bytes.data(), static_cast<uInt>(count)));
    }
}

}  // namespace
}  // namespace flare
