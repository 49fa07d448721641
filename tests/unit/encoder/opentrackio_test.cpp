// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/opentrackio.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/fuzz_bytes.h"
#include "tests/support/random.h"

namespace flare {
namespace {

std::vector<std::uint8_t> Bytes(std::string_view text) {
    return {text.begin(), text.end()};
}

// Built byte by byte after the standard's table, with a checksum of its own.
std::vector<std::uint8_t> Datagram(std::string_view payload, int sequence, std::size_t offset = 0,
                                   bool last = true, int encoding = 1) {
    std::vector<std::uint8_t> bytes = Bytes("OTrk");
    bytes.push_back(0);
    bytes.push_back(static_cast<std::uint8_t>(encoding));
    for (const int shift : {8, 0}) bytes.push_back(static_cast<std::uint8_t>(sequence >> shift));
    for (const int shift : {24, 16, 8, 0}) {
        bytes.push_back(static_cast<std::uint8_t>(offset >> shift));
    }
    bytes.push_back(static_cast<std::uint8_t>((last ? 0x80 : 0) | payload.size() >> 8));
    bytes.push_back(static_cast<std::uint8_t>(payload.size()));
    unsigned long a = 0, b = 0;
    std::vector<std::uint8_t> summed = bytes;
    for (const char c : payload) summed.push_back(static_cast<std::uint8_t>(c));
    for (const std::uint8_t byte : summed) b += a += byte;
    bytes.push_back(static_cast<std::uint8_t>(a % 255));
    bytes.push_back(static_cast<std::uint8_t>(b % 255));
    bytes.insert(bytes.end(), payload.begin(), payload.end());
    return bytes;
}

constexpr char kSample[] =
    R"({"protocol":{"name":"OpenTrackIO","version":[1,0,1]},"tracker":{"status":"Optical Good"},
        "lens":{"tStop":4.1,"fStop":4.0,"pinholeFocalLength":24.305,"focusDistance":10.0,
                "encoders":{"focus":0.1,"iris":0.2,"zoom":0.3},
                "distortion":[{"radial":[1.0,2.0,3.0]}]}})";

// The published vectors of the algorithm (RFC 1146's sums; "abcde" to C8F0 and so on, the second
// sum first there).
TEST(OpenTrackIo, FletcherSumsMeetThePublishedVectors) {
    using Sums = std::array<std::uint8_t, 2>;
    EXPECT_EQ(Fletcher16(Bytes("abcde"), {}), (Sums{0xf0, 0xc8}));
    EXPECT_EQ(Fletcher16(Bytes("abc"), Bytes("def")), (Sums{0x57, 0x20}));
    EXPECT_EQ(Fletcher16({}, Bytes("abcdefgh")), (Sums{0x27, 0x06}));
}

TEST(OpenTrackIo, ReadsValuesAndCountsOfTheLens) {
    const auto sample = DecodeOpenTrackIoSample(kSample);
    ASSERT_TRUE(sample) << sample.error().message;
    EXPECT_EQ(sample->stated[LensAxis::kFocus], 10.0);
    EXPECT_EQ(sample->stated[LensAxis::kIris], 4.1);
    EXPECT_TRUE(sample->stated.iris_is_t_stop);
    EXPECT_EQ(sample->stated[LensAxis::kZoom], 24.305);
    EXPECT_EQ(sample->raw[0], 0.1);
    EXPECT_EQ(sample->raw[1], 0.2);
    EXPECT_EQ(sample->raw[2], 0.3);
    const auto f_stop = DecodeOpenTrackIoSample(R"({"lens":{"fStop":2,"rawEncoders":{"iris":9}}})");
    ASSERT_TRUE(f_stop);
    EXPECT_FALSE(f_stop->stated.iris_is_t_stop);
    EXPECT_EQ(f_stop->raw[1], 9.0);
    EXPECT_TRUE(DecodeOpenTrackIoSample(R"({"transforms":[]})"));
}

