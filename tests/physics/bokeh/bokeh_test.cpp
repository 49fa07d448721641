// SPDX-License-Identifier: Apache-2.0
//
// The direct image of a light against what it must be: the light of the beam (area times
// transmittance), pictures of counted rays, the blur disc of a perfect lens, the iris's shape and
// which way up it stands. None of the references knows meshes, polygons or pixels' edges.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/optics/lens_state.h"
#include "core/optics/paraxial.h"
#include "core/render/beam_outline.h"
#include "core/render/lights.h"
#include "tests/support/brute_force.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::PlaneNamed;
using testing::Studio;
using testing::Sum;

constexpr const char* kPlane = "bokeh.S0.587,5618nm";

FlareRequest Bokeh(std::shared_ptr<const Lens> lens, double f_number, int width, int height,
                   double sensor_width_mm = 36.0) {
    FlareRequest request = testing::SpectralRequest(std::move(lens), f_number, width, height);
    request.image.sensor_width_mm = sensor_width_mm;
    request.layers = {false, false, true};
    return request;
}

double PixelArea(const FlareRequest& request) {
    const Vec2d pitch = PixelPitch(request);
    return pitch.x * pitch.y;
}

double Flux(const FlareRequest& request, const FlareImage& image) {
    return Sum(PlaneNamed(image, kPlane)) * PixelArea(request);
}

std::shared_ptr<const Lens> Focused(const std::shared_ptr<const Lens>& base, double focus_m,
                                    std::optional<double> zoom_mm = std::nullopt) {
    const Result<LensInState> set = SetState(base, {focus_m, zoom_mm});
    FLARE_CHECK(set.ok());
    return set->lens;
}

// A plane and a hyperboloid: parallel light on the axis meets in one point (conic -n^2), 50 mm
// behind the vertex. The stop stands in front; `sensor_mm` is the last gap.
std::shared_ptr<const Lens> PerfectLens(double sensor_mm) {
    constexpr double kIndex = 1.5;
    Prescription lens;
    lens.name = "perfect";
    SurfacePrescription stop, front, back;
    stop.kind = SurfaceKind::kStop;
    stop.gap_mm = 2.0;
    stop.semi_diameter_mm = 8.0;
    front.kind = SurfaceKind::kPlane;
    front.gap_mm = 8.0;
    front.nd = kIndex;
    front.semi_diameter_mm = 14.0;
    back.kind = SurfaceKind::kAsphere;
    back.radius_mm = -(kIndex - 1.0) * 50.0;
    back.conic = -kIndex * kIndex;
    back.gap_mm = sensor_mm;
    back.gap_given = true;
    back.semi_diameter_mm = 14.0;
    lens.surfaces = {stop, front, back};
    return testing::BuildLens(lens);
}

TEST(Bokeh, HoldsTheLightOfTheBeamWhateverTheFocusAndTheField) {
    Studio studio;
    const auto seed = testing::BuildLens(testing::SeedLens());
    ThreadPool threads(2);
    for (const double focus_m : {1e9, 0.7}) {
        for (const double field_deg : {0.0, 8.0, 14.0}) {
            FlareRequest request = Bokeh(Focused(seed, focus_m), 2.8, 180, 120);
            request.iris = {6, 0.1, 12.0};
            request.lights = {LightAt(field_deg, 30.0)};
            const Rendering shot = studio.Shoot(request);
            // The beam's outline by exact rays, its mean transmittance: no mesh.
            const Result<PlacedLight> light = PlaceLight(request, 0);
            const Lens& lens = *request.lens;
            const Iris iris(request.iris, StopForFNumber(lens, 2.8).semi_diameter_mm, 8.55);
            const LightBundle bundle = BundleOf(lens, *light);
            const auto beam = FindBeamOutline(lens, bundle, light->pose, iris, kLineD, threads);
            ASSERT_TRUE(beam);
            const double want = beam->area_mm2 * BeamTransmittance(lens, bundle, *beam, kLineD);
            EXPECT_NEAR(Flux(request, shot.image), want, 0.002 * want) << field_deg;
            EXPECT_NEAR(shot.report.facts.bokeh->flux_mm2, want, 0.002 * want) << field_deg;
            EXPECT_EQ(shot.report.facts.bokeh->lights, 1U);
        }
    }
}

