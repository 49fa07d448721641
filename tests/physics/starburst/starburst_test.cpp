// SPDX-License-Identifier: Apache-2.0
//
// The starburst as a picture, against closed forms: Airy's pattern in absolute light, spikes by
// blades, energy whatever the pixels, the beam's outline, and a disc against many points.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/optics/paraxial.h"
#include "core/render/beam_outline.h"
#include "core/render/lights.h"
#include "core/tracing/field_data.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::Studio;

constexpr double kWavelength_nm = 550.0;
constexpr double kWavelength_mm = 550e-6;

FlareRequest Starburst(double f_number, int width, int height, double sensor_width_mm) {
    FlareRequest request =
        testing::SpectralRequest(testing::BuildLens(testing::SeedLens()), f_number, width, height);
    request.image.sensor_width_mm = sensor_width_mm;
    request.wavelengths_nm = {kWavelength_nm};
    request.layers = {false, true};
    request.lights = {LightAt(0.0)};
    return request;
}

const std::vector<float>& Values(const FlareImage& image) {
    return testing::PlaneNamed(image, "starburst.S0.550nm").values;
}

double Pitch(const FlareRequest& request) {
    return request.image.sensor_width_mm / request.image.width;
}

double Light(const FlareRequest& request, const FlareImage& image) {
    double sum = 0.0;
    for (const float value : Values(image)) sum += value;
    return sum * Pitch(request) * Pitch(request);
}

// How far from pixel (x, y) towards (dx, dy) the first dark ring lies, in pixels: the lowest point
// of the parabola through the darkest pixel and its neighbours.
double DarkRing(const FlareImage& image, int x, int y, int dx, int dy) {
    const auto light = [&](int i) -> double {
        const int at = (y + i * dy) * image.data.width + x + i * dx;
        return Values(image)[static_cast<std::size_t>(at)];
    };
    int least = 1;
    while (light(least + 1) < light(least)) ++least;
    const double a = light(least - 1), b = light(least), c = light(least + 1);
    return least + 0.5 * (a - c) / (a - 2.0 * b + c);
}

TEST(Starburst, OfARoundIrisAtF22IsAirysDiscInAbsoluteLight) {
    Studio studio;
    FlareRequest request = Starburst(22.0, 401, 401, 0.2005);
    request.quality = QualityPreset::kFinal;
    const Rendering shot = studio.Shoot(request);
    ASSERT_TRUE(shot.report.facts.starburst);
    const double flux = shot.report.facts.starburst->flux_mm2;
    const double t = AxialTransmittance(*request.lens, kWavelength_nm);
    const double diameter = request.lens->first_order().efl_mm / 22.0;
    EXPECT_NEAR(flux, t * kPi / 4.0 * diameter * diameter, 0.002 * flux);

    const double lambda_n = kWavelength_mm * 22.0;
    const double peak = Values(shot.image)[200 * 401 + 200];
    EXPECT_NEAR(peak, flux * kPi / (4.0 * lambda_n * lambda_n), 0.01 * peak);
    for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {-1, 0}}) {
        const double zero = DarkRing(shot.image, 200, 200, dx, dy) * Pitch(request);
        EXPECT_NEAR(zero, 1.21967 * lambda_n, 0.005 * zero);
    }
    double inside = 0.0;
    for (int j = 0; j < 401; ++j) {
        for (int i = 0; i < 401; ++i) {
            if (std::hypot(i - 200, j - 200) * Pitch(request) > 1.21967 * lambda_n) continue;
            inside += Values(shot.image)[static_cast<std::size_t>(j * 401 + i)];
        }
    }
    EXPECT_NEAR(inside * Pitch(request) * Pitch(request), 0.83778 * flux, 0.01 * flux);
    EXPECT_NEAR(shot.report.facts.starburst->core_share, 0.83778, 0.003);
}

