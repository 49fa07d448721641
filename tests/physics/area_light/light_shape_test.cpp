// SPDX-License-Identifier: Apache-2.0
//
// Lights with the shape of an image against the same image as a sum of points, one for each of its
// pixels, placed here by hand; and parts of a shape against the whole.
#include <gtest/gtest.h>

#include <cmath>

#include "core/render/source_disc.h"
#include "core/render/source_picture.h"
#include "core/tracing/chief_ray.h"
#include "tests/support/crops.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::Studio;

// An F with a grey bar, from the top: neither turned nor mirrored is it the same.
constexpr int kSide = 4;
const std::vector<float> kLetter = {
    1.0F, 1.0F, 1.0F, 0.0F,  //
    1.0F, 0.0F, 0.0F, 0.0F,  //
    1.0F, 0.5F, 0.0F, 0.0F,  //
    1.0F, 0.0F, 0.0F, 0.0F,  //
};

FlareRequest Request(const char* lens, const LightSpec& light, int width, int height) {
    FlareRequest request;
    request.lens = testing::LibraryLens(lens);
    request.f_number = 8.0;
    request.iris = {6, 0.0, 10.0};
    request.image.width = width;
    request.image.height = height;
    request.lights = {light};
    request.quality = QualityPreset::kDraft;
    return request;
}

// Every pixel as so many points a side, at its own angle right and up of the light: arcs through
// the light that begin along the horizon and across it.
std::vector<LightSpec> PointsOf(const LightSpec& light, int a_side) {
    const Vec3d d = light.direction->normalized();
    const Vec3d right = Vec3d(0.0, 1.0, 0.0).cross(d).normalized();
    const Vec3d up = d.cross(right);
    const double pixel = RadiansFromDegrees(light.angular_diameter_deg) / kSide;
    double sum = 0.0;
    for (const float value : kLetter) sum += static_cast<double>(value);
    std::vector<LightSpec> points;
    const int columns = kSide * a_side, rows = columns;
    for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < columns; ++x) {
            const auto n = static_cast<std::size_t>(y / a_side * kSide + x / a_side);
            if (kLetter[n] == 0.0F) continue;
            const double across = ((x + 0.5) / a_side - 0.5 * kSide) * pixel;
            const double above = (0.5 * kSide - (y + 0.5) / a_side) * pixel;
            const double angle = std::hypot(across, above);
            LightSpec point;
            point.direction = d * std::cos(angle);
            if (angle > 0.0)
                *point.direction += (right * across + up * above) * (std::sin(angle) / angle);
            point.distance_m = light.distance_m;
            point.irradiance =
                light.irradiance * (static_cast<double>(kLetter[n]) / (sum * a_side * a_side));
            points.push_back(point);
        }
    }
    return points;
}

LightSpec Letter(double field_deg, double azimuth_deg, double width_deg) {
    LightSpec light = LightAt(field_deg, azimuth_deg);
    light.angular_diameter_deg = width_deg;
    light.shape = SourcePicture::Of(kSide, kSide, kLetter);
    return light;
}

// rel_l1 of the means over blocks of so many pixels.
double Apart(const FlareImage& a, const FlareImage& b, int block) {
    const int width = a.data.width, height = a.data.height;
    double difference = 0.0, sum = 0.0;
    for (std::size_t p = 0; p < 3; ++p) {
        for (int j = 0; j < height; j += block) {
            for (int i = 0; i < width; i += block) {
                double of_a = 0.0, of_b = 0.0;
                for (int k = 0; k < block * block; ++k) {
                    const auto n =
                        static_cast<std::size_t>((j + k / block) * width + i + k % block);
                    of_a += static_cast<double>(a.planes[p].values[n]);
                    of_b += static_cast<double>(b.planes[p].values[n]);
                }
                difference += std::abs(of_a - of_b);
                sum += of_b;
            }
        }
    }
    return difference / sum;
}

double AgainstPoints(Studio& studio, FlareRequest request, int a_side, int block) {
    const FlareImage shape = studio.Shoot(request).image;
    request.lights = PointsOf(request.lights[0], a_side);
    return Apart(shape, studio.Shoot(request).image, block);
}

constexpr const char* kTriplet = "sasian-triplet-50mm-f4";

TEST(LightShape, IsTheSumOfItsPoints) {
    Studio studio;
    FlareRequest request = Request(kTriplet, Letter(6.0, 205.0, 0.6), 60, 40);
    EXPECT_LT(AgainstPoints(studio, request, 1, 1), 0.02);
    request.lights = {Letter(4.0, 70.0, 0.6)};
    request.lights[0].distance_m = 1.5;
    EXPECT_LT(AgainstPoints(studio, request, 1, 1), 0.02);
}

// Ghost (8, 4), nearly focused, shows the letter itself.
TEST(LightShape, IsSeenInAFocusedGhost) {
    Studio studio;
    LightSpec light = Letter(0.0, 0.0, 2.0);
    light.direction = Vec3d(-0.1392, 0.0, 0.9903);
    FlareRequest request = Request(testing::kSeedName, light, 480, 270);
    request.quality = QualityPreset::kPreview;
    for (const BounceSequence& other : TwoReflectionSequences(*request.lens, false)) {
        if (other == BounceSequence{8, 4}) continue;
        ArtistGhost ghost;
        ghost.sequence.assign(other.begin(), other.end());
        ghost.mute = true;
        request.artist.push_back(ghost);
    }
    request.image.crop = {{353 - 24, 135 - 24, 48, 48}};
    EXPECT_LT(AgainstPoints(studio, request, 5, 4), 0.1);
}

