// SPDX-License-Identifier: Apache-2.0
//
// What the bokeh layer promises as a layer: its planes, their sum with the others, equal bits for
// crops and threads, and the direct light counted once. Its light is the physics tests' business.
#include "core/render/bokeh_layer.h"

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
    request.f_number = 8.0;
    request.iris = {5, 0.0, 20.0};
    request.image.width = 60;
    request.image.height = 40;
    request.lights = {LightAt(3.0, 30.0)};
    request.lights[0].distance_m = 3.0;
    request.quality = QualityPreset::kDraft;
    return request;
}

TEST(BokehLayer, StandsBesideTheOthersAndInTheirSum) {
    Studio studio;
    FlareRequest request = Small();
    request.layers = {true, true, true};
    const FlareImage all = studio.Shoot(request).image;
    ASSERT_EQ(all.planes.size(), 12U);
    EXPECT_EQ(all.planes[9].name, "bokeh.R");
    request.layers = {false, false, true};
    const Rendering alone = studio.Shoot(request);
    ASSERT_EQ(alone.image.planes.size(), 6U);
    EXPECT_TRUE(alone.report.facts.ghosts.empty());
    for (const char* channel : {"R", "G", "B"}) {
        const std::string name(channel);
        const PlaneValues& bokeh = PlaneNamed(all, "bokeh." + name).values;
        EXPECT_EQ(bokeh, PlaneNamed(alone.image, "bokeh." + name).values);
        EXPECT_EQ(PlaneNamed(alone.image, name).values, bokeh);
        for (std::size_t k = 0; k < bokeh.size(); ++k) {
            const float sum = PlaneNamed(all, "ghosts." + name).values[k] +
                              PlaneNamed(all, "starburst." + name).values[k] + bokeh[k];
            EXPECT_NEAR(PlaneNamed(all, name).values[k], sum, 1e-6F * std::abs(sum));
        }
    }
    EXPECT_GT(testing::Sum(PlaneNamed(all, "bokeh.G")), 0.0);
}

TEST(BokehLayer, HasTheSameBitsInACropAndOnMoreThreads) {
    for (const ColorMode color : {ColorMode::kLinRec709, ColorMode::kSpectral}) {
        FlareRequest request = Small();
        request.layers = {false, false, true};
        request.color = color;
        if (color == ColorMode::kSpectral) request.wavelengths_nm = {450.0, 600.0};
        Studio one(1), three(3);
        const FlareImage whole = one.Shoot(request).image;
        EXPECT_EQ(three.Shoot(request).image.planes[0].values, whole.planes[0].values);
        // Through the middle of the image.
        request.image.crop = {{17, 5, 22, 21}};
        const FlareImage crop = three.Shoot(request).image;
        double light = 0.0;
        for (std::size_t p = 0; p < crop.planes.size(); ++p) {
            testing::ExpectIsCropOf(whole, crop, *request.image.crop, p);
            light += testing::Sum(crop.planes[p]);
        }
        EXPECT_GT(light, 0.0);
    }
}

TEST(BokehLayer, AddsLightsUpAndLeavesOutThoseWithoutAnImage) {
    Studio studio;
    FlareRequest request = Small();
    request.layers = {false, false, true};
    const FlareImage one = studio.Shoot(request).image;
    const LightSpec light = request.lights[0];
    request.lights = {light, LightAt(120.0), light};
    request.lights[0].irradiance = request.lights[2].irradiance = Vec3d(0.5, 0.5, 0.5);
    const Rendering more = studio.Shoot(request);
    EXPECT_EQ(more.report.facts.bokeh->lights, 2U);
    for (std::size_t k = 0; k < one.planes[0].values.size(); ++k) {
        const float value = one.planes[0].values[k];
        EXPECT_NEAR(more.image.planes[0].values[k], value, 1e-5F * std::abs(value));
    }
    request.lights = {LightAt(120.0)};
    const Rendering dark = studio.Shoot(request);
    EXPECT_EQ(testing::Sum(dark.image.planes[0]), 0.0);
    EXPECT_EQ(dark.report.facts.bokeh->flux_mm2, 0.0);
}

// The core of the starburst is the direct image: beside a bokeh layer it is left out, to the last
// bit as if the request had said so.
TEST(BokehLayer, TakesTheCoreOutOfTheStarburst) {
    Studio studio;
    FlareRequest request = Small();
    request.layers = {false, true, true};
    const Rendering both = studio.Shoot(request);
    request.layers = {false, true, false};
    const Rendering whole = studio.Shoot(request);
    request.starburst.core = false;
    const Rendering without = studio.Shoot(request);
    EXPECT_EQ(PlaneNamed(both.image, "starburst.G").values,
              PlaneNamed(without.image, "starburst.G").values);
    EXPECT_FALSE(both.report.facts.starburst->core);
    const double share = both.report.facts.starburst->core_share;
    EXPECT_GT(share, 0.5);
    const double all = testing::Sum(PlaneNamed(whole.image, "starburst.G"));
    const double left = testing::Sum(PlaneNamed(both.image, "starburst.G"));
    EXPECT_NEAR(left, (1.0 - share) * all, 0.03 * all);
}

TEST(BokehLayer, RefusesLightsThatAreNoPoints) {
    FlareRequest request = Small();
    request.layers = {false, false, true};
    EXPECT_FALSE(CheckRequest(request));
    request.lights[0].angular_diameter_deg = 0.5;
    const std::optional<Error> error = CheckRequest(request);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, "unsupported");
    EXPECT_EQ(error->where, "/lights/0/angular_diameter_deg");
}

}  // namespace
}  // namespace flare
