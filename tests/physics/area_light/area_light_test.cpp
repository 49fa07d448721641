// SPDX-License-Identifier: Apache-2.0
//
// Ghosts of lights that are discs against the same disc as a sum of points, against first-order
// optics, and against themselves: crops, threads, energy, no sudden change.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/render/ghost_motion.h"
#include "core/render/source_disc.h"
#include "core/tracing/paraxial_ghost.h"
#include "tests/support/crops.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::Studio;

FlareRequest Colour(const char* lens, double field_deg, int width, int height) {
    FlareRequest request;
    request.lens = testing::LibraryLens(lens);
    request.f_number = 8.0;
    request.iris = {6, 0.0, 10.0};
    request.image.width = width;
    request.image.height = height;
    request.lights = {LightAt(field_deg, 205.0)};
    request.quality = QualityPreset::kDraft;
    return request;
}

// The light's disc as points of equal solid angle: rings of equal width, each with points in
// proportion to its area.
std::vector<LightSpec> PointsOf(const LightSpec& light, int rings) {
    const Vec3d middle = light.direction->normalized();
    const Vec3d e1 = middle.cross(Vec3d(0.0, 1.0, 0.0)).normalized();
    const Vec3d e2 = middle.cross(e1);
    const double radius = RadiansFromDegrees(0.5 * light.angular_diameter_deg);
    std::vector<LightSpec> points;
    for (int ring = 0; ring < rings; ++ring) {
        const int count = 3 * (2 * ring + 1);
        // The mean radius of the ring's area.
        const double inner = static_cast<double>(ring) / rings;
        const double outer = (ring + 1.0) / rings;
        const double at = radius * std::sqrt(0.5 * (inner * inner + outer * outer));
        for (int k = 0; k < count; ++k) {
            const double angle = 2.0 * kPi * (k + 0.37 * ring) / count;
            LightSpec point = light;
            point.angular_diameter_deg = 0.0;
            point.direction = middle * std::cos(at) +
                              (e1 * std::cos(angle) + e2 * std::sin(angle)) * std::sin(at);
            point.irradiance *= 1.0 / (3.0 * rings * rings);
            points.push_back(point);
        }
    }
    return points;
}

double AgainstPoints(Studio& studio, FlareRequest request, double diameter_deg, int rings) {
    request.lights[0].angular_diameter_deg = diameter_deg;
    const Rendering disc = studio.Shoot(request);
    request.lights = PointsOf(request.lights[0], rings);
    const Rendering points = studio.Shoot(request);
    return testing::RelL1(disc.image, points.image);
}

constexpr const char* kTriplet = "sasian-triplet-50mm-f4";

TEST(AreaLight, IsTheSumOfItsPoints) {
    Studio studio;
    EXPECT_LT(AgainstPoints(studio, Colour(kTriplet, 0.0, 90, 60), 0.53, 3), 0.02);
    EXPECT_LT(AgainstPoints(studio, Colour(kTriplet, 14.0, 90, 60), 2.0, 2), 0.06);
}

TEST(AreaLight, IsTheSumOfItsPointsForPolygonsAlone) {
    Studio studio;
    FlareRequest request = Colour(kTriplet, 5.0, 60, 40);
    request.color = ColorMode::kSpectral;
    request.wavelengths_nm = {550.0};
    EXPECT_LT(AgainstPoints(studio, request, 1.0, 2), 0.03);
}

TEST(AreaLight, NearbyIsTheSumOfItsPoints) {
    Studio studio;
    FlareRequest request = Colour(kTriplet, 4.0, 90, 60);
    request.lights[0].distance_m = 1.5;
    EXPECT_LT(AgainstPoints(studio, request, 0.8, 2), 0.03);
}

// A ghost that passes the stop once, near the axis, through a small stop: at a fixed stop point
// x = B - A B1 / A1 a radian, with A, B to the sensor and A1, B1 to the stop.
TEST(AreaLight, MovesGhostsAsFirstOrderOpticsSays) {
    const std::shared_ptr<const Lens> lens = testing::LibraryLens(testing::kSeedName);
    const BounceSequence sequence{10, 9};
    const ParaxialPath path = ParaxialPathOf(WriteOut(*lens, sequence, kLineD));
    ASSERT_EQ(path.front_to_stop.size(), 1U);
    const Abcd& stop = path.front_to_stop[0];
    const double exact = path.front_to_sensor.b - path.front_to_sensor.a * stop.b / stop.a;

    ThreadPool threads(1);
    const Iris iris({}, 0.15, 20.0);
    const TransmissionTables tables(*lens, {kLineD}, threads);
    const LightBundle bundle(*lens, 0.0, 0.0);
    const CanonicalPose pose = PoseOf(*lens, 0.0);
    SampleScene scene{*lens, bundle, pose, iris, tables, {1.0}, PictureMap(), 1.0, 1.0};
    const GhostSample sample = SampleGhost(scene, sequence);
    ASSERT_GT(sample.flux_mm2, 0.0);
    const GhostMotion motion = MotionOf(scene, sequence, sample.region, 0.002);
    ASSERT_TRUE(motion.known);
    EXPECT_NEAR(motion.along_u.x, exact, 0.01 * std::abs(exact));
    EXPECT_NEAR(motion.along_v.y, exact, 0.01 * std::abs(exact));
    EXPECT_NEAR(motion.along_u.y, 0.0, 0.01 * std::abs(exact));
    EXPECT_NEAR(motion.along_v.x, 0.0, 0.01 * std::abs(exact));
    EXPECT_LT(motion.error, 0.01);
    // At a fixed point of the front it would be B.
    EXPECT_GT(std::abs(exact - path.front_to_sensor.b), 0.5 * std::abs(exact));
}

