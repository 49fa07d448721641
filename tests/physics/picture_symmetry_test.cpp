// SPDX-License-Identifier: Apache-2.0
//
// What must not change a picture, or change it in a known way: mirrors and turns of the light,
// crops and overscan, the number of threads, sums of lights, scaled light, a shifted lens, oblong
// pixels.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::RelL1;
using testing::Studio;

constexpr int kWidth = 240, kHeight = 136;

FlareRequest ColourRequest() {
    FlareRequest request;
    request.lens = testing::BuildLens(testing::SeedLens());
    request.f_number = 4.0;
    request.quality = QualityPreset::kDraft;
    request.image.width = kWidth;
    request.image.height = kHeight;
    request.lights = {LightAt(9.0, 205.0)};
    return request;
}

// At one wavelength: how many are drawn for colour depends on what the frame shows.
FlareRequest MonochromeRequest() {
    FlareRequest request = ColourRequest();
    request.color = ColorMode::kSpectral;
    request.wavelengths_nm = {kLineD};
    return request;
}

// The window (x, y, w, h) of an image, in full-frame pixels.
FlareImage WindowOf(const FlareImage& image, int x, int y, int w, int h) {
    FlareImage out = image;
    out.data = {x, y, w, h};
    for (std::size_t p = 0; p < image.planes.size(); ++p) {
        out.planes[p].values.clear();
        for (int row = y; row < y + h; ++row) {
            const auto from = static_cast<std::ptrdiff_t>(row - image.data.y) * image.data.width +
                              (x - image.data.x);
            const auto begin = image.planes[p].values.begin() + from;
            out.planes[p].values.insert(out.planes[p].values.end(), begin, begin + w);
        }
    }
    return out;
}

FlareImage Mirrored(const FlareImage& image, bool left_right, bool up_down) {
    FlareImage out = image;
    const int w = image.data.width, h = image.data.height;
    for (std::size_t p = 0; p < image.planes.size(); ++p) {
        for (int y = 0; y < h; ++y) {
            for (int x = 0; x < w; ++x) {
                const int from_x = left_right ? w - 1 - x : x;
                const int from_y = up_down ? h - 1 - y : y;
                out.planes[p].values[static_cast<std::size_t>(y * w + x)] =
                    image.planes[p].values[static_cast<std::size_t>(from_y * w + from_x)];
            }
        }
    }
    return out;
}

void ExpectSame(const FlareImage& a, const FlareImage& b, const char* what) {
    ASSERT_EQ(a.planes.size(), b.planes.size());
    for (std::size_t p = 0; p < a.planes.size(); ++p) {
        EXPECT_EQ(a.planes[p].name, b.planes[p].name);
        EXPECT_TRUE(a.planes[p].values == b.planes[p].values) << what << " " << a.planes[p].name;
    }
}

TEST(PictureSymmetry, AMirroredLightGivesTheMirroredPicture) {
    Studio studio;
    FlareRequest request = ColourRequest();
    const Vec3d d(0.13, 0.07, 0.98);
    request.lights[0].direction = d;
    const FlareImage image = studio.Shoot(request).image;
    request.lights[0].direction = Vec3d(-d.x, d.y, d.z);
    EXPECT_LT(RelL1(studio.Shoot(request).image, Mirrored(image, true, false)), 1e-3);
    request.lights[0].direction = Vec3d(d.x, -d.y, d.z);
    EXPECT_LT(RelL1(studio.Shoot(request).image, Mirrored(image, false, true)), 1e-3);
    // Half a turn about the axis turns mesh and picture alike: only rounding is left.
    request.lights[0].direction = Vec3d(-d.x, -d.y, d.z);
    EXPECT_LT(RelL1(studio.Shoot(request).image, Mirrored(image, true, true)), 1e-6);
    // The test can fail: the picture is not symmetric by itself.
    EXPECT_GT(RelL1(image, Mirrored(image, true, false)), 0.1);
}

