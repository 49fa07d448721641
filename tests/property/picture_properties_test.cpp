// SPDX-License-Identifier: Apache-2.0
//
// What holds for the picture of any lens: linear in light, sums of lights, turned and mirrored with
// the light, the same for a lens of another size, no more light than came in, continuous in every
// parameter, and nearer to the reference with every finer tolerance.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/optics/lens_state.h"
#include "tests/property/any_lens.h"
#include "tests/support/zoom_lens.h"

namespace flare {
namespace {

using testing::Drawn;
using testing::LightAt;
using testing::LightIn;
using testing::RelL1;
using testing::Studio;

// Two previews of the same thing, each within 0.02 of the truth by its tolerance.
constexpr double kTwoPreviews = 0.03;

RC_GTEST_PROP(AnyPicture, IsLinearInLight, ()) {
    Drawn drawn;
    Studio studio;
    FlareRequest request = testing::AnyRequest(drawn);
    FlareImage one = studio.Shoot(request).image;
    const double k = std::pow(10.0, drawn.Uniform(-15.0, 15.0));
    request.lights[0].irradiance = Vec3d(k, k, k);
    const FlareImage scaled = studio.Shoot(request).image;
    for (ImagePlane& plane : one.planes) {
        for (float& value : plane.values) value = static_cast<float>(value * k);
    }
    RC_ASSERT(RelL1(scaled, one) < 1e-5);
}

RC_GTEST_PROP(AnyPicture, IsTheSumOfItsLights, ()) {
    Drawn drawn;
    Studio studio;
    FlareRequest request = testing::AnyRequest(drawn);
    LightSpec second = LightAt(drawn.Uniform(0.0, 12.0), drawn.Uniform(0.0, 360.0));
    second.distance_m = std::exp(drawn.Uniform(0.0, 6.0));
    second.irradiance = Vec3d(2.0, 1.0, 0.4);
    const LightSpec first = request.lights[0];
    FlareImage sum = studio.Shoot(request).image;
    request.lights = {second};
    const FlareImage other = studio.Shoot(request).image;
    for (std::size_t p = 0; p < sum.planes.size(); ++p) {
        for (std::size_t i = 0; i < sum.planes[p].values.size(); ++i) {
            sum.planes[p].values[i] += other.planes[p].values[i];
        }
    }
    request.lights = {first, second};
    RC_ASSERT(RelL1(studio.Shoot(request).image, sum) < 1e-5);
}

FlareImage Mapped(const FlareImage& image, bool transposed, bool mirrored) {
    FlareImage out = image;
    const int n = image.data.width;
    for (std::size_t p = 0; p < image.planes.size(); ++p) {
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) {
                const int fx = transposed ? y : (mirrored ? n - 1 - x : x);
                const int fy = transposed ? x : y;
                out.planes[p].values[static_cast<std::size_t>(y * n + x)] =
                    image.planes[p].values[static_cast<std::size_t>(fy * n + fx)];
            }
        }
    }
    return out;
}

// Light in the octant across the diagonal, and on the other side of the y axis.
RC_GTEST_PROP(AnyPicture, TurnsAndMirrorsWithTheLight, ()) {
    Drawn drawn;
    Studio studio;
    FlareRequest request = testing::AnyRequest(drawn, {true, 4, true});
    const Vec3d d = *request.lights[0].direction;
    const FlareImage image = studio.Shoot(request).image;
    request.lights[0].direction = Vec3d(-d.x, d.y, d.z);
    RC_ASSERT(RelL1(studio.Shoot(request).image, Mapped(image, false, true)) < kTwoPreviews);
    // Rows go down and y goes up: transposing the picture takes (x, y) to (-y, -x).
    request.lights[0].direction = Vec3d(-d.y, -d.x, d.z);
    RC_ASSERT(RelL1(studio.Shoot(request).image, Mapped(image, true, false)) < kTwoPreviews);
}

RC_GTEST_PROP(AnyPicture, IsTheSameForALensOfAnotherSize, ()) {
    Drawn drawn;
    Studio studio;
    const Prescription lens = testing::RandomPrescription(drawn, {4, false, true, false});
    FlareRequest request;
    request.lens = testing::BuildLens(lens);
    request.f_number = testing::StoppedDown(*request.lens, drawn.Uniform(1.0, 4.0));
    request.image.width = request.image.height = 48;
    request.units = Units::kSensorIrradiance;
    request.model.culling = CullingRule::kNone;
    request.lights = {LightAt(drawn.Uniform(0.0, 15.0), 33.0)};
    const FlareImage image = studio.Shoot(request).image;
    const double k = std::exp(drawn.Uniform(-1.0, 1.0));
    Prescription scaled = lens;
    for (SurfacePrescription& surface : scaled.surfaces) {
        surface.radius_mm *= k;
        surface.gap_mm *= k;
        surface.semi_diameter_mm *= k;
    }
    request.lens = testing::BuildLens(scaled);
    request.image.sensor_width_mm *= k;
    RC_ASSERT(RelL1(studio.Shoot(request).image, image) < kTwoPreviews);
}