TEST(AreaLight, HasTheSameBitsInACropAndOnMoreThreads) {
    for (const bool polygons : {false, true}) {
        FlareRequest request = Colour(kTriplet, 6.0, 150, 101);
        if (polygons) {
            request.color = ColorMode::kSpectral;
            request.wavelengths_nm = {550.0};
        }
        request.lights[0].angular_diameter_deg = 1.5;
        Studio one(1), three(3);
        const FlareImage whole = one.Shoot(request).image;
        EXPECT_EQ(three.Shoot(request).image.planes[0].values, whole.planes[0].values);
        request.image.crop = {{41, 23, 57, 44}};
        const FlareImage crop = three.Shoot(request).image;
        SCOPED_TRACE(polygons);
        testing::ExpectIsCropOf(whole, crop, *request.image.crop);
    }
}

// However a disc is taken apart, its parts have all of its light, its middle and its width: a
// quarter of the radius squared along each axis.
TEST(AreaLight, PartsOfADiscAddUpToIt) {
    const std::shared_ptr<const Lens> lens = testing::LibraryLens(kTriplet);
    FlareRequest request = Colour(kTriplet, 7.0, 60, 40);
    request.lights[0].angular_diameter_deg = 2.0;
    const PlacedLight light = *PlaceLight(request, 0);
    const SourceDisc disc(*lens, light);
    const double radius = 0.5 * light.angular_diameter_rad;
    const Vec3d e1 = light.direction.cross(Vec3d(0.0, 1.0, 0.0)).normalized();
    const Vec3d e2 = light.direction.cross(e1);
    std::vector<SourceSquare> parts;
    for (int k = 0; k < 9; ++k) parts.push_back(SourceSquare().Part(k % 3, k / 3, 3));
    // The first of them once more in parts.
    for (int k = 0; k < 4; ++k) parts.push_back(parts[0].Part(k % 2, k / 2, 2));
    parts.erase(parts.begin());
    double share = 0.0, moment = 0.0;
    Vec2d mean(0.0);
    for (const SourceSquare& part : parts) {
        const PlacedLight of = disc.LightOf(part);
        const SourceCell cell = disc.CellOf(part, of);
        const Vec2d at(of.direction.dot(e1), of.direction.dot(e2));
        EXPECT_NEAR(of.share, part.share(), 1e-12);
        share += of.share;
        mean += at * of.share;
        moment += (at.dot(at) + cell.xx + cell.yy) * of.share;
    }
    EXPECT_NEAR(share, 1.0, 1e-12);
    EXPECT_NEAR(mean.length(), 0.0, 1e-3 * radius);
    EXPECT_NEAR(moment, 0.5 * radius * radius, 0.005 * radius * radius);
}

// Ghost (8, 4), all but focused, is a disc of 56 pixels on a frame of 960: no part of the source
// leaves a gap, nor does the light change faster across it than its motion does.
TEST(AreaLight, HasNoSeamsInAFocusedGhost) {
    Studio studio;
    FlareRequest request = Colour(testing::kSeedName, 0.0, 960, 540);
    request.quality = QualityPreset::kPreview;
    request.lights[0].direction = Vec3d(-0.1392, 0.0, 0.9903);
    request.lights[0].angular_diameter_deg = 2.0;
    for (const BounceSequence& other : TwoReflectionSequences(*request.lens, false)) {
        if (other == BounceSequence{8, 4}) continue;
        ArtistGhost ghost;
        ghost.sequence.assign(other.begin(), other.end());
        ghost.mute = true;
        request.artist.push_back(ghost);
    }
    constexpr int kSide = 30;
    request.image.crop = {{706 - kSide / 2, 270 - kSide / 2, kSide, kSide}};
    const FlareImage image = studio.Shoot(request).image;
    const auto [least, most] =
        std::minmax_element(image.planes[2].values.begin(), image.planes[2].values.end());
    EXPECT_GT(*least, 0.0F);
    EXPECT_LT(*most, 1.25F * *least);
}

// On a frame so wide that nothing leaves it, blurring moves light and keeps it.
TEST(AreaLight, KeepsTheLight) {
    Studio studio;
    FlareRequest request = Colour(testing::kSeedName, 3.0, 200, 200);
    request.image.sensor_width_mm = 200.0;
    const double point = testing::Sum(studio.Shoot(request).image.planes[1]);
    request.lights[0].angular_diameter_deg = 1.0;
    const Rendering disc = studio.Shoot(request);
    EXPECT_NEAR(testing::Sum(disc.image.planes[1]), point, 0.003 * point);
    int blurred = 0;
    for (const GhostFacts& ghost : disc.report.facts.ghosts) blurred += ghost.source_directions > 0;
    EXPECT_GT(blurred, 5);
    EXPECT_GT(disc.report.facts.estimated_error.source, 0.0);
}

// From a point to a disc of 1 degree: no step changes the picture by more than its share.
TEST(AreaLight, GrowsWithoutAJump) {
    Studio studio;
    FlareRequest request = Colour(kTriplet, 5.0, 160, 90);
    FlareImage before = studio.Shoot(request).image;
    request.lights[0].angular_diameter_deg = 1e-4;
    EXPECT_LT(testing::RelL1(studio.Shoot(request).image, before), 1e-4);
    double diameter_deg = 0.02;
    for (int step = 0; step < 8; ++step, diameter_deg *= 1.6) {
        request.lights[0].angular_diameter_deg = diameter_deg;
        const FlareImage image = studio.Shoot(request).image;
        EXPECT_LT(testing::RelL1(image, before), 0.04) << diameter_deg;
        before = image;
    }
}

}  // namespace
}  // namespace flare
