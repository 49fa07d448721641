// SPDX-License-Identifier: Apache-2.0
#include "core/render/lights.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"
#include "tests/support/lenses.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

FlareRequest RequestWith(const LightSpec& light) {
    FlareRequest request;
    request.lens = testing::BuildLens(testing::SeedLens());
    request.image.width = 360;
    request.image.height = 200;
    request.lights = {light};
    return request;
}

LightSpec Towards(double x, double y, double z) {
    LightSpec light;
    light.direction = Vec3d(x, y, z);
    return light;
}

TEST(PlacedLight, TurnsTheCanonicalLightIntoPlace) {
    for (const Vec3d& d : {Vec3d(0.1, 0.0, 1.0), Vec3d(-0.1, 0.2, 1.0), Vec3d(0.3, -0.2, -0.5)}) {
        const auto light = PlaceLight(RequestWith(Towards(d.x, d.y, d.z)), 0);
        ASSERT_TRUE(light.ok());
        // The canonical light travels along (sin f, 0, cos f); turned by the azimuth it must travel
        // along (-x, -y, z) of the direction.
        const Vec3d n = d.normalized();
        const Vec2d across = light->pose.LensSpace({std::sin(light->field_rad), 0.0});
        EXPECT_NEAR(across.x, -n.x, 1e-12);
        EXPECT_NEAR(across.y, -n.y, 1e-12);
        EXPECT_NEAR(std::cos(light->field_rad), n.z, 1e-12);
        EXPECT_EQ(light->inverse_distance, 0.0);
    }
}

TEST(PlacedLight, DoesNotCareForTheDirectionsLength) {
    const auto one = PlaceLight(RequestWith(Towards(0.1, 0.2, 1.0)), 0);
    for (const double k : {1e-300, 1e-5, 1e5, 1e300}) {
        const auto other = PlaceLight(RequestWith(Towards(0.1 * k, 0.2 * k, k)), 0);
        ASSERT_TRUE(other.ok());
        EXPECT_EQ(other->field_rad, one->field_rad);
        EXPECT_NEAR(other->pose.x_axis.x, one->pose.x_axis.x, 1e-14);
        EXPECT_NEAR(other->pose.x_axis.y, one->pose.x_axis.y, 1e-14);
    }
}

TEST(PlacedLight, KeepsMetresAsMillimetres) {
    LightSpec spec = Towards(0.0, 0.0, 1.0);
    spec.distance_m = 2.5;
    EXPECT_NEAR(PlaceLight(RequestWith(spec), 0)->inverse_distance, 1.0 / 2500.0, 1e-18);
}

TEST(PictureMap, PutsTheImageUprightAndTheAxisWhereTheOffsetSays) {
    FlareRequest request = RequestWith(Towards(0.0, 0.0, 1.0));
    ImageSpec& image = request.image;
    image.sensor_width_mm = 36.0;
    image.center_offset_mm = {1.0, 0.5};
    image.pixel_aspect = 2.0;
    EXPECT_NEAR(PixelPitch(request).x, 0.1, 1e-15);
    EXPECT_NEAR(PixelPitch(request).y, 0.05, 1e-15);
    for (const double azimuth : {0.0, 0.7, -2.0}) {
        const PictureMap map = MapOf(request, PoseOf(*request.lens, azimuth));
        const Vec2d axis = map.Pixel(0.0, 0.0);
        EXPECT_NEAR(axis.x, 180.0 + 10.0, 1e-12);
        EXPECT_NEAR(axis.y, 100.0 - 10.0, 1e-12);
        // Lens space (x, y) = the canonical point turned; on the picture right is -x, down is +y.
        const double cx = 3.0, cy = -1.0;
        const double x = cx * std::cos(azimuth) - cy * std::sin(azimuth);
        const double y = cx * std::sin(azimuth) + cy * std::cos(azimuth);
        const Vec2d p = map.Pixel(cx, cy);
        EXPECT_NEAR(p.x, 190.0 - x / 0.1, 1e-11);
        EXPECT_NEAR(p.y, 90.0 + y / 0.05, 1e-11);
    }
}

TEST(Projection, IsTheLensesOwnForWideOnes) {
    FlareRequest request = RequestWith(Towards(0.0, 0.0, 1.0));
    EXPECT_EQ(ProjectionOf(request), Projection::kRectilinear);
    request.lens = testing::LibraryLens(testing::kFisheyeName);
    EXPECT_EQ(ProjectionOf(request), Projection::kLens);
    request.image.projection = Projection::kRectilinear;
    EXPECT_EQ(ProjectionOf(request), Projection::kRectilinear);
}

TEST(PlacedLight, RefusesAPixelThatTheLensDoesNotImage) {
    LightSpec light;
    light.pixel = Vec2d(1e5, 50.0);
    FlareRequest request = RequestWith(light);
    request.lens = testing::LibraryLens(testing::kFisheyeName);
    const auto placed = PlaceLight(request, 0);
    ASSERT_FALSE(placed.ok());
    EXPECT_EQ(placed.error().where, "/lights/0/pixel");
    // The rectilinear projection knows a direction for every pixel.
    request.image.projection = Projection::kRectilinear;
    EXPECT_TRUE(PlaceLight(request, 0).ok());
}

}  // namespace
}  // namespace flare
