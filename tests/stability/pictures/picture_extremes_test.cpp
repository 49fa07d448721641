// SPDX-License-Identifier: Apache-2.0
//
// Pictures at the ends of their scales: sizes, irradiances, denormal arithmetic, numbers of lights,
// of surfaces and of wavelengths, lights on the axis and in every octant; by the fast engine and by
// the reference.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#if defined(__SSE2__)
#include <pmmintrin.h>
#include <xmmintrin.h>
#endif

#include "core/render/quality.h"
#include "tests/support/extreme_lenses.h"
#include "tests/support/rendering.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::RelL1;
using testing::Singlet;
using testing::Studio;

constexpr QualityPreset kEngines[] = {QualityPreset::kPreview, QualityPreset::kReference};

FlareRequest Small(const Prescription& lens, double field_deg = 6.0) {
    FlareRequest request;
    request.lens = testing::BuildLens(lens);
    request.f_number = 5.6;
    request.image.width = 64;
    request.image.height = 64;
    request.units = Units::kSensorIrradiance;
    request.model.culling = CullingRule::kNone;
    request.lights = {LightAt(field_deg, 25.0)};
    return request;
}

double Light(const FlareImage& image) {
    double sum = 0.0;
    for (const ImagePlane& plane : image.planes) sum += testing::Sum(plane);
    return sum;
}

FlareImage Turned(const FlareImage& image, bool mirrored, int quarters) {
    FlareImage out = image;
    const int n = image.data.width;
    for (std::size_t p = 0; p < image.planes.size(); ++p) {
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) {
                int fx = mirrored ? n - 1 - x : x, fy = y;
                for (int k = 0; k < quarters; ++k) {
                    const int old = fx;
                    fx = fy;
                    fy = n - 1 - old;
                }
                out.planes[p].values[static_cast<std::size_t>(y * n + x)] =
                    image.planes[p].values[static_cast<std::size_t>(fy * n + fx)];
            }
        }
    }
    return out;
}

// The eight symmetries of the pixel grid.
TEST(ALightOnTheAxis, GivesAPictureOfAllEightSymmetries) {
    for (const QualityPreset engine : kEngines) {
        Studio studio;
        FlareRequest request = Small(Singlet(), 0.0);
        request.quality = engine;
        const FlareImage image = studio.Shoot(request).image;
        ASSERT_GT(Light(image), 0.0);
        for (int quarters = 0; quarters < 4; ++quarters) {
            for (const bool mirrored : {false, true}) {
                EXPECT_LT(RelL1(Turned(image, mirrored, quarters), image),
                          engine == QualityPreset::kReference ? 1e-3 : 0.01)
                    << quarters << mirrored;
            }
        }
        request.lights = {LightAt(1e-6, 70.0)};
        EXPECT_LT(RelL1(studio.Shoot(request).image, image),
                  engine == QualityPreset::kReference ? 1e-3 : 0.01);
    }
}

TEST(ALightInEveryOctant, GivesTheSamePictureTurned) {
    for (const QualityPreset engine : kEngines) {
        Studio studio;
        FlareRequest request = Small(Singlet());
        request.quality = engine;
        const FlareImage image = studio.Shoot(request).image;
        const double limit = engine == QualityPreset::kReference ? 1e-3 : 0.01;
        for (int quarters = 1; quarters < 4; ++quarters) {
            request.lights = {LightAt(6.0, 25.0 + 90.0 * quarters)};
            const FlareImage turned = studio.Shoot(request).image;
            const double either = std::min(RelL1(turned, Turned(image, false, quarters)),
                                           RelL1(turned, Turned(image, false, 4 - quarters)));
            EXPECT_LT(either, limit) << quarters;
        }
        request.lights = {LightAt(6.0, 155.0)};  // the light left of the axis, not right
        EXPECT_LT(RelL1(studio.Shoot(request).image, Turned(image, true, 0)), limit);
    }
}

TEST(ThePixelOfAOnePixelImage, HoldsTheFramesLight) {
    Studio studio;
    FlareRequest request = Small(Singlet());
    request.quality = QualityPreset::kReference;
    const double many = Light(studio.Shoot(request).image) / 4096.0;
    request.image.width = request.image.height = 1;
    EXPECT_NEAR(Light(studio.Shoot(request).image) / many, 1.0, 2e-4);
}

