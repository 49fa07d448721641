// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "core/render/quality.h"

namespace flare {
namespace {

TEST(Tolerance, HoldsThePresets) {
    for (const auto& [preset, tolerance] : {std::pair{QualityPreset::kDraft, 0.05},
                                            {QualityPreset::kPreview, 0.02},
                                            {QualityPreset::kFinal, 0.005}}) {
        const QualitySettings a = SettingsOf(preset), b = SettingsFor(tolerance);
        EXPECT_EQ(a.tolerance, tolerance);
        EXPECT_EQ(a.mesh_cells, b.mesh_cells);
        EXPECT_EQ(a.position_tolerance_mm, b.position_tolerance_mm);
        EXPECT_EQ(a.colour_bands, b.colour_bands);
        EXPECT_EQ(a.dispersion_step_px, b.dispersion_step_px);
        EXPECT_EQ(a.most_drawn, b.most_drawn);
        EXPECT_EQ(a.light_tolerance, b.light_tolerance);
        EXPECT_EQ(a.walk.position_px, b.walk.position_px);
        EXPECT_EQ(a.tiles->light, b.tiles->light);
        EXPECT_EQ(a.culled_share, b.culled_share);
    }
}

TEST(Tolerance, MakesEveryKnobFinerAndTheCostLarger) {
    for (double tolerance = kMaxTolerance; tolerance > 1.05 * kMinTolerance; tolerance *= 0.97) {
        const QualitySettings coarse = SettingsFor(tolerance);
        const QualitySettings fine = SettingsFor(0.97 * tolerance);
        EXPECT_GE(fine.mesh_cells, coarse.mesh_cells) << tolerance;
        EXPECT_LE(fine.position_tolerance_mm, coarse.position_tolerance_mm) << tolerance;
        EXPECT_GE(fine.colour_bands, coarse.colour_bands) << tolerance;
        EXPECT_LT(fine.dispersion_step_px, coarse.dispersion_step_px) << tolerance;
        EXPECT_GE(fine.most_drawn, coarse.most_drawn) << tolerance;
        EXPECT_LT(fine.light_tolerance, coarse.light_tolerance) << tolerance;
        EXPECT_LT(fine.walk.position_px, coarse.walk.position_px) << tolerance;
        EXPECT_LT(fine.walk.density_step, coarse.walk.density_step) << tolerance;
        EXPECT_LT(fine.tiles->light, coarse.tiles->light) << tolerance;
        EXPECT_LT(fine.tiles->edge_px, coarse.tiles->edge_px) << tolerance;
        EXPECT_LT(fine.tolerance * fine.culled_share, coarse.tolerance * coarse.culled_share);
        EXPECT_GT(RelativeCost(0.97 * tolerance), RelativeCost(tolerance)) << tolerance;
        // Without jumps, but for the mesh and whole numbers.
        EXPECT_GT(fine.dispersion_step_px, 0.9 * coarse.dispersion_step_px) << tolerance;
        EXPECT_GT(fine.tiles->light, 0.9 * coarse.tiles->light) << tolerance;
    }
}

TEST(Tolerance, IsHeldWithinItsEnds) {
    EXPECT_EQ(SettingsFor(1e-9).tolerance, kMinTolerance);
    EXPECT_EQ(SettingsFor(5.0).tolerance, kMaxTolerance);
    EXPECT_EQ(RelativeCost(5.0), 1.0);
    EXPECT_EQ(RelativeCost(1e-9), RelativeCost(kMinTolerance));
}

}  // namespace
}  // namespace flare
