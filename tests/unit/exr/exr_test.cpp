// SPDX-License-Identifier: Apache-2.0
//
// What EncodeExr writes is read back by OpenEXR's own classes, not by DecodeExr.
#include "core/image/exr.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "core/image/preview.h"
#include "tests/support/library_exr.h"
#include "tests/unit/exr/exr_samples.h"

namespace flare {
namespace {

ExrBytes Encoded(const FlareImage& image, const ExrOptions& options) {
    ThreadPool threads(2);
    return EncodeExr(image, options, threads);
}

// One channel of an EXR as floats, read by OpenEXR over the header's data window.
std::vector<float> ReadChannel(const std::string& bytes, const std::string& name) {
    Imf::StdISStream stream;
    stream.str(bytes);
    Imf::InputFile file(stream);
    const Imath::Box2i box = file.header().dataWindow();
    const int width = box.max.x - box.min.x + 1, height = box.max.y - box.min.y + 1;
    std::vector<float> values(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    Imf::FrameBuffer frame;
    frame.insert(name, Imf::Slice::Make(Imf::FLOAT, values.data(), box.min, width, height));
    file.setFrameBuffer(frame);
    file.readPixels(box.min.y, box.max.y);
    return values;
}

Imf::Header ReadHeader(const std::string& bytes) {
    Imf::StdISStream stream;
    stream.str(bytes);
    return Imf::InputFile(stream).header();
}

TEST(EncodeExr, EveryPlaneIsAChannelUnderItsOwnName) {
    FlareImage image =
        Gradient(37, 300, {"R", "ghosts.R", "S0.587,5618nm", "ghosts.S0.587,5618nm"});
    for (const ExrCompression compression : {ExrCompression::kZip, ExrCompression::kNone}) {
        const std::string bytes = Encoded(image, {compression, ExrPixel::kFloat}).bytes;
        for (const ImagePlane& plane : image.planes) {
            EXPECT_EQ(ReadChannel(bytes, plane.name), plane.values) << plane.name;
        }
        const Imf::Header header = ReadHeader(bytes);
        int channels = 0;
        for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
            EXPECT_EQ(c.channel().type, Imf::FLOAT);
            ++channels;
        }
        EXPECT_EQ(channels, 4);
    }
}

// As a layer does that is the whole picture: it is not converted twice.
TEST(EncodeExr, SharedSamplesGiveTheBytesOfEqualOnes) {
    FlareImage shared = Gradient(61, 35, {"R", "G", "ghosts.R", "ghosts.G"});
    shared.planes[0].values[7] = 1e9f;  // saturates
    FlareImage apart = shared;
    for (std::size_t p : {0U, 1U}) {
        shared.planes[p + 2].values = shared.planes[p].values;
        apart.planes[p + 2].values = std::vector<float>(std::as_const(shared.planes[p].values));
    }
    const FlareImage& a = shared;
    ASSERT_EQ(a.planes[0].values.data(), a.planes[2].values.data());
    for (const ExrCompression compression : {ExrCompression::kZip, ExrCompression::kNone}) {
        for (const ExrPixel pixel : {ExrPixel::kHalf, ExrPixel::kFloat}) {
            EXPECT_EQ(Encoded(shared, {compression, pixel}).bytes,
                      Encoded(apart, {compression, pixel}).bytes);
        }
        EXPECT_EQ(Encoded(shared, {compression}).saturated_pixels, 1U);
    }
    ThreadPool threads(2);
    EXPECT_EQ(EncodeHalfPlanes(shared, threads).bytes, EncodeHalfPlanes(apart, threads).bytes);
    // Writing to one leaves the other alone.
    const float before = a.planes[2].values[0];
    shared.planes[0].values[0] = before + 1.0f;
    EXPECT_EQ(a.planes[2].values[0], before);
    EXPECT_EQ(a.planes[0].values[0], before + 1.0f);
}

TEST(EncodeExr, UsesMemoryAgainWhateverItHolds) {
    const FlareImage image = Gradient(61, 35, {"R", "G"});
    ThreadPool threads(2);
    for (const ExrCompression compression : {ExrCompression::kZip, ExrCompression::kNone}) {
        const std::string expected = EncodeExr(image, {compression}, threads).bytes;
        for (const std::size_t size : {0U, 100U, 100'000U}) {
            std::string memory(size, 'x');
            memory.reserve(200'000);
            const char* const at = memory.data();
            const ExrBytes exr = EncodeExr(image, {compression}, threads, std::move(memory));
            EXPECT_EQ(exr.bytes, expected);
            EXPECT_EQ(exr.bytes.data(), at);
        }
    }
    const std::string planes = EncodeHalfPlanes(image, threads).bytes;
    EXPECT_EQ(EncodeHalfPlanes(image, threads, std::string(100'000, 'x')).bytes, planes);
}

TEST(EncodeExr, HalfIsTheNearestHalf) {
    FlareImage image = Gradient(4, 1, {"R"});
    image.planes[0].values = {1.0f, 1.0f / 3.0f, 65503.0f, -2049.0f};
    const std::vector<float> read = ReadChannel(Encoded(image, {}).bytes, "R");
    EXPECT_EQ(read[0], 1.0f);
    EXPECT_EQ(read[1], 1365.0f / 4096.0f);  // 11 significant bits
    EXPECT_EQ(read[2], 65504.0f);
    EXPECT_EQ(read[3], -2048.0f);  // ties to even
}

TEST(EncodeExr, SaturatesAndCountsPixelsNotValues) {
    FlareImage image = Gradient(5, 2, {"R", "G"});
    const float infinity = std::numeric_limits<float>::infinity();
    image.planes[0].values = {65504.0f, 65505.0f, -1e6f, infinity, 1.0f, 0, 0, 0, 0, 0};
    image.planes[1].values = {0.0f, 1e9f, 0.0f, -infinity, 0.0f, 0, 0, 0, 0, 3e38f};

    const ExrBytes half = Encoded(image, {});
    EXPECT_EQ(half.saturated_pixels, 4u);
    const std::vector<float> r = ReadChannel(half.bytes, "R");
    EXPECT_EQ(std::vector<float>(r.begin(), r.begin() + 5),
              (std::vector<float>{65504.0f, 65504.0f, -65504.0f, 65504.0f, 1.0f}));
    EXPECT_EQ(ReadChannel(half.bytes, "G")[9], 65504.0f);

    const ExrBytes full = Encoded(image, {ExrCompression::kZip, ExrPixel::kFloat});
    EXPECT_EQ(full.saturated_pixels, 1u);
    EXPECT_EQ(ReadChannel(full.bytes, "R")[3], std::numeric_limits<float>::max());
    EXPECT_EQ(ReadChannel(full.bytes, "G")[3], -std::numeric_limits<float>::max());
    EXPECT_EQ(ReadChannel(full.bytes, "G")[9], 3e38f);
}

TEST(EncodeExr, HeaderHoldsWindowsAspectChromaticitiesAndAttributes) {
    FlareImage image = Gradient(20, 10, {"R"});
    image.full = {0, 0, 100, 50};
    image.data = {-5, 45, 20, 10};  // overscan
    image.pixel_aspect = 2.0;
    image.text_attributes = {{"lensModel", "Double Gauss 50 mm f/2"}};
    image.number_attributes = {{"aperture", 4.0}, {"focus", 2.5}, {"nominalFocalLength", 50.0}};
    const std::string bytes = Encoded(image, {}).bytes;
    const Imf::Header header = ReadHeader(bytes);
    EXPECT_EQ(header.displayWindow(), Imath::Box2i({0, 0}, {99, 49}));
    EXPECT_EQ(header.dataWindow(), Imath::Box2i({-5, 45}, {14, 54}));
    EXPECT_EQ(header.pixelAspectRatio(), 2.0f);
    EXPECT_EQ(header.typedAttribute<Imf::StringAttribute>("lensModel").value(),
              "Double Gauss 50 mm f/2");
    EXPECT_EQ(header.typedAttribute<Imf::FloatAttribute>("aperture").value(), 4.0f);
    EXPECT_EQ(header.typedAttribute<Imf::FloatAttribute>("focus").value(), 2.5f);
    const Imf::Chromaticities c = Imf::chromaticities(header);
    EXPECT_EQ(c.red, Imath::V2f(0.64f, 0.33f));
    EXPECT_EQ(c.green, Imath::V2f(0.30f, 0.60f));
    EXPECT_EQ(c.blue, Imath::V2f(0.15f, 0.06f));
    EXPECT_EQ(c.white, Imath::V2f(0.3127f, 0.3290f));

    image.rec709 = false;
    EXPECT_FALSE(Imf::hasChromaticities(ReadHeader(Encoded(image, {}).bytes)));
}

// All channels by name, as bits: equal floats may differ in a zero's sign.
std::map<std::string, std::vector<std::uint32_t>> ReadBits(const std::string& bytes) {
    std::map<std::string, std::vector<std::uint32_t>> bits;
    const Imf::Header header = ReadHeader(bytes);
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
        for (const float value : ReadChannel(bytes, c.name())) {
            bits[c.name()].push_back(std::bit_cast<std::uint32_t>(value));
        }
    }
    return bits;
}

// The part of a ZIP file in front of its table of chunks, whose first entry points behind it.
std::string HeaderBytes(const std::string& file, int height) {
    const auto chunks = static_cast<std::uint64_t>((height + 15) / 16);
    for (std::size_t at = 0; at + 8 <= file.size(); ++at) {
        std::uint64_t entry = 0;
        std::memcpy(&entry, file.data() + at, 8);
        if (entry == at + 8 * chunks) return file.substr(0, at);
    }
    ADD_FAILURE() << "no table of chunks";
    return file;
}

void ExpectSameAsLibrary(const FlareImage& image, const std::string& what) {
    for (const ExrPixel pixel : {ExrPixel::kHalf, ExrPixel::kFloat}) {
        const ExrOptions none{ExrCompression::kNone, pixel}, zip{ExrCompression::kZip, pixel};
        const std::string stored = EncodeByLibrary(image, none);
        EXPECT_TRUE(Encoded(image, none).bytes == stored) << what;
        const std::string zipped = Encoded(image, zip).bytes;
        EXPECT_TRUE(ReadBits(zipped) == ReadBits(stored)) << what;
        EXPECT_EQ(HeaderBytes(zipped, image.data.height),
                  HeaderBytes(EncodeByLibrary(image, zip), image.data.height))
            << what;
    }
}

TEST(EncodeExr, PixelsAndHeaderAreThoseOfTheLibraryForAnyShape) {
    const std::pair<int, int> shapes[] = {{1, 1},   {1, 40},  {2, 2},    {3, 5},    {33, 15},
                                          {33, 16}, {33, 17}, {37, 300}, {641, 33}, {16384, 18}};
    for (const auto& [width, height] : shapes) {
        FlareImage image = Gradient(width, height, {"R", "G", "B", "ghosts.R"});
        image.data.x = -7;
        image.data.y = -1000;
        image.pixel_aspect = 2.0;
        image.text_attributes = {{"lensModel", "a lens"}, {"empty", ""}};
        image.number_attributes = {{"aperture", 4.0}, {"of our own", -1e-3}};
        ExpectSameAsLibrary(image, std::to_string(width) + " x " + std::to_string(height));
    }
}

TEST(EncodeExr, PixelsAndHeaderAreThoseOfTheLibraryForManyChannelsAndLongNames) {
    std::vector<std::string> names;
    for (int k = 0; k < 40; ++k) {
        names.push_back("S0." + std::to_string(400 + k) + ",5nm");
        names.push_back("ghosts." + names.back());
    }
    FlareImage image = Gradient(50, 35, names);
    ExpectSameAsLibrary(image, "spectral");
    image.planes[3].name = std::string(200, 'x');
    image.rec709 = false;
    ExpectSameAsLibrary(image, "a long channel");
    image.planes[3].name = "x";
    image.text_attributes = {{std::string(32, 'a'), "32"}};
    ExpectSameAsLibrary(image, "a long attribute");
}

TEST(EncodeExr, NoiseAndBlackAreThoseOfTheLibrary) {
    std::mt19937 random(7);
    FlareImage image = Gradient(517, 70, {"R", "G", "B"});
    for (ImagePlane& plane : image.planes) {
        for (float& value : plane.values) {
            do {
                value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
            } while (std::isnan(value));
        }
    }
    ExpectSameAsLibrary(image, "noise");
    // What does not shrink is stored: 8 bytes of head and 8 of the table a chunk, and the header.
    const ExrOptions exact{ExrCompression::kZip, ExrPixel::kFloat};
    EXPECT_LE(Encoded(image, exact).bytes.size(), 517u * 70 * 3 * 4 + 16 * 5 + 1000);
    // Every second line black.
    for (ImagePlane& plane : image.planes) {
        for (std::size_t i = 0; i < plane.values.size(); ++i) {
            if (i / 517 % 2 == 0) plane.values[i] = 0.0f;
        }
    }
    ExpectSameAsLibrary(image, "striped noise");
    for (ImagePlane& plane : image.planes) {
        std::fill(plane.values.begin(), plane.values.end(), -0.0f);
    }
    ExpectSameAsLibrary(image, "black");
    EXPECT_LT(Encoded(image, {}).bytes.size(), 3000u);
}

TEST(EncodeExr, ALayerThatIsTheWholePictureCostsLittle) {
    FlareImage image = Gradient(1000, 64, {"R", "G", "B"});
    const std::size_t alone = Encoded(image, {}).bytes.size();
    for (std::size_t p = 0; p < 3; ++p) {
        ImagePlane layer = image.planes[p];
        layer.name.insert(0, "ghosts.");
        image.planes.push_back(std::move(layer));
    }
    EXPECT_LT(static_cast<double>(Encoded(image, {}).bytes.size()),
              1.15 * static_cast<double>(alone));
    ExpectSameAsLibrary(image, "root and layer");
}

TEST(EncodeExr, CountsSaturatedPixelsInEveryBand) {
    std::mt19937 random(3);
    FlareImage image = Gradient(611, 100, {"R", "G", "B"});
    std::set<std::size_t> beyond;
    for (int k = 0; k < 300; ++k) {
        const std::size_t pixel = random() % image.data.pixels();
        image.planes[random() % 3].values[pixel] = k % 2 == 0 ? 65504.01f : -1e20f;
        beyond.insert(pixel);
    }
    ThreadPool threads(3);
    EXPECT_EQ(EncodeExr(image, {}, threads).saturated_pixels, beyond.size());
    EXPECT_EQ(EncodeHalfPlanes(image, threads).saturated_pixels, beyond.size());
}

TEST(EncodeExr, BytesDoNotDependOnThreadsOrRuns) {
    const FlareImage image = Gradient(640, 700, {"R", "G", "B", "ghosts.R"});
    for (const ExrCompression compression : {ExrCompression::kZip, ExrCompression::kNone}) {
        const std::string alone = Encoded(image, {compression, ExrPixel::kHalf}).bytes;
        for (const int count : {1, 2, 3, 8}) {
            ThreadPool threads(count);
            for (int run = 0; run < 5; ++run) {
                EXPECT_TRUE(EncodeExr(image, {compression, ExrPixel::kHalf}, threads).bytes ==
                            alone)
                    << count << " threads";
            }
        }
    }
}

}  // namespace
}  // namespace flare