TEST(Starburst, HoldsTheSameLightWhateverTheImageAndItsPixels) {
    Studio studio;
    for (const double f_number : {2.8, 16.0}) {
        for (const int width : {60, 240, 720}) {
            FlareRequest request = Starburst(f_number, width, width * 2 / 3, 36.0);
            request.iris = {6, 0.0, 10.0};
            const Rendering shot = studio.Shoot(request);
            const double flux = shot.report.facts.starburst->flux_mm2;
            EXPECT_NEAR(Light(request, shot.image), flux, 0.01 * flux) << f_number << " " << width;
        }
        // A small image holds what is not in the tails: 1 mm is hundreds of fringes.
        FlareRequest request = Starburst(f_number, 200, 200, 2.0);
        request.iris = {6, 0.0, 10.0};
        const Rendering shot = studio.Shoot(request);
        const double flux = shot.report.facts.starburst->flux_mm2;
        EXPECT_NEAR(Light(request, shot.image), flux, 0.01 * flux) << f_number;
    }
}

// At 20 degrees the pattern is wider along the meridian than across it: by the beam, narrower
// there, and by the chief ray's own two scales, 54.99 and 53.01 mm a radian (differences of chief
// rays found by `flare trace`, 587.6 nm).
TEST(Starburst, HasTheChiefRaysTwoScalesOffTheAxis) {
    Studio studio;
    ThreadPool threads(2);
    FlareRequest request = Starburst(22.0, 401, 401, 0.2005);
    request.quality = QualityPreset::kFinal;
    request.lights = {LightAt(20.0)};
    const PlacedLight light = *PlaceLight(request, 0);
    const LightBundle bundle = BundleOf(*request.lens, light);
    const Iris iris(request.iris, StopForFNumber(*request.lens, 22.0).semi_diameter_mm, 20.0);
    const auto beam =
        FindBeamOutline(*request.lens, bundle, light.pose, iris, kWavelength_nm, threads);
    ASSERT_TRUE(beam);
    Vec2d lo(1e300, 1e300), hi(-1e300, -1e300);
    for (const EdgePiece& piece : beam->edge.pieces) {
        for (const Vec2d& p : piece) {
            lo = {std::min(lo.x, p.x), std::min(lo.y, p.y)};
            hi = {std::max(hi.x, p.x), std::max(hi.y, p.y)};
        }
    }
    EXPECT_LT(hi.x - lo.x, 0.98 * (hi.y - lo.y));
    // The frame's middle on the light's image.
    const Vec2d sensor = studio.Shoot(request).report.facts.lights[0].sensor_mm;
    request.image.center_offset_mm = Vec2d(0.0, 0.0) - sensor;
    const FlareImage image = studio.Shoot(request).image;
    const auto brightest = std::max_element(Values(image).begin(), Values(image).end());
    const auto at = static_cast<int>(brightest - Values(image).begin());
    const auto ring = [&](int dx, int dy) {
        return 0.5 * Pitch(request) *
               (DarkRing(image, at % 401, at / 401, dx, dy) +
                DarkRing(image, at % 401, at / 401, -dx, -dy));
    };
    const double meridional = 1.21967 * kWavelength_mm * 54.99 / (hi.x - lo.x);
    const double sagittal = 1.21967 * kWavelength_mm * 53.01 / (hi.y - lo.y);
    EXPECT_NEAR(ring(1, 0), meridional, 0.007 * meridional);
    EXPECT_NEAR(ring(0, 1), sagittal, 0.007 * sagittal);
}

// At f/2.8 a pixel of 0.11 mm is wider than all of the near pattern: from the light's pixel
// outwards the light falls off as 1 / r^3 does, from the very next pixel on.
TEST(Starburst, LeavesNoGapBesideTheLight) {
    Studio studio;
    const FlareRequest request = Starburst(2.8, 321, 215, 36.0);
    const Rendering shot = studio.Shoot(request);
    const std::vector<float>& light = Values(shot.image);
    const double pitch = Pitch(request);
    const double flux = shot.report.facts.starburst->flux_mm2;
    const double diameter = request.lens->first_order().efl_mm / 2.8;
    // Airy's rings in the mean: D / (4 pi^2 k^3), k = r / (lambda f), over the area and each pixel.
    const double scale = kWavelength_mm * request.lens->first_order().efl_mm;
    const double ring =
        flux * diameter * scale / (4.0 * kPi * kPi * 0.25 * kPi * diameter * diameter);
    for (int i = 1; i <= 4; ++i) {
        constexpr int kParts = 40;
        double mean = 0.0;
        for (int p = 0; p < kParts * kParts; ++p) {
            const double x = (i - 0.5 + (p % kParts + 0.5) / kParts) * pitch;
            const double y = (-0.5 + (p / kParts + 0.5) / kParts) * pitch;
            mean += ring / std::pow(std::hypot(x, y), 3.0) / (kParts * kParts);
        }
        for (const int to : {-i, i}) {
            const auto at = static_cast<std::size_t>(107 * 321 + 160 + to);
            EXPECT_NEAR(light[at], mean, 0.1 * mean) << to;
        }
    }
}

