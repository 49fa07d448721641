// SPDX-License-Identifier: Apache-2.0
#include "core/image/preview.h"

#include <Imath/half.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cstdint>
#include <cstring>
#include <limits>

#include "tests/unit/exr/exr_samples.h"

namespace flare {
namespace {

struct Pixels {
    bool colour = false;
    unsigned width = 0, height = 0;
    std::vector<std::uint8_t> codes;  // RGB, also of a grey picture
};

Pixels ReadPng(const std::string& bytes) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    EXPECT_NE(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()), 0);
    Pixels pixels{(png.format & PNG_FORMAT_FLAG_COLOR) != 0, png.width, png.height, {}};
    png.format = PNG_FORMAT_RGB;
    pixels.codes.resize(PNG_IMAGE_SIZE(png));
    EXPECT_NE(png_image_finish_read(&png, nullptr, pixels.codes.data(), 0, nullptr), 0);
    return pixels;
}

FlareImage Flat(int width, int height, const std::vector<std::pair<std::string, float>>& planes) {
    FlareImage image;
    image.full = image.data = {0, 0, width, height};
    for (const auto& [name, value] : planes) {
        image.planes.push_back({name, std::vector<float>(image.data.pixels(), value)});
    }
    return image;
}

std::vector<std::uint8_t> FirstPixel(const FlareImage& image) {
    const Pixels pixels = ReadPng(EncodePng(image));
    return {pixels.codes.begin(), pixels.codes.begin() + 3};
}

TEST(EncodePng, TheBrightestChannelOfAnEvenPictureIsAtEightyPercentGrey) {
    const Pixels png = ReadPng(EncodePng(Flat(7, 3, {{"R", 0.5f}, {"G", 0.25f}, {"B", 0.0f}})));
    EXPECT_EQ(png.width, 7u);
    EXPECT_EQ(png.height, 3u);
    EXPECT_TRUE(png.colour);
    EXPECT_EQ(png.codes[0], 204);  // 0.8 * 255
    // Half the light of 0.6038: sRGB of 0.3019 is 1.055 * 0.3019^(1/2.4) - 0.055 = 0.5858.
    EXPECT_EQ(png.codes[1], 149);
    EXPECT_EQ(png.codes[2], 0);
}

// One colour, in the primaries of Rec.709 and of AP1 (columns of the published matrix).
TEST(EncodePng, ShowsOtherPrimariesInTheirColours) {
    const FlareImage plain = Flat(3, 2, {{"R", 1.0f}, {"G", 0.5f}, {"B", 0.2f}});
    const auto mixed = [](double r, double g, double b) {
        return static_cast<float>(r + 0.5 * g + 0.2 * b);
    };
    FlareImage wide = Flat(3, 2,
                           {{"R", mixed(0.6130974, 0.3395231, 0.0473795)},
                            {"G", mixed(0.0701937, 0.9163539, 0.0134524)},
                            {"B", mixed(0.0206156, 0.1095698, 0.8698146)}});
    wide.rec709 = false;
    wide.chromaticities = Ap1Chromaticities();
    const Pixels want = ReadPng(EncodePng(plain)), got = ReadPng(EncodePng(wide));
    ASSERT_EQ(got.codes.size(), want.codes.size());
    for (std::size_t i = 0; i < want.codes.size(); ++i) {
        EXPECT_NEAR(got.codes[i], want.codes[i], 1.0);
    }
}

TEST(EncodePng, ScaleDoesNotMatter) {
    FlareImage image = Gradient(64, 64, {"R", "G", "B"});
    const std::string png = EncodePng(image);
    for (ImagePlane& plane : image.planes) {
        for (float& value : plane.values) value *= 1.0f / 4096.0f;
    }
    EXPECT_EQ(EncodePng(image), png);
}

TEST(EncodePng, FewBrightPixelsDoNotDarkenThePictureAndDoNotWrap) {
    FlareImage image = Flat(100, 100, {{"R", 1.0f}, {"G", 1.0f}, {"B", 1.0f}});
    for (ImagePlane& plane : image.planes) plane.values[0] = 1e30f;
    const Pixels png = ReadPng(EncodePng(image));
    EXPECT_EQ(png.codes[0], 255);
    EXPECT_EQ(png.codes[3], 204);
}

