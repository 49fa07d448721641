// SPDX-License-Identifier: Apache-2.0
//
// Dust on the iris: the light that ghosts lose is what specks cover, and the starburst is the
// difference of two Airy patterns, by Babinet.
#include <gtest/gtest.h>

#include <cmath>

#include "core/optics/stop_dirt.h"
#include "core/render/render_scene.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"

namespace flare {
namespace {

using testing::Studio;

FlareRequest OnAxis(int size) {
    FlareRequest request =
        testing::SpectralRequest(testing::LibraryLens(testing::kSeedName), 8.0, size, size);
    request.wavelengths_nm = {550.0};
    request.lights = {testing::LightAt(0.0)};
    return request;
}

double Rim(const Lens& lens) {
    return lens.surfaces()[static_cast<std::size_t>(lens.stop_index())].semi_diameter_mm;
}

void Soil(FlareRequest& request, const std::vector<StopMark>& marks) {
    request.iris.mask = DirtyStop(marks, Rim(*request.lens));
    request.iris.mask_scale = MaskScale::kStop;
}

TEST(DirtyIris, TakesFromGhostsTheLightThatSpecksCover) {
    Studio studio;
    FlareRequest request = OnAxis(64);
    request.image.sensor_width_mm = 400.0;
    request.model.culling = CullingRule::kNone;
    const Rendering clean = studio.Shoot(request);
    const double radius = RenderScene(request).iris.outer_radius();
    double covered = 0.0;
    std::vector<StopMark> marks;
    for (const StopMark& mark : MarksOf({60, 0.25, 1.0, 3}, {}, radius)) {
        if (mark.a.length() + mark.radius_mm > radius) continue;
        marks.push_back(mark);
        covered += kPi * mark.radius_mm * mark.radius_mm;
    }
    Soil(request, marks);
    const Rendering dirty = studio.Shoot(request);
    const double share = covered / (kPi * radius * radius);
    ASSERT_GT(share, 0.05);
    for (std::size_t n = 0; n < clean.report.facts.ghosts.size(); ++n) {
        const GhostFacts& ghost = clean.report.facts.ghosts[n];
        // Both surfaces behind the stop: it is passed once.
        if (ghost.sequence != BounceSequence{10, 9} && ghost.sequence != BounceSequence{8, 6})
            continue;
        const double lost = 1.0 - dirty.report.facts.ghosts[n].flux_mm2 / ghost.flux_mm2;
        EXPECT_NEAR(lost, share, 0.02 * share);
    }
    // All light, that of ghosts which pass the stop three times included, lands on this frame: it
    // loses more than that share, and less than three times.
    const double all =
        1.0 - testing::Sum(dirty.image.planes[0]) / testing::Sum(clean.image.planes[0]);
    EXPECT_GT(all, share);
    EXPECT_LT(all, 3.0 * share);
}

// 2 J1(u) / u.
double Jinc(double u) {
    return u < 1e-9 ? 1.0 : 2.0 * std::cyl_bessel_j(1, u) / u;
}

TEST(DirtyIris, HasAStarburstAsBabinetSays) {
    Studio studio;
    constexpr int kSize = 60;
    constexpr double kPixel_mm = 5e-4, kShare = 0.3;
    FlareRequest request = OnAxis(kSize);
    request.layers = {false, true, false};
    request.image.sensor_width_mm = kSize * kPixel_mm;
    const FlareImage clean = studio.Shoot(request).image;
    const double radius = RenderScene(request).iris.outer_radius();
    Soil(request, {{Vec2d(0.0), Vec2d(0.0), kShare * radius, 1.0}});
    const FlareImage dirty = studio.Shoot(request).image;
    double peak = 0.0;
    for (const float value : clean.planes[0].values)
        peak = std::max(peak, static_cast<double>(value));
    constexpr int kParts = 4;
    double clean_peak = 0.0, worst = 0.0;
    const auto mean = [&](int i, int j, double hole) {
        double sum = 0.0;
        for (int k = 0; k < kParts * kParts; ++k) {
            const double x = (i + (k % kParts + 0.5) / kParts - 0.5 * kSize) * kPixel_mm;
            const double y = (j + (k / kParts + 0.5) / kParts - 0.5 * kSize) * kPixel_mm;
            const double u = kPi * std::hypot(x, y) / (550e-6 * 8.0);
            sum += std::pow(Jinc(u) - hole * hole * Jinc(hole * u), 2.0);
        }
        return sum / (kParts * kParts);
    };
    for (int j = 0; j < kSize; ++j) {
        for (int i = 0; i < kSize; ++i) clean_peak = std::max(clean_peak, mean(i, j, 0.0));
    }
    for (int j = 0; j < kSize; ++j) {
        for (int i = 0; i < kSize; ++i) {
            const auto n = static_cast<std::size_t>(j * kSize + i);
            const double drawn = static_cast<double>(dirty.planes[0].values[n]) / peak;
            worst = std::max(worst, std::abs(drawn - mean(i, j, kShare) / clean_peak));
        }
    }
    EXPECT_LT(worst, 0.005);
    // Without the speck it would be another pattern.
    EXPECT_LT(mean(kSize / 2, kSize / 2, kShare), 0.9 * clean_peak);
}

}  // namespace
}  // namespace flare
