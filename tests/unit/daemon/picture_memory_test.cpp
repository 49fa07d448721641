// SPDX-License-Identifier: Apache-2.0
#include "server/picture_memory.h"

#include <gtest/gtest.h>

namespace flare {
namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;

wire::FlareRequest Sized(int width, int height) {
    wire::FlareRequest request;
    request.image.width = width;
    request.image.height = height;
    return request;
}

TEST(PictureMemory, GrowsWithPixelsAndChannels) {
    const std::uint64_t hd = PictureBytes(Sized(1920, 1080));
    // Three channels, each at least a double and two floats a pixel.
    EXPECT_GE(hd, 1920ULL * 1080 * 3 * 16);
    EXPECT_LE(hd, 512 * kMiB);
    wire::FlareRequest spectral = Sized(1920, 1080);
    spectral.color_space = wire::ColorSpace::kSpectral;
    spectral.wavelengths_nm.assign(30, 550.0);
    EXPECT_GE(PictureBytes(spectral), 9 * hd);
}

TEST(PictureMemory, ReckonsWithWhatIsDrawn) {
    wire::FlareRequest crop = Sized(16'384, 4'096);
    crop.image.crop = {{0, 0, 10, 10}};
    EXPECT_LT(PictureBytes(crop), 20 * kMiB);
    wire::FlareRequest overscan = Sized(1'000, 1'000);
    overscan.image.overscan = {500, 500, 500, 500};
    EXPECT_EQ(PictureBytes(overscan), PictureBytes(Sized(2'000, 2'000)));
}

TEST(PictureMemory, TheStarburstTakesMore) {
    wire::FlareRequest request = Sized(1920, 1080);
    const std::uint64_t ghosts = PictureBytes(request);
    request.layers.starburst = true;
    // A double and a float a sample, and a transform of 2048 x 2048 complex doubles twice over.
    EXPECT_GE(PictureBytes(request), ghosts + 1920ULL * 1080 * 3 * 12 + 128 * kMiB);
}

TEST(PictureMemory, BokehAndSplitLayersTakeMore) {
    wire::FlareRequest request = Sized(1920, 1080);
    const std::uint64_t samples = 1920ULL * 1080 * 3;
    const std::uint64_t ghosts = PictureBytes(request);
    request.layers.bokeh = true;
    EXPECT_GE(PictureBytes(request), ghosts + samples * 12);
    request.layers.bokeh = false;
    request.split = wire::Split::kLight;
    request.lights.resize(5);
    EXPECT_GE(PictureBytes(request), ghosts + 5 * samples * 4);
    EXPECT_LE(PictureBytes(request), ghosts + 15 * samples * 8);
    // How many ghosts the lens has is not known: 2^27 pixels of layers at most.
    request.split = wire::Split::kGhost;
    EXPECT_GE(PictureBytes(request), ghosts + 64 * samples * 4);
    request = Sized(64, 64);
    request.split = wire::Split::kGhost;
    EXPECT_LE(PictureBytes(request), std::uint64_t{64} * kMiB);
}

TEST(PictureMemory, TheLargestPictureDoesNotOverflow) {
    wire::FlareRequest request = Sized(16'384, 4'096);
    request.color_space = wire::ColorSpace::kSpectral;
    request.wavelengths_nm.assign(1'000, 550.0);
    EXPECT_GT(PictureBytes(request), std::uint64_t{1} << 40);
}

TEST(PictureMemory, ABodyThatIsNoRequestTakesNone) {
    EXPECT_EQ(PictureBytesOfBody("{"), 0U);
    EXPECT_GT(PictureBytesOfBody(R"({"lens":"x","image":{"width":8,"height":8,
        "sensor_width_mm":36},"lights":[]})"),
              0U);
}

}  // namespace
}  // namespace flare
