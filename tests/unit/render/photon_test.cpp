// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "core/render/philox.h"
#include "core/render/photon_layer.h"
#include "core/render/render_scene.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

// Known answers of the authors' Random123 distribution (kat_vectors).
TEST(Philox, GivesThePublishedNumbers) {
    EXPECT_EQ(Philox({0, 0, 0, 0}, {0, 0}),
              (PhiloxCounter{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
    constexpr std::uint32_t kOnes = 0xffffffff;
    EXPECT_EQ(Philox({kOnes, kOnes, kOnes, kOnes}, {kOnes, kOnes}),
              (PhiloxCounter{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
    EXPECT_EQ(Philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
              (PhiloxCounter{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

FlareRequest PhotonRequest() {
    FlareRequest request =
        testing::SpectralRequest(testing::BuildLens(testing::PlanoConvex()), 12.0, 12, 8);
    request.quality = QualityPreset::kReference;
    request.photon = PhotonSpec{};
    request.photon->samples = 4096;
    request.lights = {testing::LightAt(3.0)};
    return request;
}

// The light of a ghost on the whole plane, in closed form: paraxially all light within the stop
// arrives, times two reflections and two refractions at normal incidence.
TEST(PhotonLayer, LandsTheLightThatTheStopLetsThrough) {
    testing::Studio studio;
    FlareRequest request = PhotonRequest();
    request.lights = {testing::LightAt(0.0)};
    request.image.sensor_width_mm = 1000.0;
    const Rendering rendering = studio.Shoot(request);
    // f/12 of f = 100 mm: an opening of 100 / 12 mm. R = (0.5 / 2.5)^2 at each of the two faces.
    const double stop = kPi * std::pow(100.0 / 24.0, 2.0);
    const double expected = stop * std::pow(0.04, 2.0) * std::pow(0.96, 2.0);
    const ImagePlane& plane = rendering.image.planes[0];
    const double pixel = 1000.0 / 12.0 * 1000.0 / 12.0;
    EXPECT_NEAR(testing::Sum(plane) * pixel / expected, 1.0, 0.02);
    EXPECT_NEAR(rendering.report.facts.ghosts[0].flux_mm2 / expected, 1.0, 0.1);
    ASSERT_TRUE(rendering.report.facts.photon);
    EXPECT_GT(rendering.report.facts.photon->landed, 400u);
    EXPECT_EQ(rendering.report.facts.ghosts[0].model, "photon");
}

TEST(PhotonLayer, IsTheSameOnAnyNumberOfThreads) {
    FlareRequest request = PhotonRequest();
    for (const PhotonEstimate estimate :
         {PhotonEstimate::kPixel, PhotonEstimate::kKernel, PhotonEstimate::kNearest}) {
        request.photon->estimate = estimate;
        testing::Studio one(1), three(3);
        const FlareImage a = one.Shoot(request).image, b = three.Shoot(request).image;
        ASSERT_EQ(a.planes.size(), b.planes.size());
        ASSERT_EQ(a.planes.back().name, "photon_error.S0.587,5618nm");
        for (std::size_t p = 0; p < a.planes.size(); ++p) {
            for (std::size_t i = 0; i < a.planes[p].values.size(); ++i) {
                ASSERT_EQ(a.planes[p].values[i], b.planes[p].values[i]);
            }
        }
    }
}

TEST(PhotonLayer, FollowsItsSeed) {
    testing::Studio studio;
    FlareRequest request = PhotonRequest();
    const FlareImage first = studio.Shoot(request).image;
    request.photon->seed = 1;
    EXPECT_GT(testing::RelL1(studio.Shoot(request).image, first), 1e-4);
}

// A guide for where to look: it must be small, and hold next to all that arrives.
TEST(PhotonRegion, HoldsWhatArrives) {
    const auto lens = testing::BuildLens(testing::SeedLens());
    FlareRequest request = PhotonRequest();
    request.lens = lens;
    request.f_number = 8.0;
    request.lights = {testing::LightAt(10.0, 30.0)};
    const RenderScene scene(request);
    const PhotonSource source(*lens, *PlaceLight(request, 0));
    TraceOptions options;
    options.iris = &scene.iris;
    int arrived = 0, outside = 0;
    double area = 0.0;
    const std::vector<BounceSequence> sequences = TwoReflectionSequences(*lens);
    for (std::size_t s = 0; s < sequences.size(); s += 5) {
        const PhotonRegion region(*lens, scene.iris, sequences[s], source);
        area += region.area();
        const InteractionList list = WriteOut(*lens, sequences[s], 450.0);
        for (std::uint32_t n = 0; n < 1500; ++n) {
            const PhiloxCounter r = Philox({n, 9, 9, 9}, {1, 2});
            const Vec2d place(UnitFrom(r[0]), UnitFrom(r[1]));
            const auto start = source.At(place, {0.5, 0.5});
            if (!start) continue;
            if (TraceRay(list, start->ray, options, nullptr).fate != RayFate::kArrived) continue;
            ++arrived;
            if (!region.Contains(place)) ++outside;
        }
        for (std::size_t cell = 0; cell < region.cell_count(); ++cell) {
            ASSERT_TRUE(region.Contains(region.Place(cell, {0.5, 0.5})));
        }
    }
    EXPECT_GT(arrived, 50);
    EXPECT_LE(outside, arrived / 100);
    EXPECT_LT(area, 0.5 * 9.0);
}

TEST(PhotonLayer, StopsWhenCancelled) {
    testing::Studio studio;
    FlareRequest request = PhotonRequest();
    request.photon->samples = kMaxPhotonSamples;
    const RenderContext context = studio.Context();
    context.cancel.Cancel();
    const Result<Rendering> rendering = Render(request, context);
    ASSERT_FALSE(rendering);
    EXPECT_EQ(rendering.error().code, "cancelled");
}

TEST(PhotonRequests, AreBounded) {
    FlareRequest request = PhotonRequest();
    EXPECT_FALSE(CheckRequest(request));
    const auto refused = [](const FlareRequest& bad) {
        const std::optional<Error> error = CheckRequest(bad);
        return error ? error->code + " " + error->where : "taken";
    };
    FlareRequest bad = request;
    bad.quality = QualityPreset::kFinal;
    EXPECT_EQ(refused(bad), "bad_value /quality/method");
    bad = request;
    bad.photon->samples = 63;
    EXPECT_EQ(refused(bad), "bad_value /quality/samples");
    bad = request;
    bad.photon->samples = kMaxPhotonSamples;
    bad.lights.resize(1000, bad.lights[0]);
    EXPECT_EQ(refused(bad), "limit /quality/samples");
    bad = request;
    bad.photon->samples = 64;
    bad.lights.resize(65'537, bad.lights[0]);
    EXPECT_EQ(refused(bad), "limit /lights");
    bad = request;
    bad.image.width = bad.image.height = 8192;
    EXPECT_EQ(refused(bad), "limit /image");
    bad = request;
    bad.model.reflections = 4;
    EXPECT_EQ(refused(bad), "unsupported /model/reflections");
    bad = request;
    bad.photon->nearest = 1;
    EXPECT_EQ(refused(bad), "bad_value /quality/nearest");
    bad = request;
    bad.photon->kernel_px = std::nan("");
    EXPECT_EQ(refused(bad), "bad_value /quality/kernel_px");
}

// Photons scattered evenly, by numbers of their own.
std::vector<Photon> EvenPhotons(const PixelWindow& window, double margin, int count,
                                std::uint32_t seed) {
    std::vector<Photon> photons;
    for (int n = 0; n < count; ++n) {
        const PhiloxCounter r = Philox({static_cast<std::uint32_t>(n), 0, 0, 0}, {seed, 77});
        photons.push_back({Vec2d(window.x - margin + UnitFrom(r[0]) * (window.width + 2 * margin),
                                 window.y - margin + UnitFrom(r[1]) * (window.height + 2 * margin)),
                           Vec3d(1.0, 0.5, 2.0)});
    }
    return photons;
}

// Every estimate of an even density has that density as its mean: k - 1 of the k nearest and not k.
TEST(PhotonMap, IsUnbiasedForAnEvenDensity) {
    const PixelWindow window{-3, 5, 12, 10};
    ThreadPool threads(1);
    for (const PhotonEstimate estimate :
         {PhotonEstimate::kPixel, PhotonEstimate::kKernel, PhotonEstimate::kNearest}) {
        PhotonSpec spec;
        spec.estimate = estimate;
        spec.nearest = 6;
        spec.kernel_px = 2.5;
        PhotonMap map(window, 2, spec);
        double sum = 0.0, second = 0.0;
        constexpr int kPictures = 60;
        const double margin = map.margin();
        const double area = (window.width + 2 * margin) * (window.height + 2 * margin);
        const int count = static_cast<int>(area);  // one photon a pixel
        for (std::uint32_t picture = 0; picture < kPictures; ++picture) {
            map.Clear();
            map.Add(EvenPhotons(window, margin, count, picture));
            const std::vector<double>& light = map.Light(threads, CancelToken());
            ASSERT_EQ(light.size(), 2 * window.pixels());
            for (std::size_t i = 0; i < window.pixels(); ++i) {
                sum += light[i];
                second += light[window.pixels() + i];
            }
        }
        const double mean = sum / (kPictures * static_cast<double>(window.pixels()));
        const double density = count / area;
        // 7 200 photons at least: 1.2 % of noise; k in place of k - 1 would be 20 % off.
        EXPECT_NEAR(mean / density, 1.0, 0.04) << static_cast<int>(estimate);
        EXPECT_NEAR(second / sum, 0.5, 1e-12);
    }
}

// Fewer photons about than k: those within the reach count.
TEST(PhotonMap, OfTooFewPhotonsTakesTheReach) {
    const PixelWindow window{0, 0, 1, 1};
    PhotonSpec spec;
    spec.estimate = PhotonEstimate::kNearest;
    spec.nearest = 10;
    ThreadPool threads(1);
    PhotonMap map(window, 1, spec);
    map.Add(std::vector<Photon>{{Vec2d(0.5, 10.5), Vec3d(3.0, 0.0, 0.0)},
                                {Vec2d(-12.0, 0.5), Vec3d(4.0, 0.0, 0.0)},
                                {Vec2d(-15.0, -15.0), Vec3d(100.0, 0.0, 0.0)}});
    EXPECT_NEAR(map.Light(threads, CancelToken())[0], 7.0 / (kPi * 256.0), 1e-12);
}

// The nearest k, found ring by ring, are those of a plain search.
TEST(PhotonMap, FindsTheNearest) {
    const PixelWindow window{0, 0, 9, 7};
    PhotonSpec spec;
    spec.estimate = PhotonEstimate::kNearest;
    spec.nearest = 12;
    ThreadPool threads(1);
    PhotonMap map(window, 1, spec);
    const std::vector<Photon> photons = EvenPhotons(window, 16.0, 700, 5);
    map.Add(photons);
    const std::vector<double> light = map.Light(threads, CancelToken());
    for (int y = 0; y < window.height; ++y) {
        for (int x = 0; x < window.width; ++x) {
            std::vector<double> distances;
            for (const Photon& photon : photons) {
                distances.push_back((photon.pixel - Vec2d(x + 0.5, y + 0.5)).length());
            }
            std::sort(distances.begin(), distances.end());
            const double expected = 11.0 / (kPi * distances[11] * distances[11]);
            EXPECT_NEAR(light[static_cast<std::size_t>(y * window.width + x)], expected,
                        1e-9 * expected);
        }
    }
}

}  // namespace
}  // namespace flare
