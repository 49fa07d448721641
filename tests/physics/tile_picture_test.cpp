// SPDX-License-Identifier: Apache-2.0
//
// The tiles against the exact polygons, ghost by ghost: the same prepared light drawn by both.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "core/base/units.h"
#include "core/image/cell_fits.h"
#include "core/mesh/mesh_builder.h"
#include "core/render/ghost_light.h"
#include "core/render/lights.h"
#include "core/render/picture.h"
#include "core/render/quality.h"
#include "core/render/tile_picture.h"
#include "tests/support/lenses.h"
#include "tests/support/seed_lens.h"
#include "tests/support/stop_masks.h"

namespace flare {
namespace {

constexpr PixelWindow kFrame{0, 0, 480, 270};
constexpr PixelWindow kAround{-256, -192, 512, 384};  // in whole blocks, from the middle
constexpr double kPitch_mm = 36.0 / 480.0;

struct Scene {
    std::string lens = testing::kSeedName;
    double field_deg = 5.0;
    double f_number = 4.0;
    IrisShape iris;
    double inverse_distance = 0.0;
    // rel_l1 of all ghosts together, and of the energy.
    double most_l1 = 0.005, most_energy = 5e-4;
    std::size_t fewest_tiles = 51;  // smooth, and with edges
    std::size_t step = 1;           // of the ghosts that are drawn
    int most_drawn = 96;            // wavelengths
};

void PrintTo(const Scene& scene, std::ostream* out) {
    *out << scene.lens << " f/" << scene.f_number << " at " << scene.field_deg << " degrees, "
         << scene.iris.blades << " blades";
}

struct Sums {
    double light = 0.0, miss = 0.0, gain = 0.0;
    double stray = 0.0;  // where the polygons leave a pixel and its neighbours dark
};

bool DarkAround(const std::vector<float>& plane, std::size_t at) {
    const auto width = static_cast<std::ptrdiff_t>(kFrame.width);
    const auto x = static_cast<std::ptrdiff_t>(at) % width;
    const auto y = static_cast<std::ptrdiff_t>(at) / width;
    for (std::ptrdiff_t j = std::max<std::ptrdiff_t>(y - 1, 0);
         j <= std::min<std::ptrdiff_t>(y + 1, kFrame.height - 1); ++j) {
        for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(x - 1, 0);
             i <= std::min<std::ptrdiff_t>(x + 1, width - 1); ++i) {
            if (plane[static_cast<std::size_t>(j * width + i)] != 0.0F) return false;
        }
    }
    return true;
}

class TilesAndPolygons : public ::testing::TestWithParam<Scene> {
  protected:
    TilesAndPolygons()
        : lens_(testing::LibraryLens(GetParam().lens)),
          threads_(2),
          tables_(*lens_, EvenInWavelength(380.0, 780.0, 21), threads_),
          settings_(SettingsOf(QualityPreset::kFinal)) {
        const Scene& scene = GetParam();
        light_.field_rad = RadiansFromDegrees(scene.field_deg);
        light_.pose = PoseOf(*lens_, RadiansFromDegrees(20.0));
        light_.inverse_distance = scene.inverse_distance;
        const auto& stop = lens_->surfaces()[static_cast<std::size_t>(lens_->stop_index())];
        iris_.emplace(scene.iris, stop.semi_diameter_mm * lens_->f_number() / scene.f_number,
                      stop.semi_diameter_mm);
        // Canonical to picture, turned with the pose.
        map_.px_per_x = light_.pose.x_axis / -kPitch_mm;
        map_.px_per_y = light_.pose.y_axis / -kPitch_mm;
        map_.offset_px = {0.5 * kFrame.width, 0.5 * kFrame.height};
        map_.stop_per_x = light_.pose.x_axis;
        map_.stop_per_y = light_.pose.y_axis;
        tile_map_ = TilePicture(kFrame, kFrame.width, kFrame.height, 1.0).MapFromMiddle(map_);
    }

    TiledGhost Prepared(const BounceSequence& sequence) {
        MeshSpec spec = MeshSpecOf(sequence, light_);
        spec.wavelengths_nm = ChebyshevNodes(kTracedLow_nm, kTracedHigh_nm, 3);
        spec.cells = 48;
        spec.position_tolerance_mm = settings_.position_tolerance_mm;
        spec.mask_tolerance = settings_.mask_tolerance;
        const auto surface = std::make_shared<const GhostSurface>(
            std::make_shared<const GhostMesh>(BuildMesh(*lens_, spec)), lens_->sensor_gap_mm());
        TiledGhost ghost;
        if (surface->cells().empty()) return ghost;
        LightColour colour;
        colour.power = LightSpectrum(Vec3d(1.0, 1.0, 1.0));
        colour.dispersion_step_px = 0.5;
        colour.most_drawn = GetParam().most_drawn;
        std::vector<GhostLight::Cell> cells =
            CellsInWindow(*surface, {kDrawnLow_nm, 550.0, kDrawnHigh_nm}, *iris_, tile_map_, {});
        if (cells.empty()) return ghost;
        colour.dispersion_px = DispersionPx(*surface, cells, tile_map_);
        const MaskFields masks = MasksOf(*surface, cells, *iris_);
        AddRing(*surface, tile_map_, kAround, cells);
        ghost.light = PrepareGhost(surface, BundleOf(*lens_, light_), *lens_, tables_, colour,
                                   std::move(cells));
        ghost.light.masks = masks;
        ghost.tiles = std::make_shared<const GhostTiles>(
            TilesOf(ghost.light, *iris_, tile_map_, kAround, *settings_.tiles, 2.0));
        return ghost;
    }