// On the axis in closed form: the entrance pupil's area times t_axis. Real pupils are larger than
// paraxial ones, here by 0.7 % at f/2.8.
TEST(Bokeh, OnTheAxisHoldsThePupilsAreaTimesTheTransmittance) {
    Studio studio;
    for (const double f_number : {8.0, 16.0}) {
        FlareRequest request = Bokeh(testing::BuildLens(testing::SeedLens()), f_number, 180, 120);
        request.lights = {LightAt(0.0)};
        const Lens& lens = *request.lens;
        const double diameter = lens.first_order().efl_mm / f_number;
        const double want = kPi / 4.0 * diameter * diameter * AxialTransmittance(lens, kLineD);
        EXPECT_NEAR(Flux(request, studio.Shoot(request).image), want, 0.002 * want);
    }
}

struct Case {
    const char* name;
    const char* lens;
    double f_number, focus_m, zoom_mm, field_deg, azimuth_deg, distance_m;
};
constexpr Case kCases[] = {
    {"seed defocused", testing::kSeedName, 2.0, 1.0, 0.0, 12.0, 70.0, 0.0},
    {"seed near light", testing::kSeedName, 2.8, 2.0, 0.0, 6.0, -20.0, 0.45},
    {"fisheye", testing::kFisheyeName, 2.8, 1e9, 0.0, 95.0, 200.0, 0.5},
    {"anamorphic", "schneider-anamorphic-31mm-f2", 2.8, 1e9, 0.0, 9.0, 33.0, 0.8},
    {"zoom", "canon-zoom-70-200mm-f2_8", 4.0, 2.5, 135.0, 4.0, 10.0, 0.0},
};

LightSpec LightOf(const Case& at) {
    LightSpec light = LightAt(at.field_deg, at.azimuth_deg);
    if (at.distance_m > 0.0) light.distance_m = at.distance_m;
    return light;
}

