// SPDX-License-Identifier: Apache-2.0
//
// The two truths against each other: the dense mesh and random exact rays. tests/bench/photon_bench
// does the same with twelve lenses and more samples.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "core/optics/lens_coatings.h"
#include "tests/support/anamorphic_lens.h"
#include "tests/support/lenses.h"
#include "tests/support/photon_agreement.h"

namespace flare {
namespace {

struct Scene {
    const char* name;
    const char* lens;
    double field_deg, azimuth_deg, f_number;
    bool coated;
    std::int64_t samples;
    double distance_m = 0.0;
};

void PrintTo(const Scene& scene, std::ostream* out) {
    *out << scene.name;
}

class TwoTruths : public ::testing::TestWithParam<Scene> {};

TEST_P(TwoTruths, AgreeWithinTheNoise) {
    const Scene& scene = GetParam();
    auto lens = scene.lens != nullptr
                    ? testing::LibraryLens(scene.lens)
                    : testing::BuildLens(testing::BehindAfocalPair(testing::PlanoConvex()));
    if (!scene.coated) lens = *lens->WithCoatings({"bare", {}, {}});
    FlareRequest request = testing::SpectralRequest(lens, scene.f_number, 24, 16);
    request.lights = {testing::LightAt(scene.field_deg, scene.azimuth_deg)};
    if (scene.distance_m > 0.0) request.lights[0].distance_m = scene.distance_m;
    request.iris.blades = 6;
    testing::Studio studio;
    const testing::PhotonAgreement found = testing::Agreement(request, scene.samples, 7, studio);
    std::printf(
        "%-22s %3d blocks, mean t^2 %.2f (%+.1f sigma), largest |t| %.1f, light %+.2e, "
        "noise of a block %.2e\n",
        scene.name, found.blocks, found.mean_t2, found.sigma, found.largest_t,
        found.photon_over_mesh, found.error);
    EXPECT_GT(found.blocks, 40);
    EXPECT_LT(found.sigma, 4.0);
    EXPECT_GT(found.sigma, -4.0);
    EXPECT_LT(found.largest_t, 7.0);
    // All the light, within four times the noise of independent blocks.
    EXPECT_LT(std::abs(found.photon_over_mesh), 2e-3 + 4.0 * found.error / std::sqrt(found.blocks));
}

INSTANTIATE_TEST_SUITE_P(
    Lenses, TwoTruths,
    ::testing::Values(Scene{"seed_on_axis", testing::kSeedName, 0.0, 0.0, 4.0, true, 4096},
                      Scene{"seed_off_axis", testing::kSeedName, 12.0, 35.0, 2.8, true, 4096},
                      Scene{"near_light", testing::kHeliarName, 9.0, -120.0, 5.6, true, 8192, 0.4},
                      Scene{"anamorphic", nullptr, 4.0, 40.0, 8.0, false, 8192}),
    [](const auto& scene) { return std::string(scene.param.name); });

// In colour as well: the same light, wavelength by wavelength at random. The preset `final` is
// right to half a per cent, a sixteenth of the noise.
TEST(PhotonsInColour, AgreeWithTheMesh) {
    FlareRequest request =
        testing::SpectralRequest(testing::LibraryLens("sasian-triplet-50mm-f4"), 4.0, 12, 8);
    request.color = ColorMode::kAcesCg;
    request.wavelengths_nm.clear();
    request.lights = {testing::LightAt(8.0, 30.0)};
    request.lights[0].temperature_k = 4000.0;
    testing::Studio studio;
    const testing::PhotonAgreement found =
        testing::Agreement(request, 1 << 15, 3, studio, QualityPreset::kFinal);
    std::printf("in colour: %d blocks, mean t^2 %.2f (%+.1f sigma), largest |t| %.1f, noise %.2e\n",
                found.blocks, found.mean_t2, found.sigma, found.largest_t, found.error);
    EXPECT_GT(found.blocks, 200);
    EXPECT_LT(std::abs(found.sigma), 5.0);
    EXPECT_LT(std::abs(found.photon_over_mesh), 2e-2);
}

// Far off the axis of a fisheye nine ghosts in ten use so little of the front that hardly a ray of
// a grid over it gets through: they were not found, and three quarters of the light with them.
TEST(PhotonsThroughAFisheye, FindTheNarrowPassages) {
    FlareRequest request =
        testing::SpectralRequest(testing::LibraryLens(testing::kFisheyeName), 4.0, 24, 16);
    request.lights = {testing::LightAt(70.0, 30.0)};
    request.iris.blades = 7;
    testing::Studio studio;
    const testing::PhotonAgreement found =
        testing::Agreement(request, 1 << 11, 3, studio, QualityPreset::kPreview);
    std::printf("fisheye at 70: %d blocks, mean t^2 %.2f (%+.1f sigma), noise %.2e, light %+.3f\n",
                found.blocks, found.mean_t2, found.sigma, found.error, found.photon_over_mesh);
    EXPECT_GT(found.blocks, 20);
    EXPECT_LT(std::abs(found.sigma), 5.0);
    EXPECT_LT(std::abs(found.photon_over_mesh), 4e-2);
}

// A disc of light is the mean over the points of it.
TEST(PhotonsOfADisc, AreThoseOfItsPoints) {
    FlareRequest request =
        testing::SpectralRequest(testing::LibraryLens(testing::kHeliarName), 4.0, 12, 8);
    request.quality = QualityPreset::kReference;
    request.photon = PhotonSpec{};
    request.photon->samples = 1 << 14;
    request.lights = {testing::LightAt(6.0)};
    request.lights[0].angular_diameter_deg = 4.0;
    testing::Studio studio;
    const FlareImage disc = studio.Shoot(request).image;
    // Points of equal shares of the disc on rings: 2 degrees about a light at 6.
    FlareRequest points = request;
    points.photon->samples = 512;
    points.lights.clear();
    const double middle = RadiansFromDegrees(6.0), radius = std::tan(RadiansFromDegrees(2.0));
    constexpr int kRings = 3, kSpokes = 8;
    for (int r = 0; r < kRings; ++r) {
        for (int s = 0; s < kSpokes; ++s) {
            const double rho = radius * std::sqrt((r + 0.5) / kRings);
            const double phi = 2.0 * kPi * (s + 0.5 * (r % 2)) / kSpokes;
            const Vec3d axis(-std::sin(middle), 0.0, std::cos(middle));
            const Vec3d u(std::cos(middle), 0.0, std::sin(middle)), v(0.0, 1.0, 0.0);
            LightSpec light = testing::LightAt(0.0);
            light.direction = axis + u * (rho * std::cos(phi)) + v * (rho * std::sin(phi));
            light.irradiance = Vec3d(1.0, 1.0, 1.0) / (kRings * kSpokes);
            points.lights.push_back(light);
        }
    }
    const FlareImage sum = studio.Shoot(points).image;
    EXPECT_NEAR(testing::Sum(disc.planes[0]) / testing::Sum(sum.planes[0]), 1.0, 0.04);
    EXPECT_LT(testing::RelL1(disc, sum), 0.1);
    // ... and not those of its middle.
    request.lights[0].angular_diameter_deg = 0.0;
    EXPECT_GT(testing::RelL1(studio.Shoot(request).image, sum), 0.1);
}

}  // namespace
}  // namespace flare
