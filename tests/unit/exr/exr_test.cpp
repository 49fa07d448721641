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

#include <cmath>
#include <limits>

#include "tests/unit/exr/exr_samples.h"

namespace flare {
namespace {

// One channel of an EXR as floats, read by OpenEXR over the header's data window.
std::vector<float> ReadChannel(const std::string& bytes, const std::string& name) {
    Imf::StdISStream stream;
    stream.str(bytes);
    Imf::InputFile file(stream);
    const Imath::Box2i box = file.header().dataWindow();
    const int width = box.max.x - box.min.x + 1, height = box.max.y - box.min.y + 1;
    std::vector<float> values(static_cast<std::size_t>(width * height));
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
        const std::string bytes = EncodeExr(image, {compression, ExrPixel::kFloat}).bytes;
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

TEST(EncodeExr, HalfIsTheNearestHalf) {
    FlareImage image = Gradient(4, 1, {"R"});
    image.planes[0].values = {1.0f, 1.0f / 3.0f, 65503.0f, -2049.0f};
    const std::vector<float> read = ReadChannel(EncodeExr(image, {}).bytes, "R");
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

    const ExrBytes half = EncodeExr(image, {});
    EXPECT_EQ(half.saturated_pixels, 4u);
    const std::vector<float> r = ReadChannel(half.bytes, "R");
    EXPECT_EQ(std::vector<float>(r.begin(), r.begin() + 5),
              (std::vector<float>{65504.0f, 65504.0f, -65504.0f, 65504.0f, 1.0f}));
    EXPECT_EQ(ReadChannel(half.bytes, "G")[9], 65504.0f);

    const ExrBytes full = EncodeExr(image, {ExrCompression::kZip, ExrPixel::kFloat});
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
    const std::string bytes = EncodeExr(image, {}).bytes;
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
    EXPECT_FALSE(Imf::hasChromaticities(ReadHeader(EncodeExr(image, {}).bytes)));
}

TEST(EncodeExr, BytesDoNotDependOnThreadsOrRuns) {
    const FlareImage image = Gradient(640, 700, {"R", "G", "B", "ghosts.R"});
    SetExrThreads(0);
    const std::string alone = EncodeExr(image, {}).bytes;
    EXPECT_EQ(EncodeExr(image, {}).bytes, alone);
    for (const int threads : {1, 2, 4}) {
        SetExrThreads(threads);
        EXPECT_EQ(EncodeExr(image, {}).bytes, alone) << threads << " threads";
    }
    SetExrThreads(0);
}

}  // namespace
}  // namespace flare