TEST(OpenTrackIo, RefusesSamplesWithTheirPlace) {
    const struct {
        const char* json;
        const char* where;
    } kBad[] = {{"[]", ""},
                {"{\"lens\":3}", "/lens"},
                {R"({"lens":{"tStop":"4"}})", "/lens/tStop"},
                {R"({"lens":{"encoders":[]}})", "/lens/encoders"},
                {R"({"lens":{"encoders":{"zoom":null}}})", "/lens/encoders/zoom"}};
    for (const auto& row : kBad) {
        const auto sample = DecodeOpenTrackIoSample(row.json);
        ASSERT_FALSE(sample.ok()) << row.json;
        EXPECT_EQ(sample.error().where, row.where) << row.json;
    }
}

TEST(OpenTrackIo, PutsSegmentsTogetherAndCountsWhatIsMissing) {
    const std::string_view text = kSample;
    OpenTrackIoStream stream;
    EXPECT_FALSE(stream.Push(Datagram(text.substr(0, 100), 7, 0, false))->sample);
    EXPECT_FALSE(stream.Push(Datagram(text.substr(100, 50), 8, 100, false))->sample);
    const auto whole = stream.Push(Datagram(text.substr(150), 9, 150));
    ASSERT_TRUE(whole) << whole.error().message;
    ASSERT_TRUE(whole->sample);
    EXPECT_EQ(whole->sample->raw[0], 0.1);
    // The middle one is lost: the rest is passed over, the next sample is whole again.
    EXPECT_FALSE(stream.Push(Datagram(text.substr(0, 100), 10, 0, false))->sample);
    const auto rest = stream.Push(Datagram(text.substr(150), 12, 150));
    ASSERT_TRUE(rest);
    EXPECT_EQ(rest->lost, 1u);
    EXPECT_FALSE(rest->sample);
    EXPECT_TRUE(stream.Push(Datagram(text, 13))->sample);
    // Around the end of the numbers, and a sender that begins anew.
    EXPECT_EQ(stream.Push(Datagram(text, 65'535))->lost, 0u);
    EXPECT_EQ(stream.Push(Datagram(text, 1))->lost, 1u);
    EXPECT_FALSE(stream.Push(Datagram(text.substr(150), 2, 150))->sample);
}

TEST(OpenTrackIo, RefusesDatagramsThatAreNoneOfItsOwn) {
    const std::vector<std::uint8_t> good = Datagram("{}", 1);
    ASSERT_TRUE(DecodeOpenTrackIoSegment(good));
    for (std::size_t i = 0; i < good.size(); ++i) {
        std::vector<std::uint8_t> bad = good;
        bad[i] ^= 0x20;
        EXPECT_FALSE(DecodeOpenTrackIoSegment(bad).ok()) << i;
        EXPECT_FALSE(DecodeOpenTrackIoSegment(std::span(good).first(i)).ok()) << i;
    }
    OpenTrackIoStream stream;
    EXPECT_EQ(stream.Push(Datagram("{}", 1, 0, true, 2)).error().where, "byte 6");
    OpenTrackIoStream endless;
    const std::string part(30'000, ' ');
    bool refused = false;
    for (int i = 0; i < 20 && !refused; ++i) {
        refused =
            !endless.Push(Datagram(part, i, part.size() * static_cast<std::size_t>(i), false)).ok();
    }
    EXPECT_TRUE(refused);
}

TEST(OpenTrackIo, NoiseNeverHarms) {
    testing::Random random(11);
    const std::vector<std::uint8_t> good = Datagram(kSample, 1);
    OpenTrackIoStream stream;
    int taken = 0;
    for (std::size_t done = 0; done < test::kFuzzBytes; done += good.size()) {
        std::vector<std::uint8_t> bytes = good;
        const int changes = random.Below(4);
        for (int i = 0; i < changes; ++i) {
            bytes[static_cast<std::size_t>(random.Below(static_cast<int>(bytes.size())))] =
                static_cast<std::uint8_t>(random.Below(256));
        }
        const auto sum = Fletcher16(std::span(bytes).first(14), std::span(bytes).subspan(16));
        bytes[14] = sum[0];
        bytes[15] = sum[1];
        const auto step = stream.Push(bytes);
        if (step && step->sample) ++taken;
    }
    EXPECT_GT(taken, 500);
}

}  // namespace
}  // namespace flare
