// SPDX-License-Identifier: Apache-2.0
//
// The picture holds the light, in absolute units: its sum is the flux that lands in the frame,
// coarse and fine settings agree, each block of pixels holds what counted rays put there, and
// scene-linear output differs from sensor irradiance by one stated factor.
#include <gtest/gtest.h>

#include <cmath>

#include "core/optics/paraxial.h"
#include "core/render/lights.h"
#include "tests/support/brute_force.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::SpectralRequest;
using testing::Studio;

constexpr const char* kPlane = "S0.587,5618nm";

FlareRequest SeedRequest(int width, int height) {
    FlareRequest request = SpectralRequest(testing::BuildLens(testing::SeedLens())->WithBareGlass(),
                                           4.0, width, height);
    request.lights = {LightAt(5.0)};
    return request;
}

double PixelArea(const ImageSpec& image) {
    const double pitch = image.sensor_width_mm / image.width;
    return pitch * pitch / image.pixel_aspect;
}

TEST(PictureEnergy, OfSeedLensAtF4And5DegreesIs4_519SquareMillimetres) {
    Studio studio;
    const FlareRequest request = SeedRequest(480, 270);
    const Rendering rendering = studio.Shoot(request);
    const double energy =
        testing::Sum(testing::PlaneNamed(rendering.image, kPlane)) * PixelArea(request.image);
    EXPECT_NEAR(energy, 4.519, 0.002 * 4.519);
    // Off the frame there is the rest.
    double total = 0.0;
    for (const GhostFacts& ghost : rendering.report.facts.ghosts) total += ghost.flux_mm2;
    EXPECT_NEAR(total, 5.371, 0.002 * 5.371);
    EXPECT_EQ(testing::PlaneNamed(rendering.image, std::string("ghosts.") + kPlane).values,
              testing::PlaneNamed(rendering.image, kPlane).values);
}

TEST(PictureEnergy, DoesNotDependOnTheSizeOfPixels) {
    Studio studio;
    double reference = 0.0;
    for (const int width : {64, 512, 1024}) {
        const FlareRequest request = SeedRequest(width, width * 9 / 16);
        const double energy =
            testing::Sum(testing::PlaneNamed(studio.Shoot(request).image, kPlane)) *
            PixelArea(request.image);
        if (reference == 0.0) reference = energy;
        EXPECT_NEAR(energy, reference, 5e-4 * reference) << width;
    }
}

TEST(Discretisation, PreviewIsWithinOnePerCentOfFinal) {
    Studio studio;
    FlareRequest request = SeedRequest(480, 270);
    const FlareImage preview = studio.Shoot(request).image;
    request.quality = QualityPreset::kFinal;
    const FlareImage final = studio.Shoot(request).image;
    const double distance = testing::RelL1(preview, final);
    RecordProperty("rel_l1", std::to_string(distance));
    EXPECT_LT(distance, 0.01);
    EXPECT_GT(distance, 0.0) << "the two presets are one";
}

// Rays counted into blocks of 20 x 20 pixels: an independent picture of all 45 ghosts.
TEST(Picture, HoldsInEachBlockWhatCountedRaysPutThere) {
    Studio studio;
    FlareRequest request = SeedRequest(480, 270);
    request.lights = {LightAt(7.0)};
    const FlareImage image = studio.Shoot(request).image;
    constexpr int kBlock = 30;
    constexpr int kColumns = 480 / kBlock, kRows = 270 / kBlock;
    std::vector<double> counted(kColumns * kRows), drawn(kColumns * kRows);
    const ImagePlane& plane = testing::PlaneNamed(image, kPlane);
    for (int y = 0; y < 270; ++y) {
        for (int x = 0; x < 480; ++x) {
            drawn[static_cast<std::size_t>(y / kBlock * kColumns + x / kBlock)] +=
                plane.values[static_cast<std::size_t>(y * 480 + x)] * PixelArea(request.image);
        }
    }
    const Lens& lens = *request.lens;
    const LightBundle bundle(lens, RadiansFromDegrees(7.0), 0.0);
    const Iris iris({}, StopForFNumber(lens, 4.0).semi_diameter_mm, 8.55);
    const double pitch = 36.0 / 480.0;
    for (const BounceSequence& sequence : TwoReflectionSequences(lens)) {
        testing::CountFlux(lens, bundle, sequence, kLineD, iris, 160, [&](Vec2d at, double flux) {
            // Lens space is upside down in the picture; the mirrored half goes to mirrored rows.
            const double px = 240.0 - at.x / pitch;
            for (const double side : {1.0, -1.0}) {
                const double py = 135.0 + side * at.y / pitch;
                if (px < 0.0 || px >= 480.0 || py < 0.0 || py >= 270.0) continue;
                counted[static_cast<std::size_t>(static_cast<int>(py) / kBlock * kColumns +
                                                 static_cast<int>(px) / kBlock)] += 0.5 * flux;
            }
        });
    }
    double difference = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < counted.size(); ++i) {
        difference += std::abs(counted[i] - drawn[i]);
        sum += counted[i];
    }
    RecordProperty("rel_l1", std::to_string(difference / sum));
    EXPECT_GT(sum, 3.0);
    EXPECT_LT(difference / sum, 0.01);
}