TEST(ACropOfA16kImage, IsDrawnAndTheWholeIsRefused) {
    Studio studio;
    FlareRequest request = Small(Singlet());
    request.image.width = request.image.height = 16'384;
    const Result<Rendering> whole = Render(request, studio.Context());
    ASSERT_FALSE(whole.ok());
    EXPECT_EQ(whole.error().code, "too_large");
    EXPECT_EQ(whole.error().where, "/image");
    // The crop's mean is that of the pixel of a coarse picture which it covers.
    FlareRequest coarse = request;
    coarse.image.width = coarse.image.height = 64;
    coarse.image.crop = std::array<int, 4>{40, 36, 1, 1};
    request.image.crop = std::array<int, 4>{40 * 256, 36 * 256, 256, 256};
    for (const QualityPreset engine : kEngines) {
        request.quality = coarse.quality = engine;
        const double fine = Light(studio.Shoot(request).image) / (256.0 * 256.0);
        ASSERT_GT(fine, 0.0);
        EXPECT_NEAR(fine / Light(studio.Shoot(coarse).image), 1.0,
                    engine == QualityPreset::kReference ? 1e-3 : 0.02);
    }
}

TEST(Irradiance, IsAFactorAndNothingElse) {
    for (const QualityPreset engine : kEngines) {
        Studio studio;
        FlareRequest request = Small(Singlet());
        request.quality = engine;
        const FlareImage one = studio.Shoot(request).image;
        double largest = 0.0;
        for (const ImagePlane& plane : one.planes) {
            for (const float v : plane.values) largest = std::max(largest, std::abs(double{v}));
        }
        for (const double k : {1e-30, 1e-10, 1e10, 1e30}) {
            request.lights[0].irradiance = Vec3d(k, k, k);
            const FlareImage scaled = studio.Shoot(request).image;
            for (std::size_t p = 0; p < one.planes.size(); ++p) {
                for (std::size_t i = 0; i < one.planes[p].values.size(); ++i) {
                    ASSERT_NEAR(scaled.planes[p].values[i] / k, one.planes[p].values[i],
                                1e-6 * largest)
                        << k;
                }
            }
        }
        // What a float cannot hold is the largest float, not infinity; what is next to nothing may
        // be denormal or 0.
        for (const double k : {1e-44, 1e300, std::numeric_limits<double>::denorm_min(), 1e300}) {
            request.lights[0].irradiance = Vec3d(k, k, k);
            for (const ImagePlane& plane : studio.Shoot(request).image.planes) {
                for (const float v : plane.values) ASSERT_TRUE(std::isfinite(v)) << k;
            }
        }
    }
}

#if defined(__SSE2__)
// Threads take over the mode of the thread that starts them.
TEST(FlushingDenormals, ChangesNothing) {
    for (const QualityPreset engine : kEngines) {
        for (const double k : {1.0, 1e-36}) {
            FlareRequest request = Small(Singlet());
            request.quality = engine;
            request.lights[0].irradiance = Vec3d(k, k, k);
            const FlareImage exact = Studio().Shoot(request).image;
            const unsigned mode = _mm_getcsr();
            _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
            _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
            const FlareImage flushed = Studio().Shoot(request).image;
            _mm_setcsr(mode);
            ASSERT_GT(Light(exact), 0.0);
            for (std::size_t p = 0; p < exact.planes.size(); ++p) {
                for (std::size_t i = 0; i < exact.planes[p].values.size(); ++i) {
                    ASSERT_NEAR(flushed.planes[p].values[i], exact.planes[p].values[i], 1e-30);
                }
            }
        }
    }
}
#endif

// The lights are one, so that a mesh is traced once: what a hundred thousand cost
// is what adding a light costs.
TEST(AHundredThousandLights, AddUpInOnePicture) {
    Studio studio;
    FlareRequest request = Small(testing::PlanoConvex(), 3.0);
    request.quality = QualityPreset::kDraft;
    request.image.width = request.image.height = 2;
    const double one = Light(studio.Shoot(request).image);
    ASSERT_GT(one, 0.0);
    constexpr int kCount = 500;  // at a time
    request.lights.assign(kCount, request.lights[0]);
    EXPECT_NEAR(Light(studio.Shoot(request).image) / (kCount * one), 1.0, 1e-5);
    request.lights.assign(kMaxLights, request.lights[0]);
    EXPECT_FALSE(CheckRequest(request).has_value());
    request.lights.push_back(request.lights[0]);
    EXPECT_EQ(CheckRequest(request)->where, "/lights");
}

