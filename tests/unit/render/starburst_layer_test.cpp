// SPDX-License-Identifier: Apache-2.0
//
// What the starburst layer promises as a layer: its planes, their sum with the ghosts, equal bits
// for crops and threads, and what it makes of lights that it cannot show. Its light is the physics
// tests' business.
#include "core/render/starburst_layer.h"

#include <gtest/gtest.h>

#include "tests/support/crops.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::PlaneNamed;
using testing::Studio;

FlareRequest Small() {
    FlareRequest request;
    request.lens = testing::BuildLens(testing::PlanoConvex());
    request.f_number = 16.0;
    request.iris = {5, 0.0, 20.0};
    request.image.width = 60;
    request.image.height = 40;
    request.lights = {LightAt(3.0, 30.0)};
    request.layers = {true, true};
    request.quality = QualityPreset::kDraft;
    return request;
}

TEST(StarburstLayer, StandsBesideTheGhostsAndInTheirSum) {
    Studio studio;
    FlareRequest request = Small();
    const FlareImage both = studio.Shoot(request).image;
    ASSERT_EQ(both.planes.size(), 9U);
    EXPECT_EQ(both.planes[6].name, "starburst.R");
    request.layers = {true, false};
    const FlareImage ghosts = studio.Shoot(request).image;
    request.layers = {false, true};
    const Rendering alone = studio.Shoot(request);
    ASSERT_EQ(alone.image.planes.size(), 6U);
    EXPECT_TRUE(alone.report.facts.ghosts.empty());
    EXPECT_EQ(alone.report.work.rays_traced, 0U);
    for (const char* channel : {"R", "G", "B"}) {
        const std::string name(channel);
        const std::vector<float>& burst = PlaneNamed(both, "starburst." + name).values;
        EXPECT_EQ(PlaneNamed(both, "ghosts." + name).values,
                  PlaneNamed(ghosts, "ghosts." + name).values);
        EXPECT_EQ(burst, PlaneNamed(alone.image, "starburst." + name).values);
        EXPECT_EQ(PlaneNamed(alone.image, name).values, burst);
        for (std::size_t k = 0; k < burst.size(); ++k) {
            const float sum = PlaneNamed(ghosts, name).values[k] + burst[k];
            EXPECT_NEAR(PlaneNamed(both, name).values[k], sum, 1e-6F * sum);
        }
    }
}

TEST(StarburstLayer, HasTheSameBitsInACropAndOnMoreThreads) {
    for (const double diameter : {0.0, 1.0}) {
        FlareRequest request = Small();
        request.layers = {false, true};
        request.lights[0].angular_diameter_deg = diameter;
        Studio one(1), three(3);
        const FlareImage whole = one.Shoot(request).image;
        EXPECT_EQ(three.Shoot(request).image.planes[0].values, whole.planes[0].values);
        request.image.crop = {{17, 5, 30, 21}};
        const FlareImage crop = three.Shoot(request).image;
        testing::ExpectIsCropOf(whole, crop, *request.image.crop, 1);
    }
}

TEST(StarburstLayer, AddsLightsUpAndLeavesOutThoseWithoutAnImage) {
    Studio studio;
    FlareRequest request = Small();
    request.layers = {false, true};
    const FlareImage one = studio.Shoot(request).image;
    request.lights = {LightAt(3.0, 30.0), LightAt(120.0), LightAt(3.0, 30.0)};
    request.lights[0].irradiance = request.lights[2].irradiance = Vec3d(0.5, 0.5, 0.5);
    const Rendering more = studio.Shoot(request);
    EXPECT_EQ(more.report.facts.starburst->lights, 2U);
    for (std::size_t k = 0; k < one.planes[0].values.size(); ++k) {
        const float value = one.planes[0].values[k];
        EXPECT_NEAR(more.image.planes[0].values[k], value, 1e-5F * value);
    }
    request.lights = {LightAt(120.0)};
    const Rendering dark = studio.Shoot(request);
    EXPECT_EQ(testing::Sum(dark.image.planes[0]), 0.0);
    EXPECT_EQ(dark.report.facts.starburst->flux_mm2, 0.0);
}

// The mean over turns of the iris: another seed is another picture, the light is the same.
TEST(StarburstLayer, OfAnUnsteadyIrisIsSmearedAroundTheLight) {
    Studio studio;
    FlareRequest request = Small();
    request.layers = {false, true};
    const FlareImage steady = studio.Shoot(request).image;
    request.starburst.jitter_deg = 20.0;
    request.starburst.jitter_count = 3;
    const FlareImage unsteady = studio.Shoot(request).image;
    EXPECT_EQ(studio.Shoot(request).image.planes[0].values, unsteady.planes[0].values);
    request.starburst.seed = 1;
    EXPECT_NE(studio.Shoot(request).image.planes[0].values, unsteady.planes[0].values);
    const double sum = testing::Sum(steady.planes[1]);
    EXPECT_NEAR(testing::Sum(unsteady.planes[1]), sum, 0.01 * sum);
    EXPECT_NE(steady.planes[1].values, unsteady.planes[1].values);
}

TEST(StarburstLayer, RefusesWhatItCannotDo) {
    FlareRequest request = Small();
    request.lights[0].angular_diameter_deg = 20.5;
    const std::optional<Error> wide = CheckRequest(request);
    ASSERT_TRUE(wide);
    EXPECT_EQ(wide->code, "bad_value");
    EXPECT_EQ(wide->where, "/lights/0/angular_diameter_deg");
    request.lights[0].angular_diameter_deg = 0.5;
    request.layers = {false, false};
    EXPECT_EQ(CheckRequest(request)->where, "/layers");
    request.layers = {false, true};
    EXPECT_FALSE(CheckRequest(request));
    request.starburst.jitter_count = 0;
    EXPECT_EQ(CheckRequest(request)->where, "/starburst/jitter_count");
    request.starburst.jitter_count = 1;
    request.starburst.jitter_deg = -1.0;
    EXPECT_EQ(CheckRequest(request)->where, "/starburst/jitter_deg");
}

}  // namespace
}  // namespace flare
