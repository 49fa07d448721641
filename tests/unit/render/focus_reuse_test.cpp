// SPDX-License-Identifier: Apache-2.0
//
// Focusing moves the sensor and nothing else, so the meshes of a picture serve every focus.
#include <gtest/gtest.h>

#include "core/render/renderer.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::Studio;

FlareRequest Focused(const std::shared_ptr<const Lens>& base, std::optional<double> focus_m) {
    const LensInState set = *SetState(base, {focus_m, {}});
    FlareRequest request = testing::SpectralRequest(set.lens, 5.6, 96, 64);
    request.state = set.state;
    request.state_clamped = set.clamped;
    request.quality = QualityPreset::kDraft;
    request.lights = {LightAt(6.0, 70.0)};
    return request;
}

TEST(Focus, TracesNothingAndGivesTheBytesOfAFreshPicture) {
    const auto base = testing::BuildLens(testing::SeedLens());
    Studio studio;
    const Rendering far = studio.Shoot(Focused(base, {}));
    EXPECT_GT(far.report.work.rays_traced, 0U);
    FlareImage before = far.image;
    for (const double focus_m : {7.3, 1.0, 0.45}) {
        const Rendering near = studio.Shoot(Focused(base, focus_m));
        EXPECT_EQ(near.report.work.rays_traced, 0U) << focus_m;
        EXPECT_EQ(near.report.work.mesh_misses, 0U) << focus_m;
        EXPECT_EQ(near.report.work.mesh_hits, far.report.work.mesh_misses);
        Studio fresh;
        const Rendering anew = fresh.Shoot(Focused(base, focus_m));
        EXPECT_EQ(anew.report.work.rays_traced, far.report.work.rays_traced);
        EXPECT_TRUE(near.image.planes[0].values == anew.image.planes[0].values) << focus_m;
        // And it is another picture.
        EXPECT_GT(testing::RelL1(near.image, before), 0.005) << focus_m;
        before = near.image;
        EXPECT_EQ(near.report.facts.focus_m, focus_m);
    }
}

TEST(Focus, TracesAnewOnlyWhatTheSensorReflects) {
    Prescription prescription = testing::PlanoConvex();
    SurfacePrescription sensor;
    sensor.kind = SurfaceKind::kSensor;
    sensor.reflectance = 0.05;
    sensor.semi_diameter_mm = 21.6;
    prescription.surfaces.push_back(sensor);
    const auto base = testing::BuildLens(prescription);
    Studio studio;
    FlareRequest request = Focused(base, {});
    request.f_number = 12.0;
    request.model.sensor_reflection = true;
    EXPECT_EQ(studio.Shoot(request).report.work.mesh_misses, 3U);
    FlareRequest near = Focused(base, 2.0);
    near.f_number = 12.0;
    near.model.sensor_reflection = true;
    const Rendering rendering = studio.Shoot(near);
    EXPECT_EQ(rendering.report.work.mesh_misses, 2U);
    EXPECT_EQ(rendering.report.work.mesh_hits, 1U);
}

TEST(Focus, ThatWasClampedIsReported) {
    const auto base = testing::BuildLens(testing::SeedLens());
    Studio studio;
    const Rendering rendering = studio.Shoot(Focused(base, 0.05));
    ASSERT_EQ(rendering.report.facts.clamped.size(), 1U);
    EXPECT_EQ(rendering.report.facts.clamped[0].rfind("/focus_m: 0.05", 0), 0U)
        << rendering.report.facts.clamped[0];
    EXPECT_NEAR(rendering.report.facts.focus_m.value(), 0.19598, 1e-4);
    EXPECT_FALSE(rendering.report.facts.zoom_mm.has_value());
}

}  // namespace
}  // namespace flare