    std::shared_ptr<const Lens> lens_;
    ThreadPool threads_;
    TransmissionTables tables_;
    QualitySettings settings_;
    PlacedLight light_;
    std::optional<Iris> iris_;
    PictureMap map_, tile_map_;
};

TEST_P(TilesAndPolygons, GiveOnePicture) {
    Sums all;
    std::size_t smooth = 0, edges = 0, left = 0;
    const std::vector<BounceSequence> sequences = TwoReflectionSequences(*lens_);
    const std::size_t many = sequences.size() > 60 ? sequences.size() / 40 : 1;
    const std::size_t step = std::max(many, GetParam().step);
    for (std::size_t n = 0; n < sequences.size(); n += step) {
        std::vector<TiledGhost> ghosts(1);
        ghosts[0] = Prepared(sequences[n]);
        if (ghosts[0].light.cells.empty()) continue;
        smooth += ghosts[0].tiles->smooth.size();
        edges += ghosts[0].tiles->edges.size();
        for (const std::uint8_t tile : ghosts[0].tiles->left) left += tile;
        TilePicture tiles(kFrame, kFrame.width, kFrame.height, 2.0);
        ASSERT_EQ(tiles.padded(), kAround);
        tiles.Draw(ghosts, *iris_, tile_map_, settings_.walk, threads_, {});
        const std::array<std::vector<float>, 3> drawn = tiles.Resolve(1.0, threads_);
        Picture polygons(kFrame, 0);
        // The same cells, seen from the frame's corner.
        std::vector<GhostLight> lights = {ghosts[0].light};
        for (GhostLight::Cell& cell : lights[0].cells) {
            cell.y0 += kFrame.height / 2;
            cell.y1 += kFrame.height / 2;
        }
        polygons.Draw(lights, *iris_, map_, settings_.walk, threads_, {});
        for (int c = 0; c < 3; ++c) {
            const std::vector<float>& a = drawn[static_cast<std::size_t>(c)];
            const std::vector<float> b = polygons.Channel(c, 1.0);
            for (std::size_t i = 0; i < a.size(); ++i) {
                const double truth = static_cast<double>(b[i]);
                const double miss = static_cast<double>(a[i]) - truth;
                ASSERT_TRUE(std::isfinite(miss));
                all.light += truth;
                all.miss += std::abs(miss);
                all.gain += miss;
                if (miss != 0.0 && DarkAround(b, i)) all.stray += std::abs(miss);
            }
        }
    }
    ASSERT_GT(all.light, 0.0);
    EXPECT_LT(all.miss, GetParam().most_l1 * all.light);
    EXPECT_LT(std::abs(all.gain), GetParam().most_energy * all.light);
    EXPECT_LT(all.stray, 1e-4 * all.light);
    // The comparison is between two methods.
    EXPECT_GE(smooth, GetParam().fewest_tiles);
    EXPECT_GE(edges, GetParam().fewest_tiles);
    std::printf(
        "rel_l1 %.5f energy %+.6f stray %.6f; tiles %zu smooth, %zu edges, %zu left (4 px)\n",
        all.miss / all.light, all.gain / all.light, all.stray / all.light, smooth, edges, left);
}

std::vector<Scene> Scenes() {
    std::vector<Scene> scenes(1);
    scenes.push_back({testing::kSeedName, 5.0, 2.0, {}});
    scenes.push_back({testing::kSeedName, 12.0, 8.0, {6, 0.0, 10.0}});
    scenes.push_back({testing::kSeedName, 8.0, 4.0, {5, 0.4, 0.0}, 1e-3});
    // Near light: small, focused ghosts, whose colours focus apart.
    scenes.push_back({testing::kSeedName, 5.76, 2.8, {7, 0.0, 0.0}, 1.0 / 1200.0});
    scenes.push_back({"tronnier-color-heliar-100mm-f3_5", 4.0, 5.6, {}});
    Scene fisheye{"shimizu-fisheye-6mm-f2_8-220deg", 40.0, 4.0, {}};
    fisheye.step = 8;
    scenes.push_back(fisheye);
    scenes.push_back({"canon-zoom-70-200mm-f2_8", 3.0, 4.0, {9, 0.6, 0.0}});
    // Masks: a star, and a disc with a hole off its middle, shaded on one side.
    Scene star{testing::kSeedName, 5.0, 4.0, {}};
    star.iris.mask = StopPicture::Sharp(testing::Drawn(160, 10.0, testing::InStar));
    star.iris.rotation_deg = 9.0;
    star.most_l1 = 0.005;
    star.step = 11;
    star.most_drawn = 8;
    scenes.push_back(star);
    StopGrid hole = testing::Drawn(120, 10.0, [](Vec2d p) {
        return p.length() < 8.0 && (p - Vec2d(2.0, 1.0)).length() > 2.0;
    });
    for (std::size_t n = 0; n < hole.values.size(); ++n) {
        if (n % 120 < 60) hole.values[n] *= 0.6F;
    }
    Scene shaded{testing::kSeedName, 9.0, 5.6, {}};
    shaded.iris.mask = StopPicture::Sharp(std::move(hole));
    shaded.most_l1 = 0.005;
    shaded.step = 11;
    shaded.most_drawn = 8;
    scenes.push_back(shaded);
    return scenes;
}

// Many blades of a small opening lie in one tile: more than tiles hold, so polygons take over.
Scene SmallOpening() {
    Scene scene;
    scene.f_number = 150.0;
    scene.iris = {12, 0.0, 0.0};
    scene.fewest_tiles = 5;
    return scene;
}

INSTANTIATE_TEST_SUITE_P(SmallOpenings, TilesAndPolygons, ::testing::Values(SmallOpening()));
INSTANTIATE_TEST_SUITE_P(Scenes, TilesAndPolygons, ::testing::ValuesIn(Scenes()));

}  // namespace
}  // namespace flare