TEST(LightShape, KeepsTheLight) {
    Studio studio;
    FlareRequest request = Request(testing::kSeedName, Letter(3.0, 40.0, 1.0), 200, 200);
    request.image.sensor_width_mm = 200.0;
    const double shape = testing::Sum(studio.Shoot(request).image.planes[1]);
    request.lights[0].shape = nullptr;
    request.lights[0].angular_diameter_deg = 0.0;
    const double point = testing::Sum(studio.Shoot(request).image.planes[1]);
    EXPECT_NEAR(shape, point, 0.004 * point);
}

TEST(LightShape, HasTheSameBitsInACropAndOnMoreThreads) {
    FlareRequest request = Request(kTriplet, Letter(6.0, 300.0, 1.5), 90, 61);
    Studio one(1), three(3);
    const FlareImage whole = one.Shoot(request).image;
    EXPECT_EQ(three.Shoot(request).image.planes[0].values, whole.planes[0].values);
    request.image.crop = {{21, 13, 47, 24}};
    const FlareImage crop = three.Shoot(request).image;
    testing::ExpectIsCropOf(whole, crop, *request.image.crop);
}

// However a shape is taken apart, its parts have all of its light, its middle and its width; parts
// that are dark have none.
TEST(LightShape, PartsAddUpToTheWhole) {
    const std::shared_ptr<const Lens> lens = testing::LibraryLens(kTriplet);
    const FlareRequest request = Request(kTriplet, Letter(7.0, 120.0, 2.0), 60, 40);
    const PlacedLight light = *PlaceLight(request, 0);
    const SourceDisc source(*lens, light);
    const Vec3d right = Vec3d(0.0, 1.0, 0.0).cross(light.direction).normalized();
    const Vec3d up = light.direction.cross(right);
    double share = 0.0, moment = 0.0;
    Vec2d mean(0.0);
    for (int k = 0; k < 16; ++k) {
        const SourceSquare part = SourceSquare().Part(k % 4, k / 4, 4);
        if (source.ShareOf(part) == 0.0) continue;
        const PlacedLight of = source.LightOf(part);
        const SourceCell cell = source.CellOf(part, of);
        const Vec2d at(of.direction.dot(right), of.direction.dot(up));
        EXPECT_NEAR(of.share, source.ShareOf(part), 1e-12);
        share += of.share;
        mean += at * of.share;
        moment += (at.dot(at) + cell.xx + cell.yy) * of.share;
    }
    double sum = 0.0, second = 0.0;
    Vec2d first(0.0);
    const double pixel = light.angular_diameter_rad / kSide;
    for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
            const auto value =
                static_cast<double>(kLetter[static_cast<std::size_t>(y * kSide + x)]);
            const Vec2d at((x + 0.5 - 0.5 * kSide) * pixel, (0.5 * kSide - y - 0.5) * pixel);
            sum += value;
            first += at * value;
            second += value * (at.dot(at) + pixel * pixel / 6.0);
        }
    }
    EXPECT_NEAR(share, 1.0, 1e-12);
    EXPECT_NEAR((mean - first / sum).length(), 0.0, 1e-3 * light.angular_diameter_rad);
    EXPECT_NEAR(moment, second / sum, 0.005 * second / sum);
}

// In blocks as large as the shape's pixels, whose points stand in their middles.
TEST(LightShape, OfAStarburstIsTheSumOfItsPoints) {
    Studio studio;
    constexpr int kBlock = 8, kBlocks = 12;
    FlareRequest request =
        Request(testing::kSeedName, Letter(5.0, 130.0, 1.0), kBlock * kBlocks, kBlock * kBlocks);
    request.layers = {false, true, false};
    const double block_mm = RadiansFromDegrees(0.25) * 50.55;
    request.image.sensor_width_mm = kBlocks * block_mm;
    const PlacedLight placed = *PlaceLight(request, 0);
    const PictureMap map = MapOf(request, placed.pose);
    const Vec2d chief =
        FindChiefRay(*request.lens, BundleOf(*request.lens, placed), kLineD)->sensor_mm;
    const Vec2d at = map.offset_px + map.px_per_x * chief.x + map.px_per_y * chief.y;
    const double middle = 0.5 * kBlock * kBlocks;
    request.image.center_offset_mm = Vec2d(middle - at.x, at.y - middle) * (block_mm / kBlock);
    EXPECT_LT(AgainstPoints(studio, request, 1, kBlock), 0.08);
}

TEST(LightShape, ByPhotonsIsTheSumOfItsPoints) {
    FlareRequest request =
        testing::SpectralRequest(testing::LibraryLens(testing::kHeliarName), 4.0, 12, 8);
    request.quality = QualityPreset::kReference;
    request.photon = PhotonSpec{};
    request.photon->samples = 1 << 14;
    request.lights = {Letter(6.0, 30.0, 4.0)};
    Studio studio;
    const FlareImage shape = studio.Shoot(request).image;
    request.photon->samples = 2048;
    request.lights = PointsOf(request.lights[0], 1);
    const FlareImage sum = studio.Shoot(request).image;
    EXPECT_NEAR(testing::Sum(shape.planes[0]) / testing::Sum(sum.planes[0]), 1.0, 0.04);
    EXPECT_LT(testing::RelL1(shape, sum), 0.1);
}

}  // namespace
}  // namespace flare