TEST(PictureSymmetry, ALightOnTheAxisGivesASymmetricPicture) {
    Studio studio;
    FlareRequest request = ColourRequest();
    request.lights = {LightAt(0.0)};
    const FlareImage image = studio.Shoot(request).image;
    EXPECT_LT(RelL1(image, Mirrored(image, true, false)), 1e-3);
    EXPECT_LT(RelL1(image, Mirrored(image, false, true)), 1e-3);
    // A light all but on the axis gives all but that picture.
    request.lights = {LightAt(1e-6)};
    EXPECT_LT(RelL1(studio.Shoot(request).image, image), 1e-3);
}

TEST(PictureSymmetry, ABladedIrisDoesNotTurnWithTheLight) {
    Studio studio;
    FlareRequest request = ColourRequest();
    request.f_number = 8.0;
    request.iris = {5, 0.0, 0.0};
    const FlareImage five = studio.Shoot(request).image;
    request.iris.rotation_deg = 72.0;  // a fifth of a turn: the same opening
    EXPECT_LT(RelL1(studio.Shoot(request).image, five), 1e-5);
    request.iris.rotation_deg = 36.0;
    EXPECT_GT(RelL1(studio.Shoot(request).image, five), 0.01);
    // Corner at +y: mirror-symmetric in x, so mirroring the light mirrors the picture; not so in y.
    request.iris.rotation_deg = 0.0;
    const Vec3d d = *request.lights[0].direction;
    request.lights[0].direction = Vec3d(-d.x, d.y, d.z);
    EXPECT_LT(RelL1(studio.Shoot(request).image, Mirrored(five, true, false)), 2e-3);
    request.lights[0].direction = Vec3d(d.x, -d.y, d.z);
    EXPECT_GT(RelL1(studio.Shoot(request).image, Mirrored(five, false, true)), 0.01);
}

TEST(Window, ACropIsThatPartOfTheFrameToTheBit) {
    Studio studio;
    FlareRequest request = ColourRequest();
    const FlareImage full = studio.Shoot(request).image;
    for (const std::array<int, 4>& crop :
         {std::array<int, 4>{37, 21, 90, 50}, {0, 0, 1, 1}, {200, 100, 40, 36}}) {
        request.image.crop = crop;
        const FlareImage part = studio.Shoot(request).image;
        EXPECT_EQ(part.data, (PixelWindow{crop[0], crop[1], crop[2], crop[3]}));
        EXPECT_EQ(part.full, full.full);
        ExpectSame(part, WindowOf(full, crop[0], crop[1], crop[2], crop[3]), "crop");
    }
}

TEST(Window, OverscanAddsPixelsAndChangesNone) {
    Studio studio;
    FlareRequest request = ColourRequest();
    const FlareImage full = studio.Shoot(request).image;
    request.image.overscan = {30, 7, 0, 19};
    const FlareImage wide = studio.Shoot(request).image;
    EXPECT_EQ(wide.data, (PixelWindow{-30, -7, kWidth + 30, kHeight + 26}));
    ExpectSame(WindowOf(wide, 0, 0, kWidth, kHeight), full, "overscan");
    EXPECT_GT(testing::Sum(wide.planes[1]), testing::Sum(full.planes[1]));
}

TEST(Threads, DoNotChangeOneBit) {
    const FlareRequest request = ColourRequest();
    Studio one(1);
    const Rendering alone = one.Shoot(request);
    for (const int threads : {2, 4}) {
        Studio studio(threads);
        const Rendering rendering = studio.Shoot(request);
        ExpectSame(rendering.image, alone.image, "threads");
        EXPECT_EQ(rendering.report.work.rays_traced, alone.report.work.rays_traced);
        EXPECT_EQ(rendering.report.facts.ghosts.size(), alone.report.facts.ghosts.size());
    }
}

