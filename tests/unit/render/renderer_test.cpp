// SPDX-License-Identifier: Apache-2.0
//
// What the renderer reports and borrows: the picture's numbers are the physics tests' business.
#include "core/render/renderer.h"

#include <gtest/gtest.h>

#include "core/render/ghost_list.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::Studio;

FlareRequest Small() {
    FlareRequest request;
    request.lens = testing::BuildLens(testing::PlanoConvex());
    request.f_number = 12.0;
    request.image.width = 40;
    request.image.height = 20;
    request.lights = {LightAt(3.0)};
    return request;
}

TEST(Renderer, NamesItsPlanes) {
    Studio studio;
    FlareRequest request = Small();
    const auto names = [](const FlareImage& image) {
        std::vector<std::string> list;
        for (const ImagePlane& plane : image.planes) list.push_back(plane.name);
        return list;
    };
    EXPECT_EQ(names(studio.Shoot(request).image),
              (std::vector<std::string>{"R", "G", "B", "ghosts.R", "ghosts.G", "ghosts.B"}));
    request.color = ColorMode::kSpectral;
    request.wavelengths_nm = {587.5618, 450.0};
    const FlareImage spectral = studio.Shoot(request).image;
    EXPECT_EQ(names(spectral),
              (std::vector<std::string>{"S0.587,5618nm", "S0.450nm", "ghosts.S0.587,5618nm",
                                        "ghosts.S0.450nm"}));
    EXPECT_FALSE(spectral.rec709);
    EXPECT_EQ(spectral.data, (PixelWindow{0, 0, 40, 20}));
}

TEST(Renderer, TracesNothingWhenOnlyTheIrisChanges) {
    Studio studio;
    FlareRequest request = Small();
    const Rendering first = studio.Shoot(request);
    EXPECT_GT(first.report.work.rays_traced, 0U);
    EXPECT_EQ(first.report.work.mesh_hits, 0U);
    request.iris = {6, 0.3, 20.0};
    request.f_number = 22.0;
    request.lights[0].irradiance = Vec3d(3.0, 2.0, 1.0);
    const Rendering second = studio.Shoot(request);
    EXPECT_EQ(second.report.work.rays_traced, 0U);
    EXPECT_EQ(second.report.work.mesh_misses, 0U);
    EXPECT_EQ(second.report.work.mesh_hits, first.report.work.mesh_misses);
    EXPECT_FALSE(second.image.planes[1].values == first.image.planes[1].values);
    // Nor for another coating: the mesh does not know it.
    request.lens = request.lens->WithBareGlass();
    EXPECT_EQ(studio.Shoot(request).report.work.rays_traced, 0U);
}

TEST(Renderer, StopsWhenCancelled) {
    Studio studio;
    RenderContext context = studio.Context();
    context.cancel.Cancel();
    const auto rendering = Render(Small(), context);
    ASSERT_FALSE(rendering.ok());
    EXPECT_EQ(rendering.error().code, "cancelled");
    const auto list = RankGhosts(Small().lens, {}, context);
    ASSERT_FALSE(list.ok());
    EXPECT_EQ(list.error().code, "cancelled");
}

TEST(Renderer, ReportsWhatItWasAsked) {
    Studio studio;
    FlareRequest request = Small();
    request.lights = {LightAt(3.0), LightAt(70.0, 90.0)};
    const Report report = studio.Shoot(request).report;
    ASSERT_EQ(report.facts.lights.size(), 2U);
    EXPECT_NEAR(report.facts.lights[0].field_deg, 3.0, 1e-10);
    EXPECT_TRUE(report.facts.lights[0].chief_ray_arrives);
    EXPECT_NEAR(report.facts.f_number, 12.0, 1e-12);
    EXPECT_TRUE(report.facts.clamped.empty());
    ASSERT_EQ(report.facts.ghosts.size(), 1U);
    EXPECT_EQ(report.facts.ghosts[0].sequence, (std::vector<int>{2, 1}));
    EXPECT_EQ(report.facts.ghosts[0].model, "geometric");
    EXPECT_GT(report.work.fragments, 0U);
}

TEST(RankedGhosts, RefuseOptionsThatMakeNoSense) {
    Studio studio;
    const auto lens = testing::BuildLens(testing::PlanoConvex());
    const auto refused = [&](auto change, const char* where) {
        GhostListOptions options;
        change(options);
        const auto list = RankGhosts(lens, options, studio.Context());
        ASSERT_FALSE(list.ok()) << where;
        EXPECT_EQ(list.error().where, where);
    };
    refused([](GhostListOptions& o) { o.field_deg = -1.0; }, "field_deg");
    refused([](GhostListOptions& o) { o.field_deg = 181.0; }, "field_deg");
    refused([](GhostListOptions& o) { o.wavelength_nm = 200.0; }, "wavelength_nm");
    refused([](GhostListOptions& o) { o.f_number = 0.0; }, "f_number");
}

// The one ghost of a plano-convex lens, first order: closed forms.
TEST(RankedGhosts, CarryFirstOrderFiguresAndPeaks) {
    Studio studio;
    const auto lens = testing::BuildLens(testing::PlanoConvex());
    GhostListOptions options;
    options.f_number = 40.0;
    const auto list = RankGhosts(lens, options, studio.Context());
    ASSERT_TRUE(list.ok());
    ASSERT_EQ(list->ghosts.size(), 1U);
    const GhostEntry& ghost = list->ghosts[0];
    // R = 50, n = 1.5, t = 6; refract, go t, plane mirror, back t, concave mirror 50, go t, out.
    const double n = 1.5, t = 6.0, r = 50.0, stop_gap = 2.0;
    double y = 1.0, u = 0.0;
    y += stop_gap * u;
    u = u / n - y * (n - 1.0) / (n * r);
    y += 2.0 * t * u;
    u -= 2.0 * y / r;
    y += t * u;
    u *= n;
    y += (lens->sensor_z_mm() - 8.0) * u;
    EXPECT_NEAR(std::abs(ghost.x.abcd.a), std::abs(y), 1e-9 * std::abs(y));
    ASSERT_EQ(ghost.x.crossings.size(), 1U);
    EXPECT_NEAR(ghost.x.crossings[0].a1, 1.0, 1e-12);
    EXPECT_NEAR(ghost.x.crossings[0].m, ghost.x.abcd.a, 1e-9);
    // R^2 T^2 over the stop's area, nearly at normal incidence; the peak is that over A^2.
    const double reflectance = 0.04, weight = reflectance * reflectance * 0.96 * 0.96;
    const double radius = 100.0 / 40.0 / 2.0;
    EXPECT_NEAR(ghost.flux_mm2, weight * kPi * radius * radius, 2e-3 * ghost.flux_mm2);
    EXPECT_NEAR(ghost.peak_irradiance, weight / (y * y), 0.1 * weight / (y * y));
}

}  // namespace
}  // namespace flare