TEST(SceneLinear, IsSensorIrradianceTimes4NwSquaredOverPiTAtEveryPixel) {
    Studio studio;
    for (const double f_number : {2.0, 5.6}) {
        FlareRequest request = SeedRequest(160, 90);
        request.lens = testing::BuildLens(testing::SeedLens());
        request.quality = QualityPreset::kDraft;
        request.f_number = f_number;
        request.color = ColorMode::kLinRec709;
        const FlareImage irradiance = studio.Shoot(request).image;
        request.units = Units::kSceneLinear;
        const Rendering scene = studio.Shoot(request);
        // Known figures: wide open a rim leaves f/2.0734; t_axis by tracing the axial ray.
        const double n_w = f_number < 2.1 ? 2.0734 : f_number;
        const InteractionList list = WriteOut(*request.lens, {}, kLineD);
        RayRecord record;
        TraceRay(list, {Vec3d(0.0, 0.0, -5.0), Vec3d(0.0, 0.0, 1.0)}, {}, &record);
        const double factor = 4.0 * n_w * n_w / (kPi * PathWeight(*request.lens, list, record));
        EXPECT_NEAR(scene.report.facts.scene_linear_factor / factor, 1.0, 5e-5);
        EXPECT_NEAR(scene.report.facts.working_f_number, n_w, 5e-5 * n_w);
        for (std::size_t p = 0; p < irradiance.planes.size(); ++p) {
            for (std::size_t i = 0; i < irradiance.planes[p].values.size(); ++i) {
                const double want =
                    irradiance.planes[p].values[i] * scene.report.facts.scene_linear_factor;
                ASSERT_NEAR(scene.image.planes[p].values[i], want, 1e-6 * std::abs(want));
            }
        }
    }
}

// A mesh through 3 wavelengths, and colour: a white light's picture through bare, nearly colourless
// glass is nearly white, and R, G and B together hold the light.
TEST(Colour, OfWhiteLightThroughGlassWithoutDispersionIsWhite) {
    Prescription prescription = testing::SeedLens();
    prescription.default_coating = "bare";
    for (SurfacePrescription& surface : prescription.surfaces) surface.vd.reset();
    Studio studio;
    FlareRequest request = SpectralRequest(testing::BuildLens(prescription), 4.0, 240, 135);
    request.lights = {LightAt(5.0)};
    const FlareImage mono = studio.Shoot(request).image;
    request.color = ColorMode::kLinRec709;
    request.lights[0].irradiance = Vec3d(1.0, 0.5, 0.25);
    const FlareImage colour = studio.Shoot(request).image;
    const double sum = testing::Sum(testing::PlaneNamed(mono, kPlane));
    EXPECT_NEAR(testing::Sum(testing::PlaneNamed(colour, "R")) / sum, 1.0, 1e-3);
    EXPECT_NEAR(testing::Sum(testing::PlaneNamed(colour, "G")) / sum, 0.5, 5e-4);
    EXPECT_NEAR(testing::Sum(testing::PlaneNamed(colour, "B")) / sum, 0.25, 2.5e-4);
    // Everywhere, not only in sum.
    const ImagePlane& r = testing::PlaneNamed(colour, "R");
    const ImagePlane& b = testing::PlaneNamed(colour, "B");
    const double bright = sum / static_cast<double>(r.values.size());
    for (std::size_t i = 0; i < r.values.size(); ++i) {
        ASSERT_NEAR(b.values[i], 0.25 * r.values[i], 1e-4 * (r.values[i] + bright)) << i;
    }
}

}  // namespace
}  // namespace flare