TEST(Starburst, HasASpikeForEachBladeOrTwo) {
    Studio studio;
    for (const auto& [blades, spikes] : {std::pair{6, 6}, {7, 14}}) {
        FlareRequest request = Starburst(8.0, 301, 301, 6.0);
        request.iris = {blades, 0.0, 0.0};
        const FlareImage image = studio.Shoot(request).image;
        // Light by angle, in a ring 60 to 140 pixels from the middle.
        constexpr int kBins = 180;
        std::vector<double> by_angle(kBins, 0.0);
        double mean = 0.0;
        for (int j = 0; j < 301; ++j) {
            for (int i = 0; i < 301; ++i) {
                const double radius = std::hypot(i - 150, j - 150);
                if (radius < 60.0 || radius > 140.0) continue;
                const double angle = std::atan2(150 - j, i - 150) / (2.0 * kPi) + 1.0;
                const double light = Values(image)[static_cast<std::size_t>(j * 301 + i)];
                by_angle[static_cast<std::size_t>(angle * kBins) % kBins] += light;
                mean += light / kBins;
            }
        }
        int found = 0;
        for (std::size_t k = 0; k < kBins; ++k) {
            const bool high = by_angle[k] > 1.5 * mean;
            found += high && !(by_angle[(k + kBins - 1) % kBins] > 1.5 * mean) ? 1 : 0;
        }
        EXPECT_EQ(found, spikes);
        // Corner at +y, so a side's normal, and a spike, 30 degrees (6 blades) off.
        const double spike = blades == 6 ? 60.0 : 90.0 - 180.0 / 7.0;
        EXPECT_GT(by_angle[static_cast<std::size_t>(spike / 2.0)] +
                      by_angle[static_cast<std::size_t>(spike / 2.0) - 1],
                  3.0 * mean);
    }
}

TEST(BeamOutline, HasTheAreaThatChordsOfRaysMeasure) {
    ThreadPool threads(2);
    for (const char* name : {"tronnier-double-gauss-50mm-f2", "canon-85mm-f1_2-spherical"}) {
        const std::shared_ptr<const Lens> lens =
            testing::BuildLens(testing::LibraryPrescription(name));
        FieldOptions options;
        options.rows = 4;
        const FieldData data = FieldDataOf(*lens, options);
        const double radius =
            lens->surfaces()[static_cast<std::size_t>(lens->stop_index())].semi_diameter_mm;
        for (const FieldRow& row : data.tables.front().rows) {
            const LightBundle bundle(*lens, row.field_rad, 0.0);
            const std::optional<BeamOutline> beam =
                FindBeamOutline(*lens, bundle, {}, Iris({}, radius, radius), kLineD, threads);
            ASSERT_TRUE(beam);
            EXPECT_NEAR(beam->area_mm2, row.beam_area_mm2, 1.5e-3 * row.beam_area_mm2) << name;
            EXPECT_NEAR(BeamTransmittance(*lens, bundle, *beam, kLineD), *row.transmittance, 3e-3);
        }
    }
}