// Counted rays on the same pixels, box means of 5 x 5 of both pictures: what is left is the rays'
// noise.
TEST(Bokeh, LooksLikeCountedRays) {
    Studio studio;
    for (const Case& at : kCases) {
        std::optional<double> zoom;
        if (at.zoom_mm > 0.0) zoom = at.zoom_mm;
        const auto lens = Focused(testing::LibraryLens(at.lens), at.focus_m, zoom);
        FlareRequest request = Bokeh(lens, at.f_number, 1, 1);
        request.iris = {5, 0.0, 40.0};
        request.lights = {LightOf(at)};
        const Result<PlacedLight> light = PlaceLight(request, 0);
        ASSERT_TRUE(light.ok()) << at.name << ": " << light.error().message;
        const Iris iris(
            request.iris, StopForFNumber(*lens, at.f_number).semi_diameter_mm,
            lens->surfaces()[static_cast<std::size_t>(lens->stop_index())].semi_diameter_mm);
        const LightBundle bundle = BundleOf(*lens, *light);

        // The iris does not turn with the light: rays meet it in lens space.
        struct Hit {
            Vec2d at;
            double flux;
        };
        std::vector<Hit> hits;
        const InteractionList list = WriteOut(*lens, {}, kLineD);
        TraceOptions options;
        options.clip = false;
        RayRecord record;
        const auto box = testing::LookForArrivals(
            list, bundle, {true, nullptr, false},
            {bundle.centre_u() - bundle.half_width(), bundle.centre_u() + bundle.half_width(),
             bundle.mirror_symmetric() ? 0.0 : -bundle.half_width(), bundle.half_width(), false},
            std::max(128, static_cast<int>(4.0 * bundle.half_width())));
        ASSERT_FALSE(box.empty) << at.name;
        const double v0 = bundle.mirror_symmetric() ? -box.v1 : box.v0;
        constexpr int kSide = 250;
        const double du = (box.u1 - box.u0) / kSide, dv = (box.v1 - v0) / kSide;
        double counted = 0.0;
        Vec2d lo(1e9, 1e9), hi(-1e9, -1e9);
        for (int j = 0; j < kSide; ++j) {
            for (int i = 0; i < kSide; ++i) {
                const double u = box.u0 + (i + ((j * 7) % 16) / 16.0) * du;
                const double v = v0 + (j + 0.5) * dv;
                const TraceResult ray = TraceRay(list, bundle.At(u, v), options, &record);
                if (ray.fate != RayFate::kArrived || ray.max_rim_ratio2 > 1.0) continue;
                const Vec2d stop = light->pose.LensSpace(record.stop_mm.front());
                bool open = true;
                for (int k = 0; k < iris.edge_count(); ++k) {
                    open = open && iris.EdgeDistance(k, stop) <= 0.0;
                }
                if (!open) continue;
                const double flux = PathWeight(*lens, list, record) * bundle.FluxDensity(u, v);
                hits.push_back({light->pose.LensSpace(ray.sensor_mm), flux * du * dv});
                counted += hits.back().flux;
                lo = {std::min(lo.x, hits.back().at.x), std::min(lo.y, hits.back().at.y)};
                hi = {std::max(hi.x, hits.back().at.x), std::max(hi.y, hits.back().at.y)};
            }
        }
        ASSERT_GT(hits.size(), 10'000U) << at.name;
        // A frame around them, on a sensor shifted to where they land: 60 x 60 pixels.
        constexpr int kPixels = 60;
        const double width = 1.25 * std::max(hi.x - lo.x, hi.y - lo.y);
        const Vec2d middle = (lo + hi) * 0.5;
        request.image.width = request.image.height = kPixels;
        request.image.sensor_width_mm = width;
        request.image.center_offset_mm = middle;
        const FlareImage image = studio.Shoot(request).image;
        EXPECT_NEAR(Flux(request, image), counted, 0.005 * counted) << at.name;

        std::vector<double> splat(kPixels * kPixels);
        for (const Hit& hit : hits) {
            // Upright: the picture is turned by half a turn.
            const double px = 0.5 * kPixels - (hit.at.x - middle.x) / width * kPixels;
            const double py = 0.5 * kPixels + (hit.at.y - middle.y) / width * kPixels;
            splat[static_cast<std::size_t>(static_cast<int>(py) * kPixels +
                                           static_cast<int>(px))] += hit.flux;
        }
        double difference = 0.0;
        for (int j = 0; j < kPixels; j += 5) {
            for (int i = 0; i < kPixels; i += 5) {
                double ours = 0.0, rays = 0.0;
                for (int k = 0; k < 25; ++k) {
                    const auto n = static_cast<std::size_t>((j + k / 5) * kPixels + i + k % 5);
                    ours += PlaneNamed(image, kPlane).values[n] * PixelArea(request);
                    rays += splat[n];
                }
                difference += std::abs(ours - rays);
            }
        }
        std::printf("%-16s flux %+.4f %%  rel_l1 %.4f\n", at.name,
                    100.0 * (Flux(request, image) / counted - 1.0), difference / counted);
        EXPECT_LT(difference, 0.02 * counted) << at.name;
    }
}

TEST(Bokeh, OfAPerfectLensInFocusIsOnePixelWithAllTheLight) {
    Studio studio;
    const auto lens = PerfectLens(50.0);
    // A pixel's middle on the axis, and the axis on a corner of four pixels.
    for (const int width : {101, 100}) {
        FlareRequest request = Bokeh(lens, 4.0, width, width, 2.0);
        request.lights = {LightAt(0.0)};
        const Rendering shot = studio.Shoot(request);
        const std::vector<float>& values = PlaneNamed(shot.image, kPlane).values;
        double peak = 0.0, all = 0.0;
        int lit = 0;
        for (const float value : values) {
            ASSERT_TRUE(std::isfinite(value));
            peak = std::max(peak, static_cast<double>(value));
            all += value;
            lit += value > 1e-3F ? 1 : 0;
        }
        const double diameter = lens->first_order().efl_mm / 4.0;
        const double want = kPi / 4.0 * diameter * diameter * AxialTransmittance(*lens, kLineD);
        EXPECT_NEAR(all * PixelArea(request), want, 0.003 * want);
        EXPECT_EQ(lit, width == 101 ? 1 : 4);
        // On the corner the last bits of the traced rays decide, no more than that.
        EXPECT_NEAR(peak, width == 101 ? all : 0.25 * all, width == 101 ? 1e-6 * all : 0.2 * peak);
    }
}

// The blur of a perfect lens is |defocus| times the beam's angle: a disc of |defocus| / N (to the
// cosine by which real rays differ from paraxial ones: at f/8 less than 0.3 %).
TEST(Bokeh, OfAPerfectLensIsADiscOfDefocusOverN) {
    Studio studio;
    for (const double defocus_mm : {-2.0, -0.5, 0.5, 2.0}) {
        const auto lens = PerfectLens(50.0 + defocus_mm);
        FlareRequest request = Bokeh(lens, 8.0, 240, 240, 0.4);
        request.lights = {LightAt(0.0)};
        const FlareImage image = studio.Shoot(request).image;
        const std::vector<float>& values = PlaneNamed(image, kPlane).values;
        const float half = 0.5F * values[120 * 240 + 120];
        const auto inside =
            std::count_if(values.begin(), values.end(), [&](float value) { return value > half; });
        const double diameter = 2.0 * std::sqrt(static_cast<double>(inside) / kPi) * 0.4 / 240.0;
        EXPECT_NEAR(diameter, std::abs(defocus_mm) / 8.0, 0.006 * std::abs(defocus_mm) / 8.0 + 5e-4)
            << defocus_mm;
    }
}

// Three blades, a corner up. Behind the focus the rays have crossed and the sensor's picture is
// turned back by the viewer: the triangle stands as it does in the lens. In front of the focus it
// stands on its head.
TEST(Bokeh, ShowsTheIrisUprightBehindTheFocusAndInvertedBeforeIt) {
    Studio studio;
    for (const double defocus_mm : {-3.0, 3.0}) {
        FlareRequest request = Bokeh(PerfectLens(50.0 + defocus_mm), 4.0, 90, 90, 1.5);
        request.lights = {LightAt(0.0)};
        for (const double rotation_deg : {0.0, 90.0}) {
            request.iris = {3, 0.0, rotation_deg};
            const FlareImage image = studio.Shoot(request).image;
            const std::vector<float>& values = PlaneNamed(image, kPlane).values;
            // A triangle's third moment points to its corner.
            double up = 0.0, right = 0.0, all = 0.0;
            for (int j = 0; j < 90; ++j) {
                for (int i = 0; i < 90; ++i) {
                    const double light = values[static_cast<std::size_t>(j * 90 + i)];
                    up += light * std::pow((44.5 - j) / 90.0, 3);
                    right += light * std::pow((i - 44.5) / 90.0, 3);
                    all += light;
                }
            }
            const double size = 1e-4 * all;
            const double side = defocus_mm > 0.0 ? 1.0 : -1.0;
            if (rotation_deg == 0.0) {
                EXPECT_GT(side * up, size) << defocus_mm;
                EXPECT_LT(std::abs(right), 0.05 * std::abs(up));
            } else {
                // Anticlockwise by a quarter turn: the corner points to the left.
                EXPECT_LT(side * right, -size) << defocus_mm;
                EXPECT_LT(std::abs(up), 0.05 * std::abs(right));
            }
        }
    }
}

// Through glass without dispersion white stays white; through the seed lens colours part, and no
// channel loses light to it.
TEST(Bokeh, InColourHoldsTheSameLightAsItsWavelengths) {
    Studio studio;
    Prescription plain = testing::SeedLens();
    plain.default_coating = "bare";
    for (SurfacePrescription& surface : plain.surfaces) surface.vd.reset();
    FlareRequest request = Bokeh(testing::BuildLens(plain), 4.0, 120, 80);
    request.lights = {LightAt(9.0, 20.0)};
    const double mono = Sum(PlaneNamed(studio.Shoot(request).image, kPlane));
    request.color = ColorMode::kLinRec709;
    const FlareImage image = studio.Shoot(request).image;
    for (const char* name : {"bokeh.R", "bokeh.G", "bokeh.B"}) {
        EXPECT_NEAR(Sum(PlaneNamed(image, name)), mono, 1e-3 * mono) << name;
    }
}

}  // namespace
}  // namespace flare
