// SPDX-License-Identifier: Apache-2.0
//
// Irises with a mask: against the analytic round iris, against sums of masks, against rays that are
// counted one by one, and against meshes of another fineness.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "core/mesh/mesh_builder.h"
#include "core/render/ghost_estimate.h"
#include "core/render/ghost_flux.h"
#include "core/render/ghost_light.h"
#include "core/render/ghost_sample.h"
#include "core/render/lights.h"
#include "core/render/picture.h"
#include "core/render/quality.h"
#include "tests/support/lenses.h"
#include "tests/support/one_ghost.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"
#include "tests/support/stop_masks.h"

namespace flare {
namespace {

using testing::Drawn;
using testing::InStar;

std::shared_ptr<const Lens> Seed() {
    return testing::LibraryLens(testing::kSeedName);
}

double Rim(const Lens& lens) {
    return lens.surfaces()[static_cast<std::size_t>(lens.stop_index())].semi_diameter_mm;
}

FlareRequest Asked(double f_number) {
    FlareRequest request = testing::SpectralRequest(Seed(), f_number, 320, 180);
    request.lights = {testing::LightAt(7.0, 25.0)};
    return request;
}

std::shared_ptr<const StopPicture> DiscMask(int side) {
    return StopPicture::Sharp(Drawn(side, 1.0, [](Vec2d p) { return p.length() < 0.8; }));
}

// White disc on black, drawn on 300 cells: what the analytic round iris gives.
TEST(MaskIris, OfADiscIsTheRoundIris) {
    testing::Studio studio;
    const auto disc = DiscMask(300);
    FlareRequest request = Asked(5.6);
    const Rendering round = studio.Shoot(request);
    request.iris.mask = disc;
    const Rendering masked = studio.Shoot(request);
    EXPECT_LT(testing::RelL1(masked.image, round.image), 0.003);  // polygons
    std::printf("polygons: rel_l1 %.5f", testing::RelL1(masked.image, round.image));

    request = Asked(5.6);
    request.color = ColorMode::kLinRec709;
    request.wavelengths_nm.clear();
    request.quality = QualityPreset::kFinal;
    const Rendering round_tiles = studio.Shoot(request);
    request.iris.mask = disc;
    const Rendering masked_tiles = studio.Shoot(request);
    EXPECT_LT(testing::RelL1(masked_tiles.image, round_tiles.image), 0.004);
    std::printf(", tiles: rel_l1 %.5f\n", testing::RelL1(masked_tiles.image, round_tiles.image));
    for (std::size_t i = 0; i < round.report.facts.ghosts.size(); ++i) {
        const double flux = round.report.facts.ghosts[i].flux_mm2;
        EXPECT_NEAR(masked.report.facts.ghosts[i].flux_mm2, flux, 0.02 * flux + 1e-9);
    }
}

// One ghost that crosses the stop once, in colour and at one wavelength: two halves of a disc, one
// cut slanting, are the disc.
TEST(MaskIris, LightOfTwoHalvesAddsUp) {
    testing::OneGhostMeshes meshes;
    ThreadPool threads(2);
    const std::vector<BounceSequence> sequences = TwoReflectionSequences(*Seed());
    const auto shoot = [&](const FlareRequest& request) {
        const RenderContext context{threads, meshes, CancelToken(), [] { return 0.0; }};
        Result<Rendering> rendering = Render(request, context);
        EXPECT_TRUE(rendering);
        return std::move(rendering->image);
    };
    const auto part = [](double side) {
        return StopPicture::Sharp(Drawn(200, 1.0, [side](Vec2d p) {
            return p.length() < 0.7 && side * (p.dot(Vec2d(0.8, 0.6)) - 0.13) < 0.0;
        }));
    };
    for (const bool colour : {false, true}) {
        FlareRequest request = Asked(2.0);
        request.quality = QualityPreset::kFinal;
        request.iris.mask_scale = MaskScale::kStop;
        if (colour) {
            request.color = ColorMode::kLinRec709;
            request.wavelengths_nm.clear();
        }
        int seen = 0;
        for (std::size_t n = 0; n < sequences.size() && seen < 3; n += 7) {
            if (WriteOut(*Seed(), sequences[n], kLineD).stop_crossings != 1) continue;
            meshes.Show(sequences[n]);
            request.iris.mask = part(1.0);
            const FlareImage one = shoot(request);
            request.iris.mask = part(-1.0);
            const FlareImage other = shoot(request);
            request.iris.mask =
                StopPicture::Sharp(Drawn(200, 1.0, [](Vec2d p) { return p.length() < 0.7; }));
            const FlareImage both = shoot(request);
            double light = 0.0, miss = 0.0, least = 0.0;
            for (std::size_t c = 0; c < both.planes.size(); ++c) {
                for (std::size_t i = 0; i < both.data.pixels(); ++i) {
                    const auto a = static_cast<double>(one.planes[c].values[i]);
                    const auto b = static_cast<double>(other.planes[c].values[i]);
                    const auto sum = static_cast<double>(both.planes[c].values[i]);
                    light += sum;
                    miss += std::abs(a + b - sum);
                    least += std::min(a, b);
                }
            }
            if (light == 0.0) continue;
            ++seen;
            EXPECT_LT(miss, 0.002 * light) << n << (colour ? " colour" : "");
            EXPECT_LT(least, 0.2 * light);
        }
        EXPECT_GE(seen, 3);
    }
}

struct Ghost {
    std::shared_ptr<const GhostSurface> surface;
    PlacedLight light;
    std::shared_ptr<const Lens> lens = Seed();