TEST(EncodePng, BlackNanNegativeAndInfiniteAreSafe) {
    EXPECT_EQ(FirstPixel(Flat(2, 2, {{"R", 0.0f}, {"G", 0.0f}, {"B", 0.0f}})),
              (std::vector<std::uint8_t>{0, 0, 0}));
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinity = std::numeric_limits<float>::infinity();
    EXPECT_EQ(FirstPixel(Flat(2, 2, {{"R", nan}, {"G", -1.0f}, {"B", infinity}})),
              (std::vector<std::uint8_t>{0, 0, 255}));
    EXPECT_EQ(FirstPixel(Flat(2, 2, {{"R", 1e-44f}, {"G", 0.0f}, {"B", 0.0f}}))[1], 0);
}

TEST(EncodePng, ColourIsFoundByNameInAnyOrder) {
    const std::vector<std::uint8_t> red = {204, 0, 0};
    EXPECT_EQ(FirstPixel(Flat(2, 2, {{"B", 0.0f}, {"G", 0.0f}, {"R", 1.0f}})), red);
    EXPECT_EQ(FirstPixel(Flat(2, 2, {{"ghosts.B", 0.0f}, {"ghosts.G", 0.0f}, {"ghosts.R", 3.0f}})),
              red);
}

TEST(EncodePng, SpectralPlanesAreShownAsGreyMeanOfTheFirstLayer) {
    // Left half: 1 and 3, right half: 0 and 2; means 2 and 1. The ghosts layer does not count
    // twice.
    FlareImage image =
        Flat(2, 1, {{"S0.450nm", 1.0f}, {"S0.550nm", 3.0f}, {"ghosts.S0.450nm", 9.0f}});
    image.planes[0].values[1] = 0.0f;
    image.planes[1].values[1] = 2.0f;
    const Pixels png = ReadPng(EncodePng(image));
    EXPECT_FALSE(png.colour);
    EXPECT_EQ(png.codes[0], 204);
    EXPECT_EQ(png.codes[3], 149);  // half the light, as above
}

TEST(EncodeHalfPlanes, LayoutIsAsStated) {
    FlareImage image = Flat(3, 2, {{"R", 1.0f}, {"ghosts.R", -2.0f}});
    image.planes[1].values[5] = 1e9f;
    ThreadPool threads(2);
    const HalfPlanes planes = EncodeHalfPlanes(image, threads);
    const std::string& bytes = planes.bytes;
    EXPECT_EQ(planes.saturated_pixels, 1u);
    const std::string names("R\0ghosts.R\0", 11);
    ASSERT_EQ(bytes.size(), 64 + names.size() + 2u * 2u * 6u);
    EXPECT_EQ(bytes.substr(0, 24),
              std::string("FLRH\1\0\0\0\3\0\0\0\2\0\0\0\2\0\0\0\13\0\0\0", 24));
    EXPECT_EQ(bytes.substr(24, 40), std::string(40, '\0'));
    EXPECT_EQ(bytes.substr(64, names.size()), names);
    const auto half = [&](std::size_t plane, std::size_t pixel) {
        const std::size_t at = 64 + names.size() + 2 * (plane * 6 + pixel);
        return static_cast<unsigned char>(bytes[at]) +
               256 * static_cast<unsigned char>(bytes[at + 1]);
    };
    EXPECT_EQ(half(0, 0), 0x3c00);  // IEEE 754 binary16: 1, -2, 65504
    EXPECT_EQ(half(1, 0), 0xc000);
    EXPECT_EQ(half(1, 5), 0x7bff);
}

TEST(EncodeHalfPlanes, LargePicturesComeOutTheSameOnAnyNumberOfThreads) {
    const FlareImage image = Gradient(401, 307, {"G", "R"});
    ThreadPool one(1);
    const std::string bytes = EncodeHalfPlanes(image, one).bytes;
    for (const int count : {2, 5}) {
        ThreadPool threads(count);
        EXPECT_TRUE(EncodeHalfPlanes(image, threads).bytes == bytes) << count;
    }
    const std::size_t pixels = image.data.pixels();
    for (std::size_t k = 0; k < 2 * pixels; ++k) {
        std::uint16_t bits = 0;
        std::memcpy(&bits, bytes.data() + 64 + 4 + 2 * k, 2);
        const float value = image.planes[k / pixels].values[k % pixels];
        ASSERT_EQ(bits, Imath::half(value).bits()) << k;
    }
}

}  // namespace
}  // namespace flare
