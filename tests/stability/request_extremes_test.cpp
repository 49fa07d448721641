// SPDX-License-Identifier: Apache-2.0
//
// Requests with numbers that are none (row 36) or that no picture can have: refused with the
// field's place, and the next sound request is rendered as if nothing had been.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::Studio;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

FlareRequest Sound() {
    FlareRequest request =
        testing::SpectralRequest(testing::BuildLens(testing::PlanoConvex()), 12.0, 32, 18);
    request.lights = {LightAt(2.0), LightAt(1.0)};
    return request;
}

struct Bad {
    const char* where;
    std::function<void(FlareRequest&)> spoil;
};

const std::vector<Bad>& BadRequests() {
    static const std::vector<Bad> table{
        {"/lens", [](FlareRequest& r) { r.lens = nullptr; }},
        {"/f_number", [](FlareRequest& r) { r.f_number = kNaN; }},
        {"/f_number", [](FlareRequest& r) { r.f_number = kInfinity; }},
        {"/f_number", [](FlareRequest& r) { r.f_number = 0.0; }},
        {"/f_number", [](FlareRequest& r) { r.f_number = -4.0; }},
        {"/iris/blades", [](FlareRequest& r) { r.iris.blades = 2; }},
        {"/iris/blades", [](FlareRequest& r) { r.iris.blades = -6; }},
        {"/iris/blades", [](FlareRequest& r) { r.iris.blades = 33; }},
        {"/iris/roundness", [](FlareRequest& r) { r.iris.roundness = kNaN; }},
        {"/iris/roundness", [](FlareRequest& r) { r.iris.roundness = -0.1; }},
        {"/iris/roundness", [](FlareRequest& r) { r.iris.roundness = 1.1; }},
        {"/iris/rotation_deg", [](FlareRequest& r) { r.iris.rotation_deg = kNaN; }},
        {"/iris/rotation_deg", [](FlareRequest& r) { r.iris.rotation_deg = kInfinity; }},
        {"/image/width", [](FlareRequest& r) { r.image.width = -1; }},
        {"/image/width", [](FlareRequest& r) { r.image.width = 0; }},
        {"/image/width", [](FlareRequest& r) { r.image.width = 1'000'000'000; }},
        {"/image/height",
         [](FlareRequest& r) { r.image.height = std::numeric_limits<int>::min(); }},
        {"/image/sensor_width_mm", [](FlareRequest& r) { r.image.sensor_width_mm = kNaN; }},
        {"/image/sensor_width_mm", [](FlareRequest& r) { r.image.sensor_width_mm = -36.0; }},
        {"/image/sensor_width_mm", [](FlareRequest& r) { r.image.sensor_width_mm = kInfinity; }},
        {"/image/pixel_aspect", [](FlareRequest& r) { r.image.pixel_aspect = kNaN; }},
        {"/image/pixel_aspect", [](FlareRequest& r) { r.image.pixel_aspect = 0.0; }},
        {"/image/center_offset_mm", [](FlareRequest& r) { r.image.center_offset_mm.y = kNaN; }},
        {"/image/center_offset_mm",
         [](FlareRequest& r) { r.image.center_offset_mm.x = -kInfinity; }},
        {"/image/crop",
         [](FlareRequest& r) {
             r.image.crop = std::array<int, 4>{0, 0, 33, 1};
         }},
        {"/image/crop",
         [](FlareRequest& r) {
             r.image.crop = std::array<int, 4>{-1, 0, 3, 1};
         }},
        {"/image/crop",
         [](FlareRequest& r) {
             r.image.crop = std::array<int, 4>{31, 0, std::numeric_limits<int>::max(), 1};
         }},
        {"/image/overscan/2", [](FlareRequest& r) { r.image.overscan[2] = -1; }},
        {"/image",
         [](FlareRequest& r) {
             r.image.width = r.image.height = kMaxImageSide;
             r.image.overscan = {kMaxImageSide, kMaxImageSide, kMaxImageSide, kMaxImageSide};
         }},
        {"/lights/1/direction",
         [](FlareRequest& r) { r.lights[1].direction = Vec3d(0.0, 0.0, 0.0); }},
        {"/lights/1/direction",
         [](FlareRequest& r) { r.lights[1].direction = Vec3d(kNaN, 0.0, 1.0); }},
        {"/lights/0/direction",
         [](FlareRequest& r) { r.lights[0].direction = Vec3d(0.0, kInfinity, 1.0); }},
        {"/lights/1", [](FlareRequest& r) { r.lights[1].pixel = Vec2d(1.0, 1.0); }},
        {"/lights/1", [](FlareRequest& r) { r.lights[1].direction.reset(); }},
        {"/lights/0/pixel",
         [](FlareRequest& r) {
             r.lights[0].direction.reset();
             r.lights[0].pixel = Vec2d(kNaN, 1.0);
         }},
        {"/lights/1/distance_m", [](FlareRequest& r) { r.lights[1].distance_m = 0.0; }},
        {"/lights/1/distance_m", [](FlareRequest& r) { r.lights[1].distance_m = -2.0; }},
        {"/lights/1/distance_m", [](FlareRequest& r) { r.lights[1].distance_m = kNaN; }},
        {"/lights/1/distance_m", [](FlareRequest& r) { r.lights[1].distance_m = kInfinity; }},
        {"/lights/0/irradiance", [](FlareRequest& r) { r.lights[0].irradiance.y = -1e-9; }},
        {"/lights/0/irradiance", [](FlareRequest& r) { r.lights[0].irradiance.z = kNaN; }},
        {"/lights/0/irradiance", [](FlareRequest& r) { r.lights[0].irradiance.x = kInfinity; }},
        {"/wavelengths_nm", [](FlareRequest& r) { r.wavelengths_nm.clear(); }},
        {"/wavelengths_nm/1",
         [](FlareRequest& r) {
             r.wavelengths_nm = {550.0, kNaN};
         }},
        {"/wavelengths_nm/0", [](FlareRequest& r) { r.wavelengths_nm = {299.0}; }},
        {"/wavelengths_nm/0",
         [](FlareRequest& r) {
             r.wavelengths_nm = {500.0, 500.0};
         }},
        {"/lights", [](FlareRequest& r) { r.lights.assign(kMaxLights + 1, LightAt(1.0)); }},
    };
    return table;
}

TEST(ABadRequest, NamesItsFieldAndLeavesTheNextOneAlone) {
    Studio studio;
    const FlareImage before = studio.Shoot(Sound()).image;
    ASSERT_GT(testing::Sum(before.planes[0]), 0.0);
    for (std::size_t i = 0; i < BadRequests().size(); ++i) {
        const Bad& bad = BadRequests()[i];
        FlareRequest request = Sound();
        bad.spoil(request);
        const Result<Rendering> rendering = Render(request, studio.Context());
        ASSERT_FALSE(rendering.ok()) << "row " << i << ", " << bad.where;
        EXPECT_EQ(rendering.error().where, bad.where) << "row " << i;
        EXPECT_FALSE(rendering.error().message.empty());
        EXPECT_FALSE(rendering.error().code.empty());
        const std::optional<Error> check = CheckRequest(request);
        ASSERT_TRUE(check.has_value());
        EXPECT_EQ(check->where, bad.where);
    }
    const FlareImage after = studio.Shoot(Sound()).image;
    EXPECT_TRUE(after.planes[0].values == before.planes[0].values);
}

// The small ends.
TEST(NoLight, IsBlackAndTwoHalvesAreOne) {
    Studio studio;
    FlareRequest request = Sound();
    request.lights.clear();
    const FlareImage black = studio.Shoot(request).image;
    for (const float value : black.planes[0].values) EXPECT_EQ(value, 0.0F);
    request.lights = {LightAt(2.0)};
    const FlareImage one = studio.Shoot(request).image;
    request.lights = {LightAt(2.0), LightAt(2.0)};
    for (LightSpec& light : request.lights) light.irradiance = Vec3d(0.5, 0.5, 0.5);
    EXPECT_LT(testing::RelL1(studio.Shoot(request).image, one), 1e-7);
}

TEST(IrradiancesAtTheEndsOfTheScale, StayFinite) {
    Studio studio;
    FlareRequest request = Sound();
    for (const double e : {0.0, 1e-300, 1e-30, 1e30, 1e300}) {
        for (LightSpec& light : request.lights) light.irradiance = Vec3d(e, e, e);
        for (const ColorMode color : {ColorMode::kSpectral, ColorMode::kLinRec709}) {
            request.color = color;
            const FlareImage image = studio.Shoot(request).image;
            for (const ImagePlane& plane : image.planes) {
                for (const float value : plane.values) ASSERT_TRUE(std::isfinite(value)) << e;
            }
        }
    }
}

// The small end: the one pixel holds what the frame's pixels hold together.
TEST(AnImageOfOnePixel, HoldsTheFramesLight) {
    Studio studio;
    FlareRequest request = Sound();
    request.lights.resize(1);
    request.image.width = request.image.height = 64;
    const FlareImage many = studio.Shoot(request).image;
    request.image.width = request.image.height = 1;
    const FlareImage one = studio.Shoot(request).image;
    ASSERT_EQ(one.planes[0].values.size(), 1U);
    const double mean = testing::Sum(many.planes[0]) / 4096.0;
    EXPECT_NEAR(one.planes[0].values[0] / mean, 1.0, 5e-3);
}

TEST(ANarrowImage, IsRendered) {
    Studio studio;
    FlareRequest request = Sound();
    for (const auto& [w, h] : {std::pair{1, 4096}, {4096, 1}}) {
        request.image.width = w;
        request.image.height = h;
        EXPECT_EQ(studio.Shoot(request).image.planes[0].values.size(), 4096U);
    }
}

TEST(AnFNumberBelowTheLensesOwn, IsClampedAndTheReportSaysSo) {
    Studio studio;
    FlareRequest request = Sound();
    request.lens = testing::BuildLens(testing::SeedLens());
    request.image.crop = std::array<int, 4>{0, 0, 4, 4};
    request.quality = QualityPreset::kDraft;
    request.f_number = 0.7;
    const Rendering clamped = studio.Shoot(request);
    EXPECT_NEAR(clamped.report.facts.f_number, 2.0302, 1e-4);
    ASSERT_EQ(clamped.report.facts.clamped.size(), 1U);
    EXPECT_NE(clamped.report.facts.clamped[0].find("/f_number"), std::string::npos);
    request.f_number.reset();
    const Rendering open = studio.Shoot(request);
    EXPECT_TRUE(open.report.facts.clamped.empty());
    EXPECT_TRUE(open.image.planes[0].values == clamped.image.planes[0].values);
}

}  // namespace
}  // namespace flare