    Ghost(const BounceSequence& sequence, double field_deg, int cells) {
        light.field_rad = RadiansFromDegrees(field_deg);
        light.pose = PoseOf(*lens, RadiansFromDegrees(20.0));
        MeshSpec spec = MeshSpecOf(sequence, light);
        spec.wavelengths_nm = {kLineD};
        spec.cells = cells;
        const QualitySettings settings = SettingsOf(QualityPreset::kFinal);
        spec.position_tolerance_mm = settings.position_tolerance_mm;
        spec.mask_tolerance = settings.mask_tolerance;
        surface = std::make_shared<const GhostSurface>(
            std::make_shared<const GhostMesh>(BuildMesh(*lens, spec)), lens->sensor_gap_mm());
    }
};

// Ghosts of three crossings: flux by counted rays, each worth the product of what it meets.
TEST(MaskIris, FluxThroughThreeCrossingsIsThatOfCountedRays) {
    const auto lens = Seed();
    ThreadPool threads(2);
    const TransmissionTables tables(*lens, {kLineD}, threads);
    const auto star = StopPicture::Sharp(Drawn(128, 10.0, InStar));
    IrisShape shape;
    shape.mask = star;
    shape.rotation_deg = 11.0;
    int seen = 0;
    double worst_walk = 0.0, worst_estimate = 0.0, worst_sample = 0.0;
    for (const BounceSequence& sequence : TwoReflectionSequences(*lens)) {
        const InteractionList list = WriteOut(*lens, sequence, kLineD);
        if (list.stop_crossings != 3 || ++seen % 4 != 1) continue;
        const Ghost ghost(sequence, 6.0, 48);
        const Iris iris(shape, 5.5, Rim(*lens));
        const LightBundle bundle = BundleOf(*lens, ghost.light);
        double counted = 0.0;
        constexpr int kSide = 300;
        const double half = bundle.half_width();
        const double step = 2.0 * half / kSide;
        RayRecord record;
        TraceOptions options;
        options.iris = &iris;
        for (int k = 0; k < kSide * kSide; ++k) {
            const double u = bundle.centre_u() - half + (k % kSide + 0.5) * step;
            const double v = -half + (k / kSide + 0.5) * step;
            const TraceResult ray = TraceRay(list, bundle.At(u, v), options, &record);
            if (ray.fate != RayFate::kArrived) continue;
            double passes = 1.0;
            for (const Vec2d& at : record.stop_mm)
                passes *= iris.TransmissionAt(ghost.light.pose.LensSpace(at));
            if (passes == 0.0) continue;
            counted +=
                passes * PathWeight(*lens, list, record) * bundle.FluxDensity(u, v) * step * step;
        }
        if (counted < 5e-4) continue;
        // FluxOf knows the canonical light only: the iris is turned back instead.
        IrisShape turned = shape;
        turned.rotation_deg -= 20.0;
        const double walked = FluxOf(ghost.surface, bundle, *lens, tables,
                                     Iris(turned, 5.5, Rim(*lens)), WalkTolerance{})
                                  .flux_mm2;
        const double estimate =
            EstimateOf(*ghost.surface, bundle, *lens, tables, iris, ghost.light.pose).flux_mm2;
        PictureMap map;
        const double sampled =
            SampleGhost({*lens, bundle, ghost.light.pose, iris, tables, {1.0}, map, 1e4, 1e4},
                        sequence)
                .flux_mm2;
        worst_walk = std::max(worst_walk, std::abs(walked / counted - 1.0));
        worst_estimate = std::max(worst_estimate, std::abs(estimate / counted - 1.0));
        worst_sample = std::max(worst_sample, std::abs(sampled / counted - 1.0));
    }
    std::printf("flux against counted rays: walk %.4f, estimate %.4f, sample %.4f\n", worst_walk,
                worst_estimate, worst_sample);
    EXPECT_GT(worst_walk, 0.0);
    EXPECT_LT(worst_walk, 0.02);
    EXPECT_LT(worst_estimate, 0.04);
    EXPECT_LT(worst_sample, 0.15);
}

// Edges do not move with the mesh: no pixel changes by more than an edge moved by 0.3 pixels would.
class MaskEdges : public ::testing::TestWithParam<const char*> {
  protected:
    static constexpr PixelWindow kFrame{0, 0, 400, 300};

