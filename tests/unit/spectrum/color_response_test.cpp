// SPDX-License-Identifier: Apache-2.0
#include "core/spectrum/color_response.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>

#include "core/spectrum/sampled_curve.h"

namespace flare {
namespace {

void ExpectNear(const Vec3d& got, const Vec3d& want, double tolerance) {
    EXPECT_NEAR(got.x, want.x, tolerance);
    EXPECT_NEAR(got.y, want.y, tolerance);
    EXPECT_NEAR(got.z, want.z, tolerance);
}

// Columns of the matrices that the Academy's reference implementation and colour-science print for
// linear Rec.709 to AP1 and AP0 with Bradford adaptation.
TEST(ColorSpaces, AreReachedByThePublishedMatrices) {
    const Vec3d to_ap1[] = {{0.6130974, 0.0701937, 0.0206156},
                            {0.3395231, 0.9163539, 0.1095698},
                            {0.0473795, 0.0134524, 0.8698146}};
    const Vec3d to_ap0[] = {{0.4396328, 0.0897764, 0.0175412},
                            {0.3829887, 0.8134395, 0.1115466},
                            {0.1773785, 0.0967841, 0.8709122}};
    for (int k = 0; k < 3; ++k) {
        Vec3d primary(0.0);
        primary[k] = 1.0;
        ExpectNear(SpaceFromRec709(ColorSpace::kAcesCg, primary), to_ap1[k], 2e-6);
        ExpectNear(SpaceFromRec709(ColorSpace::kAces2065, primary), to_ap0[k], 2e-6);
    }
}

TEST(ColorSpaces, KeepWhiteAndGoBackAndForth) {
    for (const ColorSpace space :
         {ColorSpace::kLinRec709, ColorSpace::kAcesCg, ColorSpace::kAces2065}) {
        ExpectNear(SpaceFromRec709(space, {1.0, 1.0, 1.0}), {1.0, 1.0, 1.0}, 1e-14);
        ExpectNear(ColorOf(ResponseOf(space), WhiteSpectrum()), {1.0, 1.0, 1.0}, 1e-12);
        const Vec3d rgb(0.3, -0.2, 7.0);
        ExpectNear(Rec709FromSpace(space, SpaceFromRec709(space, rgb)), rgb, 1e-13);
    }
}

// Every real colour lies within AP0: no wavelength has a negative part there but for the locus
// itself running along two of its edges.
TEST(ColorSpaces, Aces2065HoldsEveryWavelength) {
    for (std::size_t i = 0; i < kSpectrumSamples; ++i) {
        const Vec3d rgb = ResponseOf(ColorSpace::kAces2065)[i];
        const double largest = std::max({rgb.x, rgb.y, rgb.z});
        // The adaptation from D65 moves the locus by a little.
        EXPECT_GT(std::min({rgb.x, rgb.y, rgb.z}), -0.02 * largest) << SampleWavelength(int(i));
    }
}

TEST(Camera, IsBalancedToWhiteAndSeesWhatItsCurvesSay) {
    CameraSensitivity camera;
    camera.wavelengths_nm = {400.0, 500.0, 600.0, 700.0};
    camera.red = {0.0, 0.0, 5.0, 0.0};
    camera.green = {0.0, 2.0, 2.0, 0.0};
    camera.blue = {1.0, 1.0, 0.0, 0.0};
    const std::optional<ColorResponse> response = ResponseOf(camera);
    ASSERT_TRUE(response);
    ExpectNear(ColorOf(*response, WhiteSpectrum()), {1.0, 1.0, 1.0}, 1e-12);
    // 450 nm: no red, half of green's peak, all of blue's.
    EXPECT_EQ((*response)[14].x, 0.0);
    EXPECT_NEAR((*response)[14].y / (*response)[24].y, 0.5, 1e-12);
    EXPECT_NEAR((*response)[14].z / (*response)[24].z, 1.0, 1e-12);
}

TEST(Camera, WithoutASenseOfWhiteIsNone) {
    CameraSensitivity camera;
    camera.wavelengths_nm = {900.0, 1000.0};
    camera.red = camera.green = camera.blue = {1.0, 1.0};
    EXPECT_FALSE(ResponseOf(camera));
}

TEST(SampledCurve, OfCoarsePointsIsStraightBetweenThem) {
    const Spectrum power = SpectrumOfCurve({400.0, 420.0, 500.0}, {1.0, 3.0, 3.0});
    EXPECT_EQ(power[3], 0.0);   // 395 nm
    EXPECT_EQ(power[4], 1.0);   // 400 nm
    EXPECT_EQ(power[6], 2.0);   // 410 nm
    EXPECT_EQ(power[20], 3.0);  // 480 nm
    EXPECT_EQ(power[24], 3.0);  // 500 nm
    EXPECT_EQ(power[25], 0.0);
}

// A line of 1 nm between two samples: its area is what the samples hold between them, and its
// centre of gravity stays.
TEST(SampledCurve, KeepsThePowerOfLinesBetweenSamples) {
    const Spectrum power = SpectrumOfCurve({551.0, 552.0, 553.0}, {0.0, 10.0, 0.0});
    double area = 0.0, moment = 0.0;
    for (int i = 0; i < kSpectrumSamples; ++i) {
        area += power[static_cast<std::size_t>(i)] * kSpectrumStep_nm;
        moment += power[static_cast<std::size_t>(i)] * kSpectrumStep_nm * SampleWavelength(i);
    }
    EXPECT_NEAR(area, 10.0, 1e-6);
    EXPECT_NEAR(moment / area, 552.0, 1e-6);
}

}  // namespace
}  // namespace flare