TEST(Starburst, OfADiscIsThatOfManyPoints) {
    Studio studio;
    FlareRequest request = Starburst(5.6, 120, 120, 6.0);
    request.iris = {5, 0.0, 0.0};
    request.lights = {LightAt(1.0)};
    request.lights[0].angular_diameter_deg = 1.0;
    const Rendering shot = studio.Shoot(request);
    const FlareImage& disc = shot.image;
    const Vec2d at = shot.report.facts.lights.at(0).pixel;
    FlareRequest points = request;
    points.lights.clear();
    constexpr int kPoints = 40;
    for (int i = 0; i < kPoints; ++i) {
        // Evenly over the disc (a sunflower's spiral).
        const double r = RadiansFromDegrees(0.5) * std::sqrt((i + 0.5) / kPoints);
        const double angle = i * kPi * (3.0 - std::sqrt(5.0));
        const double tilt = RadiansFromDegrees(1.0) + r * std::cos(angle);
        LightSpec light;
        light.direction = Vec3d(-std::tan(tilt), -std::tan(r * std::sin(angle)), 1.0);
        light.irradiance = Vec3d(1.0, 1.0, 1.0) / kPoints;
        points.lights.push_back(light);
    }
    const FlareImage many = studio.Shoot(points).image;
    // Off the disc, in blocks of 8 x 8 pixels: the points are 3 apart.
    double difference = 0.0, sum = 0.0;
    for (int j = 0; j < 120; j += 8) {
        for (int i = 0; i < 120; i += 8) {
            if (std::hypot(i + 4 - at.x, j + 4 - at.y) < 18.0) continue;
            double a = 0.0, b = 0.0;
            for (int k = 0; k < 64; ++k) {
                const auto n = static_cast<std::size_t>((j + k / 8) * 120 + i + k % 8);
                a += Values(disc)[n];
                b += Values(many)[n];
            }
            difference += std::abs(a - b);
            sum += b;
        }
    }
    EXPECT_LT(difference, 0.06 * sum);
    EXPECT_GT(sum * Pitch(request) * Pitch(request), 1e-4 * Light(points, many));
    // The disc itself: what a geometric image of it would be, all but the light in its tails.
    const double radius = RadiansFromDegrees(0.5) * request.lens->first_order().efl_mm;
    const double middle = Values(
        disc)[static_cast<std::size_t>(static_cast<int>(at.y) * 120 + static_cast<int>(at.x))];
    EXPECT_NEAR(middle, Light(request, disc) / (kPi * radius * radius), 0.03 * middle);
    EXPECT_NEAR(Light(request, disc), Light(points, many), 0.003 * Light(points, many));
}

// Without a core the direct image is gone, and nothing else.
TEST(Starburst, WithoutItsCoreLosesTheReportedShare) {
    Studio studio;
    FlareRequest request = Starburst(16.0, 200, 200, 2.0);
    request.iris = {8, 0.0, 0.0};
    const Rendering whole = studio.Shoot(request);
    request.starburst.core = false;
    const Rendering rest = studio.Shoot(request);
    const StarburstFacts facts = *rest.report.facts.starburst;
    EXPECT_FALSE(facts.core);
    EXPECT_NEAR(Light(request, whole.image) - Light(request, rest.image),
                facts.core_share * facts.flux_mm2, 1e-4 * facts.flux_mm2);
    EXPECT_EQ(Values(whole.image)[20 * 200 + 20], Values(rest.image)[20 * 200 + 20]);
}

TEST(Starburst, OfWhiteLightThroughAColourlessLensIsWhiteInAll) {
    Studio studio;
    FlareRequest request = Starburst(8.0, 300, 200, 36.0);
    request.lens = testing::BuildLens(testing::PlanoConvex());
    request.f_number = 12.0;
    request.color = ColorMode::kLinRec709;
    request.wavelengths_nm.clear();
    const FlareImage image = studio.Shoot(request).image;
    const double red = testing::Sum(testing::PlaneNamed(image, "starburst.R"));
    const double green = testing::Sum(testing::PlaneNamed(image, "starburst.G"));
    const double blue = testing::Sum(testing::PlaneNamed(image, "starburst.B"));
    EXPECT_NEAR(red, green, 2e-3 * green);
    EXPECT_NEAR(blue, green, 2e-3 * green);
    // Its tails are red: diffraction grows with the wavelength.
    const auto corner = [&](const char* name) {
        return testing::PlaneNamed(image, name).values[30 * 300 + 40];
    };
    EXPECT_GT(corner("starburst.R"), 1.1 * corner("starburst.G"));
    EXPECT_GT(corner("starburst.G"), 1.05 * corner("starburst.B"));
}

}  // namespace
}  // namespace flare