TEST(Superposition, TwoLightsAreTheSumOfEach) {
    Studio studio;
    FlareRequest request = ColourRequest();
    LightSpec first = LightAt(9.0, 205.0), second = LightAt(4.0, 70.0);
    first.irradiance = Vec3d(2.0, 1.0, 0.3);
    second.distance_m = 1.5;
    request.lights = {first};
    FlareImage sum = studio.Shoot(request).image;
    request.lights = {second};
    const FlareImage other = studio.Shoot(request).image;
    for (std::size_t p = 0; p < sum.planes.size(); ++p) {
        for (std::size_t i = 0; i < sum.planes[p].values.size(); ++i) {
            sum.planes[p].values[i] += other.planes[p].values[i];
        }
    }
    request.lights = {first, second};
    EXPECT_LT(RelL1(studio.Shoot(request).image, sum), 1e-6);
}

TEST(Superposition, ScaledLightScalesThePicture) {
    Studio studio;
    FlareRequest request = ColourRequest();
    const FlareImage one = studio.Shoot(request).image;
    std::vector<double> mean;
    for (const ImagePlane& plane : one.planes) {
        mean.push_back(testing::Sum(plane) / static_cast<double>(plane.values.size()));
    }
    for (const double k : {0.0, 1e-20, 0.5, 1e12}) {
        request.lights[0].irradiance = Vec3d(k, k, k);
        FlareImage scaled = studio.Shoot(request).image;
        for (std::size_t p = 0; p < one.planes.size(); ++p) {
            for (std::size_t i = 0; i < one.planes[p].values.size(); ++i) {
                const double want = k * one.planes[p].values[i];
                // Colours are sums of floats that may cancel.
                ASSERT_NEAR(scaled.planes[p].values[i], want, 2e-6 * (std::abs(want) + k * mean[p]))
                    << k;
            }
        }
    }
}

TEST(Frame, ACentreOffsetShiftsThePicture) {
    Studio studio;
    FlareRequest request = MonochromeRequest();
    // The light on the frame decides what is culled, and the shifted frame is another one.
    request.model.culling = CullingRule::kNone;
    const FlareImage centred = studio.Shoot(request).image;
    // 0.15 mm a pixel: 12 pixels right and 8 up.
    request.image.center_offset_mm = {12 * 0.15, 8 * 0.15};
    const FlareImage shifted = studio.Shoot(request).image;
    const FlareImage expected = WindowOf(centred, 0, 8, kWidth - 12, kHeight - 8);
    FlareImage got = WindowOf(shifted, 12, 0, kWidth - 12, kHeight - 8);
    got.data = expected.data;
    EXPECT_LT(RelL1(got, expected), 1e-6);
}

TEST(Frame, OblongPixelsHoldTheSameLight) {
    Studio studio;
    FlareRequest request = MonochromeRequest();
    // A draft's pieces are cut for the pixels at hand: 1.3 % apart here.
    request.quality = QualityPreset::kFinal;
    const FlareImage square = studio.Shoot(request).image;
    // Twice as wide as high, on a frame of the same size in mm: rows come in pairs.
    request.image.height = 2 * kHeight;
    request.image.pixel_aspect = 2.0;
    const FlareImage oblong = studio.Shoot(request).image;
    EXPECT_EQ(oblong.pixel_aspect, 2.0);
    FlareImage folded = square;
    for (std::size_t p = 0; p < square.planes.size(); ++p) {
        for (std::size_t y = 0; y < kHeight; ++y) {
            for (std::size_t x = 0; x < kWidth; ++x) {
                folded.planes[p].values[y * kWidth + x] =
                    0.5F * (oblong.planes[p].values[2 * y * kWidth + x] +
                            oblong.planes[p].values[(2 * y + 1) * kWidth + x]);
            }
        }
    }
    EXPECT_LT(RelL1(folded, square), 2e-3);
}

}  // namespace
}  // namespace flare
