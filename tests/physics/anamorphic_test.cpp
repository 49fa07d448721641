// SPDX-License-Identifier: Apache-2.0
//
// Lenses without rotational symmetry: a lens behind an afocal pair of cylinders, whose first-order
// figures are known, and a rotational lens that is kept from being one by a billionth, whose
// pictures must be the rotational one's.
#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/mesh_builder.h"
#include "core/render/ghost_flux.h"
#include "core/render/ghost_list.h"
#include "core/render/lights.h"
#include "core/tracing/chief_ray.h"
#include "tests/support/anamorphic_lens.h"
#include "tests/support/brute_force.h"
#include "tests/support/lenses.h"
#include "tests/support/paraxial_table.h"
#include "tests/support/random.h"
#include "tests/support/rendering.h"

namespace flare {
namespace {

using testing::BehindAfocalPair;
using testing::BuildLens;
using testing::CountedFlux;
using testing::LightAt;
using testing::RelL1;
using testing::SeedLens;
using testing::Studio;

std::shared_ptr<const Lens> Anamorphic() {
    return BuildLens(BehindAfocalPair(SeedLens()));
}

TEST(Anamorphic, HalvesTheFocalLengthInItsOwnSection) {
    const auto lens = Anamorphic();
    const auto seed = BuildLens(SeedLens());
    EXPECT_FALSE(lens->rotational());
    const FirstOrder& x = lens->first_order(Section::kX);
    const FirstOrder& y = lens->first_order(Section::kY);
    EXPECT_NEAR(y.efl_mm, seed->first_order().efl_mm, 1e-9);
    EXPECT_NEAR(x.efl_mm, 0.5 * seed->first_order().efl_mm, 1e-9);
    EXPECT_NEAR(lens->squeeze(), 2.0, 1e-9);
    // Both sections focus where the lens behind does.
    EXPECT_NEAR(x.bfl_mm, seed->first_order().bfl_mm, 1e-9);
    EXPECT_NEAR(y.bfl_mm, seed->first_order().bfl_mm, 1e-9);
    // The beam is half as wide in x, so the cone behind is the same.
    EXPECT_NEAR(x.entrance.diameter_mm, 0.5 * y.entrance.diameter_mm, 1e-9);
    EXPECT_NEAR(lens->f_number(), seed->f_number(), 1e-9);
}

TEST(Anamorphic, PutsTheDirectImageWhereEachSectionSays) {
    const auto lens = Anamorphic();
    const double x = lens->first_order(Section::kX).efl_mm;
    const double y = lens->first_order(Section::kY).efl_mm;
    for (const double azimuth_deg : {0.0, 20.0, 45.0, 88.0, 90.0}) {
        const double azimuth = RadiansFromDegrees(azimuth_deg);
        const double field = RadiansFromDegrees(0.05);
        const LightBundle bundle(*lens, field, 0.0, PoseOf(*lens, azimuth).azimuth_rad);
        const auto chief = FindChiefRay(*lens, bundle, kLineD);
        ASSERT_TRUE(chief.has_value()) << azimuth_deg;
        const double t = std::tan(field);
        EXPECT_NEAR(chief->sensor_mm.x, x * t * std::cos(azimuth), 1e-5 * x * t) << azimuth_deg;
        EXPECT_NEAR(chief->sensor_mm.y, y * t * std::sin(azimuth), 1e-5 * y * t) << azimuth_deg;
    }
}

TEST(Anamorphic, ChiefRaysLandWhereAPixelAsksThemTo) {
    testing::Random random(23);
    for (const auto& lens : {Anamorphic(), testing::LibraryLens("schneider-anamorphic-31mm-f2")}) {
        for (int i = 0; i < 12; ++i) {
            const Vec2d wanted(random.Uniform(-7.0, 7.0), random.Uniform(-6.0, 6.0));
            const double inverse_distance = i % 3 == 0 ? 1.0 / 3000.0 : 0.0;
            const auto travel = TravelToSensor(*lens, wanted, inverse_distance, kLineD);
            ASSERT_TRUE(travel.has_value()) << wanted.x << ", " << wanted.y;
            const CanonicalPose pose = PoseOf(*lens, std::atan2(travel->y, travel->x));
            const LightBundle bundle(*lens, std::acos(travel->z), inverse_distance,
                                     pose.azimuth_rad);
            const auto chief = FindChiefRay(*lens, bundle, kLineD);
            ASSERT_TRUE(chief.has_value());
            EXPECT_LT((pose.LensSpace(chief->sensor_mm) - wanted).length(), 1e-7);
        }
    }
}

// ---- flux against counted rays

struct Counted {
    const char* name;
    BounceSequence sequence;
    double field_deg, azimuth_deg;
    double distance_mm;  // 0: infinity
};

void PrintTo(const Counted& counted, std::ostream* out) {
    *out << counted.name;
}

class AnamorphicFlux : public ::testing::TestWithParam<Counted> {};

TEST_P(AnamorphicFlux, IsThatOfCountedRays) {
    const Counted& c = GetParam();
    const auto lens = Anamorphic()->WithBareGlass();
    const Iris iris({}, 8.0, 8.55);
    MeshSpec spec;
    spec.sequence = c.sequence;
    spec.field_rad = RadiansFromDegrees(c.field_deg);
    spec.azimuth_rad = PoseOf(*lens, RadiansFromDegrees(c.azimuth_deg)).azimuth_rad;
    spec.inverse_distance = c.distance_mm > 0.0 ? 1.0 / c.distance_mm : 0.0;
    spec.wavelengths_nm = {kLineD};
    spec.cells = 64;  // light reflected by cylinders passes in a slanted strip
    const LightBundle bundle(*lens, spec.field_rad, spec.inverse_distance, spec.azimuth_rad);
    EXPECT_EQ(bundle.mirror_symmetric(), c.azimuth_deg == 0.0 || c.azimuth_deg == 90.0);
    ThreadPool threads(2);
    const TransmissionTables tables(*lens, {kLineD}, threads);
    const auto surface = std::make_shared<const GhostSurface>(
        std::make_shared<const GhostMesh>(BuildMesh(*lens, spec)), lens->sensor_gap_mm());
    const GhostFlux flux = FluxOf(surface, bundle, *lens, tables, iris, {});
    const CountedFlux counted = testing::CountFlux(*lens, bundle, c.sequence, kLineD, iris, 320,
                                                   [](const Vec2d&, double) {});
    ASSERT_GT(counted.arrived, 3000);
    EXPECT_NEAR(flux.flux_mm2, counted.flux_mm2, 0.004 * counted.flux_mm2);
    EXPECT_NEAR(flux.centroid_mm.x, counted.centroid_mm.x,
                0.02 + 0.004 * std::abs(counted.centroid_mm.x));
    EXPECT_NEAR(flux.centroid_mm.y, counted.centroid_mm.y,
                0.02 + 0.004 * std::abs(counted.centroid_mm.y));
}

// Surfaces 0 to 3 are the cylinders; the seed lens follows.
INSTANTIATE_TEST_SUITE_P(Ghosts, AnamorphicFlux,
                         ::testing::Values(Counted{"Axis", {14, 10}, 0.0, 0.0, 0.0},
                                           Counted{"AlongX", {14, 10}, 5.0, 0.0, 0.0},
                                           Counted{"AlongY", {14, 10}, 5.0, 90.0, 0.0},
                                           Counted{"Skew", {14, 10}, 5.0, 37.0, 0.0},
                                           Counted{"SkewThreeCrossings", {12, 8}, 4.0, 37.0, 0.0},
                                           Counted{"SkewFold", {10, 6}, 6.0, 61.0, 0.0},
                                           Counted{"SkewCylinders", {2, 1}, 5.0, 37.0, 0.0},
                                           Counted{"CylindersAlongX", {2, 1}, 5.0, 0.0, 0.0},
                                           Counted{"SkewCylinderToSphere", {8, 2}, 4.0, 25.0, 0.0},
                                           Counted{"CylinderAlongY", {4, 1}, 5.0, 90.0, 0.0},
                                           Counted{"SkewNear", {14, 12}, 5.0, 50.0, 800.0}),
                         [](const auto& test) { return std::string(test.param.name); });

// With few surfaces, so that lists and pictures are quick.
std::shared_ptr<const Lens> SimpleAnamorphic() {
    return BuildLens(BehindAfocalPair(testing::PlanoConvex()));
}

TEST(AnamorphicList, IsTheSameInAllFourQuadrants) {
    const auto lens = SimpleAnamorphic();
    Studio studio;
    GhostListOptions options;
    options.field_deg = 3.0;
    options.with_peaks = false;
    const auto at = [&](double azimuth_deg) {
        options.azimuth_deg = azimuth_deg;
        const auto list = RankGhosts(lens, options, studio.Context());
        FLARE_CHECK(list.ok());
        return *list;
    };
    const GhostList first = at(37.0);
    EXPECT_EQ(first.ghosts.size(), 15U);
    const std::pair<double, Vec2d> mirrors[] = {
        {143.0, {-1.0, 1.0}}, {217.0, {-1.0, -1.0}}, {-37.0, {1.0, -1.0}}};
    for (const auto& [azimuth, sign] : mirrors) {
        const GhostList other = at(azimuth);
        ASSERT_EQ(other.ghosts.size(), first.ghosts.size());
        for (std::size_t i = 0; i < first.ghosts.size(); ++i) {
            const GhostEntry& a = first.ghosts[i];
            const GhostEntry& b = other.ghosts[i];
            EXPECT_EQ(b.sequence, a.sequence);
            EXPECT_NEAR(b.flux_mm2, a.flux_mm2, 1e-6 * first.ghosts[0].flux_mm2);
            EXPECT_NEAR(b.centroid_mm.x, sign.x * a.centroid_mm.x, 1e-5);
            EXPECT_NEAR(b.centroid_mm.y, sign.y * a.centroid_mm.y, 1e-5);
        }
    }
    // The sections differ: light along x is not light along y.
    EXPECT_GT(std::abs(at(0.0).total_flux_mm2 / at(90.0).total_flux_mm2 - 1.0), 0.01);
}

TEST(AnamorphicList, GivesBothSectionsFirstOrderFigures) {
    Studio studio;
    GhostListOptions options;
    options.with_peaks = false;
    const auto list = RankGhosts(SimpleAnamorphic(), options, studio.Context());
    ASSERT_TRUE(list.ok());
    for (const GhostEntry& ghost : list->ghosts) {
        // The one ghost within the lens behind: twice as wide in x, as the beam is half as wide.
        if (ghost.sequence != BounceSequence{6, 5}) continue;
        EXPECT_NEAR(ghost.x.abcd.a, 2.0 * ghost.y.abcd.a, 1e-9);
        ASSERT_EQ(ghost.x.crossings.size(), 1U);
        EXPECT_NEAR(ghost.x.crossings[0].a1, 2.0 * ghost.y.crossings[0].a1, 1e-9);
        EXPECT_NEAR(ghost.x.crossings[0].m, ghost.y.crossings[0].m, 1e-9);
        return;
    }
    ADD_FAILURE() << "the ghost is not in the list";
}

// ---- pictures

FlareRequest PictureOf(std::shared_ptr<const Lens> lens, double field_deg, double azimuth_deg) {
    FlareRequest request = testing::SpectralRequest(std::move(lens), 4.0, 240, 160);
    request.quality = QualityPreset::kPreview;
    request.lights = {LightAt(field_deg, azimuth_deg)};
    return request;
}

FlareImage Flipped(const FlareImage& image, bool left_right, bool up_down) {
    FlareImage out = image;
    const int w = image.data.width, h = image.data.height;
    for (std::size_t p = 0; p < image.planes.size(); ++p) {
        for (int y = 0; y < h; ++y) {
            for (int x = 0; x < w; ++x) {
                out.planes[p].values[static_cast<std::size_t>(y * w + x)] =
                    image.planes[p].values[static_cast<std::size_t>((up_down ? h - 1 - y : y) * w +
                                                                    (left_right ? w - 1 - x : x))];
            }
        }
    }
    return out;
}

TEST(AnamorphicPicture, OfAMirroredLightIsTheMirroredPicture) {
    Studio studio;
    FlareRequest request = PictureOf(Anamorphic(), 0.0, 0.0);
    request.quality = QualityPreset::kDraft;
    // A hexagon with a corner at +y is its own mirror image in both directions.
    request.iris = {6, 0.0, 0.0};
    const Vec3d d(0.08, 0.06, 0.99);
    request.lights[0].direction = d;
    const Rendering first = studio.Shoot(request);
    for (const auto& [x, y] : {std::pair(-1.0, 1.0), std::pair(1.0, -1.0), std::pair(-1.0, -1.0)}) {
        request.lights[0].direction = Vec3d(x * d.x, y * d.y, d.z);
        const Rendering other = studio.Shoot(request);
        EXPECT_LT(RelL1(other.image, Flipped(first.image, x < 0.0, y < 0.0)), 1e-4);
        EXPECT_EQ(other.report.work.rays_traced, 0U) << "one mesh serves all four quadrants";
    }
    EXPECT_GT(RelL1(first.image, Flipped(first.image, true, false)), 0.1);
    EXPECT_GT(RelL1(first.image, Flipped(first.image, false, true)), 0.1);
}

// An iris without symmetry must not be mirrored with the light: against counted rays, in lens space
// itself.
TEST(AnamorphicPicture, KeepsTheIrisInItsPlace) {
    const auto lens = SimpleAnamorphic();
    Studio studio;
    for (const double azimuth_deg : {37.0, 143.0, 217.0, 323.0}) {
        constexpr double kFrame_mm = 10000.0;  // all light lands on it
        FlareRequest request = testing::SpectralRequest(lens, 11.0, 60, 60);
        request.quality = QualityPreset::kPreview;
        request.image.sensor_width_mm = kFrame_mm;
        request.lights = {LightAt(3.0, azimuth_deg)};
        request.iris = {3, 0.0, 17.0};
        const Rendering rendering = studio.Shoot(request);
        const double pitch = kFrame_mm / 60.0;
        const double light = testing::Sum(rendering.image.planes[0]) * pitch * pitch;

        const Iris iris(request.iris, StopForFNumber(*lens, 11.0).semi_diameter_mm, 5.0);
        const LightBundle bundle(*lens, RadiansFromDegrees(3.0), 0.0,
                                 RadiansFromDegrees(azimuth_deg));
        double counted = 0.0, reported = 0.0;
        for (const GhostFacts& ghost : rendering.report.facts.ghosts) {
            reported += ghost.flux_mm2;
            counted += testing::CountFlux(*lens, bundle, ghost.sequence, kLineD, iris, 120,
                                          [](const Vec2d&, double) {})
                           .flux_mm2;
        }
        EXPECT_NEAR(light, counted, 0.006 * counted) << azimuth_deg;
        EXPECT_NEAR(reported, counted, 0.02 * counted) << azimuth_deg;
    }
}

// The two have meshes of their own, so at any quality the pictures differ by less than that
// quality's error; at the final one by 0.1 % (preview 0.8 %, reference 0.02 %).
TEST(AnamorphicPicture, OfALensThatIsAllButRotationalIsTheRotationalOne) {
    Studio studio;
    const auto round = BuildLens(SeedLens());
    const auto compare = [&](std::size_t index, double field_deg, double azimuth_deg,
                             std::optional<double> distance_m) {
        FlareRequest one = PictureOf(round, field_deg, azimuth_deg);
        one.quality = QualityPreset::kFinal;
        one.image.width = 160;
        one.image.height = 100;
        one.lights[0].distance_m = distance_m;
        FlareRequest other = one;
        other.lens = BuildLens(testing::AllButRotational(SeedLens(), index));
        ASSERT_FALSE(other.lens->rotational());
        const Rendering a = studio.Shoot(one), b = studio.Shoot(other);
        EXPECT_GT(testing::Sum(a.image.planes[0]), 0.0);
        EXPECT_LT(RelL1(b.image, a.image), 2e-3) << azimuth_deg;
        // The chief ray, found in two dimensions and in one.
        const Vec2d pa = a.report.facts.lights[0].pixel, pb = b.report.facts.lights[0].pixel;
        EXPECT_TRUE(b.report.facts.lights[0].chief_ray_arrives);
        EXPECT_LT((pa - pb).length(), 1e-6);
    };
    compare(0, 7.0, 30.0, {});
    compare(6, 7.0, 250.0, {});
    compare(10, 3.0, 160.0, 0.4);
}

TEST(AnamorphicPicture, DesqueezedHasSquarePixelsAndTheSameLight) {
    Studio studio;
    FlareRequest request = PictureOf(SimpleAnamorphic(), 5.0, 205.0);
    request.f_number = 12.0;
    request.image.width = 240;
    request.image.height = 160;
    request.image.sensor_width_mm = 24.0;
    EXPECT_NEAR(PixelPitch(request).y, 0.1, 1e-12);
    EXPECT_NEAR(ShownPixelAspect(request), 2.0, 1e-9);
    const Rendering squeezed = studio.Shoot(request);
    EXPECT_NEAR(squeezed.image.pixel_aspect, 2.0, 1e-9);
    EXPECT_NEAR(squeezed.report.facts.squeeze, 2.0, 1e-9);

    request.image.desqueeze = true;
    request.image.height = 80;  // the same 16 mm
    EXPECT_NEAR(PixelPitch(request).x, 0.1, 1e-12);
    EXPECT_NEAR(PixelPitch(request).y, 0.2, 1e-9);
    EXPECT_NEAR(ShownPixelAspect(request), 1.0, 1e-9);
    const Rendering shown = studio.Shoot(request);
    EXPECT_NEAR(shown.image.pixel_aspect, 1.0, 1e-9);
    const double before = testing::Sum(squeezed.image.planes[0]) * 0.1 * 0.1;
    EXPECT_NEAR(testing::Sum(shown.image.planes[0]) * 0.1 * 0.2, before, 2e-3 * before);
    // Two rows of the one are a row of the other.
    double miss = 0.0, sum = 0.0;
    for (std::size_t y = 0; y < 80; ++y) {
        for (std::size_t x = 0; x < 240; ++x) {
            const auto row = [&](std::size_t r) {
                return static_cast<double>(squeezed.image.planes[0].values[r * 240 + x]);
            };
            const double mean = 0.5 * (row(2 * y) + row(2 * y + 1));
            miss += std::abs(mean - static_cast<double>(shown.image.planes[0].values[y * 240 + x]));
            sum += mean;
        }
    }
    EXPECT_LT(miss, 5e-3 * sum);
    EXPECT_NEAR(squeezed.report.facts.lights[0].pixel.x, shown.report.facts.lights[0].pixel.x,
                1e-9);
}

TEST(Anamorphic, PixelsSeeTheSceneSqueezed) {
    FlareRequest request = PictureOf(Anamorphic(), 0.0, 0.0);
    request.image.projection = Projection::kRectilinear;
    request.lights[0].direction.reset();
    request.lights[0].pixel = Vec2d(120.0 + 40.0, 80.0 - 40.0);
    const auto light = PlaceLight(request, 0);
    ASSERT_TRUE(light.ok());
    // 40 pixels of 0.15 mm are 6 mm: over 25.2 mm across, over 50.4 mm upright.
    const double efl = BuildLens(SeedLens())->first_order().efl_mm;
    EXPECT_NEAR(light->direction.x / light->direction.z, 6.0 / (0.5 * efl), 1e-9);
    EXPECT_NEAR(light->direction.y / light->direction.z, 6.0 / efl, 1e-9);
    request.image.desqueeze = true;
    const auto shown = PlaceLight(request, 0);
    EXPECT_NEAR(shown->direction.y / shown->direction.z, 12.0 / efl, 1e-9);
    EXPECT_NEAR(shown->direction.x, shown->direction.y, 1e-9);
}

TEST(Anamorphic, EqualRadiiMakeARotationalLens) {
    Prescription toroidal = SeedLens();
    for (SurfacePrescription& surface : toroidal.surfaces) {
        if (surface.kind != SurfaceKind::kSphere) continue;
        surface.kind = SurfaceKind::kToroid;
        surface.radius_x_mm = surface.radius_y_mm = surface.radius_mm;
        surface.radius_mm = 0.0;
    }
    EXPECT_EQ(BuildLens(toroidal)->fingerprint(), BuildLens(SeedLens())->fingerprint());
}

}  // namespace
}  // namespace flare