TEST(CoincidentLights, AreOneLight) {
    for (const QualityPreset engine : kEngines) {
        Studio studio;
        FlareRequest request = Small(Singlet());
        request.quality = engine;
        const FlareImage one = studio.Shoot(request).image;
        request.lights.assign(4, request.lights[0]);
        for (LightSpec& light : request.lights) light.irradiance = Vec3d(0.25, 0.25, 0.25);
        EXPECT_LT(RelL1(studio.Shoot(request).image, one), 1e-6);
    }
}

TEST(ALensWhoseGhostsAreAllLeftOut, GivesBlackAndACount) {
    Studio studio;
    FlareRequest request = Small(Singlet());
    request.model.culling = CullingRule::kReport;
    request.image.sensor_width_mm = 0.5;  // every ghost is larger than half of that
    const Rendering rendering = studio.Shoot(request);
    EXPECT_EQ(Light(rendering.image), 0.0);
    EXPECT_EQ(rendering.report.facts.culling.culled, 1U);
    EXPECT_GT(rendering.report.facts.culled_flux_mm2, 0.0);
}

TEST(OneSurface, IsNoLensAndSixtyHave1770Ghosts) {
    // Glass to the sensor is no lens, and neither is a face between air and air.
    Prescription one = testing::Assemble(
        "one", {testing::Stop(2.0, 5.0), testing::Sphere(50.0, 0.0, 1.5, 0.0, 10.0)});
    EXPECT_FALSE(Lens::Build(one).ok());
    one.surfaces[1].nd.reset();
    one.surfaces[1].gap_mm = 30.0;
    one.surfaces[1].gap_given = true;
    EXPECT_FALSE(Lens::Build(one).ok());

    Studio studio;
    FlareRequest request = Small(testing::SixtySurfaces(), 4.0);
    request.quality = QualityPreset::kDraft;
    request.image.width = request.image.height = 16;
    request.f_number = 16.0;
    request.model.culling = CullingRule::kAuto;
    const Rendering sixty = studio.Shoot(request);
    EXPECT_EQ(TwoReflectionSequences(*request.lens).size(), 1770U);
    EXPECT_GT(Light(sixty.image), 0.0);
    for (const ImagePlane& plane : sixty.image.planes) {
        for (const float v : plane.values) ASSERT_TRUE(std::isfinite(v));
    }
    // More than a lens may have.
    Prescription tall = testing::SixtySurfaces();
    const auto once = tall.surfaces;
    tall.surfaces.insert(tall.surfaces.begin(), once.begin(), once.begin() + 42);
    const auto refused = Lens::Build(tall);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, "bad_lens");
}

// No f-number fits an afocal lens; its stop is wide open, whatever is asked.
TEST(AnAfocalLens, IsDrawnWithItsStopWideOpen) {
    Prescription afocal = testing::PlanoConvex();
    afocal.surfaces[1] = testing::Sphere(0.0, 6.0, 1.5, 0.0, 10.0);
    afocal.surfaces[2].gap_given = true;
    afocal.surfaces[2].gap_mm = 30.0;
    for (const QualityPreset engine : kEngines) {
        Studio studio;
        FlareRequest request = Small(afocal);
        request.quality = engine;
        request.f_number.reset();
        const Rendering open = studio.Shoot(request);
        EXPECT_GT(Light(open.image), 0.0);
        EXPECT_TRUE(open.report.facts.clamped.empty());
        EXPECT_TRUE(std::isinf(open.report.facts.f_number));
        request.f_number = 4.0;
        const Rendering asked = studio.Shoot(request);
        EXPECT_EQ(asked.report.facts.clamped.size(), 1U);
        EXPECT_TRUE(asked.image.planes[0].values == open.image.planes[0].values);
    }
}

