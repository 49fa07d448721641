// SPDX-License-Identifier: Apache-2.0
//
// DecodeExr reads what OpenEXR's own classes write, and gives a reason for whatever else it is fed.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <random>

#include "core/image/exr.h"
#include "tests/unit/exr/exr_samples.h"

namespace flare {
namespace {

constexpr int kWidth = 50, kHeight = 40;

Imf::Header SmallHeader() {
    Imf::Header header(kWidth, kHeight);
    header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
    return header;
}

std::vector<float> SmallPlane() {
    return Gradient(kWidth, kHeight, {"Z"}).planes[0].values;
}

Imf::FrameBuffer FrameOf(std::vector<float>& plane) {
    Imf::FrameBuffer frame;
    frame.insert("Z", Imf::Slice::Make(Imf::FLOAT, plane.data(), {0, 0}, kWidth, kHeight));
    return frame;
}

std::string ScanLineFile(Imf::Compression compression) {
    std::vector<float> plane = SmallPlane();
    Imf::Header header = SmallHeader();
    header.compression() = compression;
    Imf::StdOSStream stream;
    {
        Imf::OutputFile file(stream, header);
        file.setFrameBuffer(FrameOf(plane));
        file.writePixels(kHeight);
    }
    return stream.str();
}

std::string TiledFile(Imf::LevelMode mode) {
    std::vector<float> plane = SmallPlane();
    Imf::Header header = SmallHeader();
    header.setTileDescription({16, 16, mode});
    Imf::StdOSStream stream;
    {
        Imf::TiledOutputFile file(stream, header);
        file.setFrameBuffer(FrameOf(plane));
        for (int level = 0; level < file.numLevels(); ++level) {
            file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
        }
    }
    return stream.str();
}

std::string Refusal(std::string_view bytes) {
    const Result<FlareImage> image = DecodeExr(bytes);
    EXPECT_FALSE(image.ok());
    if (image.ok()) return "";
    EXPECT_EQ(image.error().code, "bad_image");
    return image.error().message;
}

// Overwrites the value of a header attribute, found by its name, type and size.
std::string Forged(std::string bytes, const std::string& name, const std::string& type,
                   std::ptrdiff_t offset, std::int32_t value) {
    const std::string key = name + '\0' + type + '\0';
    const std::size_t at = bytes.find(key);
    EXPECT_NE(at, std::string::npos);
    const auto to = static_cast<std::ptrdiff_t>(at + key.size() + 4) + offset;
    std::memcpy(bytes.data() + to, &value, sizeof value);
    return bytes;
}

TEST(DecodeExr, GivesBackWhatEncodeExrWrote) {
    FlareImage image = Gradient(33, 47, {"B", "G", "R", "ghosts.S0.587,5618nm"});
    image.full = {0, 0, 40, 50};
    image.data = {-3, 7, 33, 47};
    image.pixel_aspect = 1.5;
    image.text_attributes = {{"lensModel", "x"}};
    image.number_attributes = {{"aperture", 4.0}, {"focus", 2.5}};
    ThreadPool threads(2);
    const Result<FlareImage> read =
        DecodeExr(EncodeExr(image, {ExrCompression::kZip, ExrPixel::kFloat}, threads).bytes);
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->full, image.full);
    EXPECT_EQ(read->data, image.data);
    EXPECT_EQ(read->pixel_aspect, 1.5);
    EXPECT_TRUE(read->rec709);
    EXPECT_EQ(read->text_attributes, image.text_attributes);
    EXPECT_EQ(read->number_attributes, image.number_attributes);
    ASSERT_EQ(read->planes.size(), image.planes.size());
    for (std::size_t p = 0; p < image.planes.size(); ++p) {
        EXPECT_EQ(read->planes[p].name, image.planes[p].name);
        EXPECT_EQ(read->planes[p].values, image.planes[p].values);
    }
}

TEST(DecodeExr, GivesBackOtherPrimaries) {
    FlareImage image;
    image.full = image.data = {0, 0, 2, 1};
    image.planes = {{"R", std::vector<float>{1.0f, 2.0f}}};
    image.rec709 = false;
    ThreadPool threads(1);
    const auto read = [&] { return DecodeExr(EncodeExr(image, {}, threads).bytes); };
    EXPECT_FALSE(read()->rec709);
    EXPECT_FALSE(read()->chromaticities);
    image.chromaticities = Ap1Chromaticities();
    const Result<FlareImage> wide = read();
    EXPECT_FALSE(wide->rec709);
    ASSERT_TRUE(wide->chromaticities);
    EXPECT_NEAR(wide->chromaticities->green.y, 0.830, 1e-6);
    EXPECT_NEAR(wide->chromaticities->white.x, 0.32168, 1e-6);
}

TEST(DecodeExr, ReadsEveryLosslessCompressionAndTiles) {
    const std::vector<float> plane = SmallPlane();
    std::vector<std::string> files;
    for (const Imf::Compression c :
         {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION, Imf::ZIP_COMPRESSION,
          Imf::PIZ_COMPRESSION}) {
        files.push_back(ScanLineFile(c));
    }
    files.push_back(TiledFile(Imf::ONE_LEVEL));
    files.push_back(TiledFile(Imf::MIPMAP_LEVELS));
    for (const std::string& file : files) {
        const Result<FlareImage> image = DecodeExr(file);
        ASSERT_TRUE(image.ok()) << image.error().message;
        ASSERT_EQ(image->planes.size(), 1u);
        EXPECT_EQ(image->planes[0].values, plane);
    }
}

TEST(DecodeExr, ConvertsUnsignedIntegers) {
    std::vector<unsigned> ids = {0, 1, 7, 1u << 20};
    Imf::Header header(4, 1);
    header.channels().insert("id", Imf::Channel(Imf::UINT));
    header.insert("take", Imf::IntAttribute(3));
    Imf::StdOSStream stream;
    {
        Imf::OutputFile file(stream, header);
        Imf::FrameBuffer frame;
        frame.insert("id", Imf::Slice::Make(Imf::UINT, ids.data(), {0, 0}, 4, 1));
        file.setFrameBuffer(frame);
        file.writePixels(1);
    }
    const Result<FlareImage> image = DecodeExr(stream.str());
    ASSERT_TRUE(image.ok()) << image.error().message;
    EXPECT_EQ(image->planes[0].values, (std::vector<float>{0.0f, 1.0f, 7.0f, 1048576.0f}));
    EXPECT_FALSE(image->rec709);
    ASSERT_EQ(image->number_attributes.size(), 1u);
    EXPECT_EQ(image->number_attributes[0], (std::pair<std::string, double>{"take", 3.0}));
}

TEST(DecodeExr, RefusesWhatIsNoSinglePartImage) {
    EXPECT_NE(Refusal("").find("no OpenEXR"), std::string::npos);
    EXPECT_NE(Refusal("GIF89a").find("no OpenEXR"), std::string::npos);

    Imf::Header header = SmallHeader();
    header.setType(Imf::SCANLINEIMAGE);
    header.setName("a");
    Imf::Header headers[] = {header, header};
    headers[1].setName("b");
    Imf::StdOSStream stream;
    std::vector<float> plane = SmallPlane();
    {
        Imf::MultiPartOutputFile file(stream, headers, 2);
        for (int part = 0; part < 2; ++part) {
            Imf::OutputPart out(file, part);
            out.setFrameBuffer(FrameOf(plane));
            out.writePixels(kHeight);
        }
    }
    EXPECT_NE(Refusal(stream.str()).find("single-part"), std::string::npos);
}

TEST(DecodeExr, RefusesSubsampledChannels) {
    Imf::Header header(4, 4);
    header.channels().insert("RY", Imf::Channel(Imf::FLOAT, 2, 2));
    std::vector<float> plane(4, 1.0f);
    Imf::StdOSStream stream;
    {
        Imf::OutputFile file(stream, header);
        Imf::FrameBuffer frame;
        frame.insert("RY", Imf::Slice::Make(Imf::FLOAT, plane.data(), {0, 0}, 4, 4, 0, 0, 2, 2));
        file.setFrameBuffer(frame);
        file.writePixels(4);
    }
    EXPECT_NE(Refusal(stream.str()).find("subsampled"), std::string::npos);
}

TEST(DecodeExr, RefusesHugeClaimsBeforeMemoryIsTaken) {
    const std::string lines = ScanLineFile(Imf::ZIP_COMPRESSION);
    const std::string tiles = TiledFile(Imf::ONE_LEVEL);
    for (const std::ptrdiff_t corner : {8, 12}) {
        EXPECT_NE(Refusal(Forged(lines, "dataWindow", "box2i", corner, INT32_MAX)).find("limit"),
                  std::string::npos);
        EXPECT_NE(Refusal(Forged(tiles, "dataWindow", "box2i", corner, 1 << 28)).find("limit"),
                  std::string::npos);
    }
    Refusal(Forged(lines, "dataWindow", "box2i", 0, INT32_MIN));
    Refusal(Forged(lines, "dataWindow", "box2i", 8, -1));
    EXPECT_NE(Refusal(Forged(tiles, "tiles", "tiledesc", 0, INT32_MAX)).find("too large"),
              std::string::npos);
    EXPECT_NE(Refusal(Forged(lines, "channels", "chlist", -4, INT32_MAX)).find("past the end"),
              std::string::npos);
}

TEST(DecodeExr, RefusesEveryTruncation) {
    for (const std::string& file :
         {ScanLineFile(Imf::ZIP_COMPRESSION), TiledFile(Imf::ONE_LEVEL)}) {
        for (std::size_t size = 0; size < file.size(); size += size < 600 ? 1 : 97) {
            EXPECT_FALSE(DecodeExr(std::string_view(file).substr(0, size)).ok()) << size;
        }
    }
}

// Whatever bytes come, there is an answer: a picture or a reason.
TEST(DecodeExr, AnswersToDamagedFiles) {
    std::mt19937 random(1);
    int refused = 0;
    for (const std::string& file :
         {ScanLineFile(Imf::ZIP_COMPRESSION), ScanLineFile(Imf::PIZ_COMPRESSION),
          ScanLineFile(Imf::RLE_COMPRESSION), TiledFile(Imf::MIPMAP_LEVELS)}) {
        for (int round = 0; round < 500; ++round) {
            std::string damaged = file;
            // Half of the damage falls into the header, where it does the most.
            const std::size_t reach =
                round % 2 == 0 ? std::min<std::size_t>(file.size(), 500) : file.size();
            for (int k = 0; k <= round % 4; ++k) {
                damaged[random() % reach] = static_cast<char>(random());
            }
            const Result<FlareImage> image = DecodeExr(damaged);
            if (!image.ok()) {
                ++refused;
                EXPECT_EQ(image.error().code, "bad_image");
                continue;
            }
            for (const ImagePlane& plane : image->planes) {
                EXPECT_EQ(plane.values.size(), image->data.pixels());
            }
        }
    }
    EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace flare