    static PictureMap Map(const Ghost& ghost, double px_per_mm) {
        PictureMap map;
        map.px_per_x = ghost.light.pose.x_axis * -px_per_mm;
        map.px_per_y = ghost.light.pose.y_axis * -px_per_mm;
        map.offset_px = {0.5 * kFrame.width, 0.5 * kFrame.height};
        map.stop_per_x = ghost.light.pose.x_axis;
        map.stop_per_y = ghost.light.pose.y_axis;
        return map;
    }

    std::vector<float> Draw(const Ghost& ghost, const Iris& iris) {
        PictureMap map = Map(ghost, kPx_per_mm);
        map.offset_px -= offset_;
        LightColour colour;
        colour.spectral = true;
        std::vector<GhostLight> lights = {
            PrepareGhost(ghost.surface, BundleOf(*ghost.lens, ghost.light), *ghost.lens, tables_,
                         colour, CellsInWindow(*ghost.surface, {kLineD}, iris, map, {}))};
        Picture picture(kFrame, 1);
        picture.Draw(lights, iris, map, SettingsOf(QualityPreset::kReference).walk, threads_, {});
        return picture.Channel(0, 1.0);
    }

    // The middle and the width of what is lit, px.
    std::pair<Vec2d, double> Extent(const std::vector<float>& light) {
        Vec2d lo(1e9), hi(-1e9);
        for (int y = 0; y < kFrame.height; ++y) {
            for (int x = 0; x < kFrame.width; ++x) {
                if (light[static_cast<std::size_t>(y * kFrame.width + x)] <= 0.0F) continue;
                lo = {std::min(lo.x, x + 0.0), std::min(lo.y, y + 0.0)};
                hi = {std::max(hi.x, x + 1.0), std::max(hi.y, y + 1.0)};
            }
        }
        return {(lo + hi) * 0.5, hi.x - lo.x};
    }