RC_GTEST_PROP(AnyPicture, HoldsNoMoreLightThanCameIn, ()) {
    Drawn drawn;
    Studio studio;
    FlareRequest request = testing::AnyRequest(drawn);
    request.color = ColorMode::kSpectral;
    request.wavelengths_nm = {drawn.Uniform(400.0, 700.0)};
    const Rendering rendering = studio.Shoot(request);
    // All that can enter: the front rim, of which a rim that curves back shows no more than a disc
    // half as wide again.
    const double rim = 1.5 * request.lens->surfaces().front().semi_diameter_mm;
    double on_plane = 0.0;
    for (const GhostFacts& ghost : rendering.report.facts.ghosts) {
        RC_ASSERT(ghost.flux_mm2 >= 0.0);
        on_plane += ghost.flux_mm2;
    }
    RC_ASSERT(on_plane <= kPi * rim * rim);
    const double pitch = request.image.sensor_width_mm / request.image.width;
    double in_frame = 0.0;
    for (const ImagePlane& plane : rendering.image.planes) {
        if (plane.name.starts_with("ghosts.")) continue;
        for (const float value : plane.values) RC_ASSERT(value >= 0.0F);
        in_frame += testing::Sum(plane) * pitch * pitch;
    }
    RC_ASSERT(in_frame <= on_plane * (1.0 + 2e-3));
}

// A parameter moved by a hundred-thousandth moves no more light than two previews differ by, and
// all but nothing where the mesh stays as it is.
RC_GTEST_PROP(AnyPicture, IsContinuousInEveryParameter, ()) {
    Drawn drawn;
    Studio studio;
    const FlareRequest request = testing::AnyRequest(drawn, {false, 3, false});
    const FlareImage image = studio.Shoot(request).image;
    RC_PRE(LightIn(image) > 0.0);
    constexpr double kStep = 1e-5;
    FlareRequest moved = request;
    *moved.f_number *= 1.0 + kStep;
    RC_ASSERT(RelL1(studio.Shoot(moved).image, image) < 1e-3);
    moved = request;
    moved.iris = {6, 0.5, 10.0};
    const FlareImage bladed = studio.Shoot(moved).image;
    moved.iris = {6, 0.5 + kStep, 10.0 + kStep};
    RC_ASSERT(RelL1(studio.Shoot(moved).image, bladed) < 1e-3);
    moved = request;
    moved.lights[0].direction->x += kStep;
    RC_ASSERT(RelL1(studio.Shoot(moved).image, image) < kTwoPreviews);
    moved = request;
    moved.lights[0].distance_m = 1e6;
    RC_ASSERT(RelL1(studio.Shoot(moved).image, image) < kTwoPreviews);
    const auto near = SetState(request.lens, {5.0, {}});
    const auto nearer = SetState(request.lens, {5.0 * (1.0 + kStep), {}});
    RC_PRE(near.ok() && nearer.ok());
    moved = request;
    moved.lens = near->lens;
    const FlareImage focused = studio.Shoot(moved).image;
    moved.lens = nearer->lens;
    RC_ASSERT(RelL1(studio.Shoot(moved).image, focused) < 2e-3);
}

RC_GTEST_PROP(AnyZoom, IsContinuousInItsFocalLength, ()) {
    Drawn drawn;
    static const auto kZoom = testing::BuildLens(testing::Zoom());
    Studio studio;
    const double zoom_mm = drawn.Uniform(46.0, 114.0);
    FlareRequest request;
    request.f_number = 8.0;
    request.image.width = request.image.height = 24;
    request.quality = QualityPreset::kDraft;
    request.lights = {LightAt(4.0, 20.0)};
    FlareImage images[2];
    for (int k = 0; k < 2; ++k) {
        const auto state = SetState(kZoom, {{}, zoom_mm + 1e-4 * k});
        RC_ASSERT(state.ok());
        request.lens = state->lens;
        images[k] = studio.Shoot(request).image;
    }
    RC_ASSERT(RelL1(images[1], images[0]) < kTwoPreviews);
}

RC_GTEST_PROP(AnyPicture, ComesNearerWithEveryFinerTolerance, ()) {
    Drawn drawn;
    Studio studio;
    FlareRequest request = testing::AnyRequest(drawn, {false, 3, false});
    request.color = ColorMode::kSpectral;
    request.wavelengths_nm = {550.0};
    request.quality = QualityPreset::kReference;
    const FlareImage reference = studio.Shoot(request).image;
    RC_PRE(LightIn(reference) > 0.0);
    double last = 1.0;
    for (const double tolerance : {0.25, 0.05, 0.02, 0.005, 0.001}) {
        request.quality = Quality::Tolerance(tolerance);
        const double error = RelL1(studio.Shoot(request).image, reference);
        // What is below a tenth of the tolerance is luck.
        RC_ASSERT(error <= std::max(1.1 * last, 0.1 * tolerance));
        RC_ASSERT(error <= 2.0 * tolerance);
        last = error;
    }
}

}  // namespace
}  // namespace flare