TEST(ThreadsAndCaches, LeaveTheBitsAlone) {
    for (const QualityPreset engine : kEngines) {
        FlareRequest request = Small(Singlet());
        request.quality = engine;
        Studio one(1);
        const FlareImage cold = one.Shoot(request).image;
        const FlareImage warm = one.Shoot(request).image;
        for (const int threads : {2, 3, 7}) {
            Studio many(threads);
            const FlareImage other = many.Shoot(request).image;
            for (std::size_t p = 0; p < cold.planes.size(); ++p) {
                EXPECT_TRUE(other.planes[p].values == cold.planes[p].values) << threads;
                EXPECT_TRUE(warm.planes[p].values == cold.planes[p].values);
            }
        }
    }
}

Prescription Dispersive() {
    Prescription lens = Singlet();
    lens.surfaces[1].vd = 30.0;
    return lens;
}

TEST(WavelengthsBeyondTheVisible, AreDrawnByBothEngines) {
    const Glass glass = Glass::FromNdVd(1.7, 25.0);
    double last = 10.0;
    for (double wavelength = 300.0; wavelength <= 1100.0; wavelength += 10.0) {
        EXPECT_LT(glass.Index(wavelength), last);
        EXPECT_GE(glass.Index(wavelength), 1.0);
        last = glass.Index(wavelength);
    }
    Studio studio;
    FlareRequest request = Small(Dispersive());
    request.color = ColorMode::kSpectral;
    request.wavelengths_nm = {300.0, 1100.0};
    const FlareImage preview = studio.Shoot(request).image;
    request.quality = QualityPreset::kReference;
    const FlareImage reference = studio.Shoot(request).image;
    for (const ImagePlane& plane : reference.planes) EXPECT_GT(testing::Sum(plane), 0.0);
    EXPECT_LT(RelL1(preview, reference), 0.02);
}

// A picture at many wavelengths holds at each what it holds alone.
TEST(AThousandWavelengths, EachHoldWhatTheyHoldAlone) {
    Studio studio;
    FlareRequest request = Small(Dispersive());
    request.quality = QualityPreset::kDraft;
    request.color = ColorMode::kSpectral;
    request.image.width = request.image.height = 4;
    double last = 1.0;
    for (const int count : {1, 3, 64, 1000}) {
        request.wavelengths_nm.clear();
        for (int k = 0; k < count; ++k) {
            request.wavelengths_nm.push_back(400.0 + 300.0 * (k + 0.5) / count);
        }
        const FlareImage image = studio.Shoot(request).image;
        double mean = 0.0;
        int planes = 0;
        for (const ImagePlane& plane : image.planes) {
            if (plane.name.starts_with("ghosts.")) continue;
            mean += testing::Sum(plane);
            ++planes;
        }
        EXPECT_EQ(planes, count);
        mean /= count;
        // The mean over the band settles: each finer sampling moves it less.
        if (count > 1) {
            EXPECT_LT(std::abs(mean / last - 1.0), 0.2 / std::sqrt(count)) << count;
        }
        last = mean;
    }
}

// A coating of a hundred layers has dozens of fringes over the visible: all colour bands there are.
TEST(AHundredLayersInColour, TakeEveryColourBand) {
    std::vector<CoatingLayer> stack;
    for (int i = 0; i < 50; ++i) {
        stack.push_back({1.46, 550.0 / 4.0 / 1.46});
        stack.push_back({1.60, 550.0 / 4.0 / 1.60});
    }
    Prescription lens = Singlet();
    lens.coatings["own"] = *CoatingDesign::Stack("own", stack);
    lens.default_coating = "own";
    const auto thick = testing::BuildLens(lens);
    const QualitySettings preview = SettingsOf(QualityPreset::kPreview);
    EXPECT_EQ(ColourBandsFor(*thick, preview), kSpectrumSamples);
    lens.default_coating = "mgf2-550";
    EXPECT_EQ(ColourBandsFor(*testing::BuildLens(lens), preview), preview.colour_bands);
    lens.default_coating = "bare";
    EXPECT_EQ(ColourBandsFor(*testing::BuildLens(lens), preview), preview.colour_bands);
}

}  // namespace
}  // namespace flare