    static constexpr double kPx_per_mm = 20.0;
    ThreadPool threads_{2};
    TransmissionTables tables_{*Seed(), {kLineD}, threads_};
    Vec2d offset_{0.0, 0.0};
};

TEST_P(MaskEdges, LieAtOnePlaceOnCoarseAndFineMeshes) {
    const std::string kind = GetParam();
    const BounceSequence sequence{{4, 2}};
    const Ghost coarse(sequence, 5.0, 32);
    const Ghost fine(sequence, 5.0, 256);
    const double rim = Rim(*fine.lens);
    const double radius = 6.0;
    const auto [middle, width] = Extent(Draw(fine, Iris({}, radius, rim)));
    offset_ = middle - Vec2d(0.5 * kFrame.width, 0.5 * kFrame.height);
    ASSERT_GT(width, 120.0) << "a ghost that fills a good part of the frame";
    const double slit = 2.0 * 2.0 * radius / width;  // two pixels, at the stop

    IrisShape shape;
    shape.rotation_deg = 7.0;
    shape.mask_scale = MaskScale::kStop;
    const double unit = rim;
    if (kind == "hole") {
        shape.mask = StopPicture::Sharp(Drawn(512, 1.0, [&](Vec2d p) {
            return p.length() * unit < radius && (p * unit - Vec2d(1.5, 0.5)).length() > 2.0;
        }));
    } else if (kind == "star") {
        shape.mask = StopPicture::Sharp(Drawn(256, 1.0, [&](Vec2d p) { return InStar(p * unit); }));
    } else {
        shape.mask = StopPicture::Sharp(Drawn(512, 1.0, [&](Vec2d p) {
            return p.length() * unit < radius && std::abs(p.x) * unit < 0.5 * slit;
        }));
    }
    const Iris iris(shape, rim, rim);
    const std::vector<float> a = Draw(coarse, iris);
    const std::vector<float> b = Draw(fine, iris);
    // An edge that moves by d pixels changes a pixel by at most d times the step it is.
    double worst = 0.0, sum = 0.0, light = 0.0;
    for (int y = 1; y + 1 < kFrame.height; ++y) {
        for (int x = 1; x + 1 < kFrame.width; ++x) {
            float most = 0.0F;
            for (int j = -1; j <= 1; ++j) {
                for (int i = -1; i <= 1; ++i)
                    most =
                        std::max(most, b[static_cast<std::size_t>((y + j) * kFrame.width + x + i)]);
            }
            const auto n = static_cast<std::size_t>(y * kFrame.width + x);
            const double change = std::abs(static_cast<double>(a[n]) - static_cast<double>(b[n]));
            if (most > 0.0F) worst = std::max(worst, change / static_cast<double>(most));
            sum += change;
            light += static_cast<double>(b[n]);
        }
    }
    ASSERT_GT(light, 0.0);
    std::printf("%s: edges differ by at most %.3f px; rel_l1 %.5f\n", kind.c_str(), worst,
                sum / light);
    EXPECT_LT(worst, 0.3);
}

INSTANTIATE_TEST_SUITE_P(Shapes, MaskEdges, ::testing::Values("hole", "star", "slit"));

// With the same area at the stop the direct image has the same light.
TEST(MaskIris, StarburstHoldsTheLightOfTheMasksArea) {
    testing::Studio studio;
    FlareRequest request = Asked(8.0);
    request.layers = {false, true};
    request.lights = {testing::LightAt(3.0)};
    const double round = studio.Shoot(request).report.facts.starburst->flux_mm2;
    request.iris.mask = StopPicture::Sharp(Drawn(128, 10.0, InStar));
    EXPECT_NEAR(studio.Shoot(request).report.facts.starburst->flux_mm2, round, 0.01 * round);
    request.iris.mask = StopPicture::Sharp(Drawn(
        128, 10.0, [](Vec2d p) { return p.length() < 8.0 && (p - Vec2d(2.0, 1.0)).length() > 3; }));
    EXPECT_NEAR(studio.Shoot(request).report.facts.starburst->flux_mm2, round, 0.01 * round);
}

// A star of five points on the axis: its pattern repeats every 36 degrees, far out as well.
TEST(MaskIris, StarburstOfAStarHasTenEqualSectors) {
    testing::Studio studio;
    FlareRequest request = Asked(8.0);
    request.image.width = request.image.height = 301;
    request.image.sensor_width_mm = 12.0;
    request.layers = {false, true};
    request.lights = {testing::LightAt(0.0)};
    request.iris.mask = StopPicture::Sharp(Drawn(160, 10.0, InStar));
    const Rendering rendering = studio.Shoot(request);
    const ImagePlane& plane = testing::PlaneNamed(rendering.image, "starburst.S0.587,5618nm");
    std::array<double, 10> sectors{};
    for (int y = 0; y < 301; ++y) {
        for (int x = 0; x < 301; ++x) {
            const Vec2d p(x - 150, 150 - y);
            if (p.length() < 40.0 || p.length() > 148.0) continue;
            const double turns = std::atan2(p.x, p.y) / (2.0 * kPi) + 1.05;
            sectors[static_cast<std::size_t>(turns * 10.0) % 10] +=
                static_cast<double>(plane.values[static_cast<std::size_t>(y * 301 + x)]);
        }
    }
    const auto [least, most] = std::minmax_element(sectors.begin(), sectors.end());
    std::printf("sectors of the star's pattern: %.4f of the brightest at least\n", *least / *most);
    EXPECT_GT(*least, 0.9 * *most);
}

}  // namespace
}  // namespace flare
