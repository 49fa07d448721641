// SPDX-License-Identifier: Apache-2.0
//
// Level by level: the corners of the wanted tiles are solved for in every cell; the cells' own
// points then say whether a tile's bilinear light and masks are good enough; tiles that are not go
// to the next level, those of the last one to polygons. Sheets of the two orientations are kept
// apart: a fold is where they meet, and cells that hold one mark it part by part.
#include "core/image/ghost_tiles.h"

#include <algorithm>
#include <utility>

#include "core/image/cell_fits.h"
#include "core/image/tile_edges.h"
#include "core/image/tile_level.h"
#include "core/image/tile_light.h"
#include "core/image/tile_solver.h"

namespace flare {
namespace {

constexpr int kMostIrisEdges = 12;

// Tiles of the coarsest level around all that is drawn, within the window.
TileBox Bounds(const GhostLight& ghost, const PixelWindow& window) {
    PixelBox box;
    for (const GhostLight::Cell& cell : ghost.cells) {
        if (cell.ring) continue;
        box.Join(BoxOf(cell));
    }
    if (box.empty()) return {};
    const int size = TileSize(0);
    const auto limit = [&](float value, int lo, int hi) {
        return std::clamp(value, static_cast<float>(lo), static_cast<float>(hi));
    };
    const int right = window.x + window.width;
    const int bottom = window.y + window.height;
    return {FloorTo(limit(box.x0, window.x, right - 1), size),
            FloorTo(limit(box.y0, window.y, bottom - 1), size),
            FloorTo(limit(box.x1, window.x, right - 1), size) + 1,
            FloorTo(limit(box.y1, window.y, bottom - 1), size) + 1};
}

void StartLeft(const TileBox& all, GhostTiles& out) {
    constexpr int kFine = 1 << (kTileLevels - 1);
    out.left_x = all.x0 * kFine;
    out.left_y = all.y0 * kFine;
    out.left_width = all.width() * kFine;
    out.left_height = all.height() * kFine;
    out.left.assign(
        static_cast<std::size_t>(out.left_width) * static_cast<std::size_t>(out.left_height), 0);
}

// Kept by each thread from ghost to ghost: fresh memory costs more than what is put into it.
TileLevel& LevelOfThread() {
    thread_local TileLevel level;
    return level;
}

class Tiler {
  public:
    Tiler(const GhostLight& ghost, const Iris& iris, const PictureMap& map,
          const PixelWindow& window, const TileTolerance& tolerance, double unit)
        : ghost_(ghost),
          window_(window),

          fitted_(ghost, iris, map),
          light_(ghost),
          level_(LevelOfThread()),
          solver_(ghost, iris, fitted_, light_, tolerance, level_),
          edges_(ghost, iris, fitted_.cells(), light_, unit, out_) {}

    GhostTiles Run() {
        const TileBox all = Bounds(ghost_, window_);
        if (all.width() <= 0 || all.height() <= 0) return std::move(out_);
        StartLeft(all, out_);
        for (const GhostLight::Band& band : ghost_.bands) {
            for (const double w : band.node_weights)
                out_.band_weights.push_back(static_cast<float>(w));
        }
        level_.Start(TileSize(0), all);
        for (int y = all.y0; y < all.y1; ++y) {
            for (int x = all.x0; x < all.x1; ++x) level_.Want(x, y);
        }
        for (int l = 0; l < kTileLevels; ++l) {
            level_.MakeRecords(ghost_.masks.count());
            solver_.Run();
            for (const auto& [x, y] : level_.tiles) Classify(l, x, y);
            if (l + 1 < kTileLevels && !Descend(l)) break;
        }
        return std::move(out_);
    }

  private:
    void Classify(int l, int x, int y) {
        const auto tile = static_cast<std::size_t>(level_.tile_at[level_.Tile(x, y)]);
        const std::array<std::size_t, 4> corners = level_.Corners(x, y);
        bool bad = level_.bad[tile] != 0;
        const bool cut = level_.cut.Has(x, y);
        const std::size_t smooth_before = out_.smooth.size();
        const std::size_t edges_before = out_.edges.size();
        std::array<bool, kSheets> lit{};
        for (std::size_t s = 0; s < kSheets && !bad; ++s) {
            // Where no cell that is drawn lands, nothing of this sheet is lit.
            if (!level_.live[s].Has(x, y)) continue;
            lit[s] = Solved(level_.sheets[s], corners);
            bad = !lit[s];
        }
        for (std::size_t s = 0; s < kSheets && !bad; ++s) {
            if (!lit[s]) continue;
            const TileColour scale = level_.sums[s][tile].Scale();
            // The corners may all be dark while light passes between them.
            const TileEdges::Outcome outcome =
                edges_.Emit(l, x, y, level_.sheets[s], corners, scale, cut);
            bad = outcome == TileEdges::Outcome::kTooMany ||
                  outcome == TileEdges::Outcome::kTooLarge ||
                  (outcome == TileEdges::Outcome::kShut &&
                   (level_.lit[s][tile] != 0 || TileSize(l) > kLargestEdgeTile));
        }
        if (!bad) return;
        out_.smooth.resize(smooth_before);
        out_.edges.resize(edges_before);
        level_.bad[tile] = 1;
        if (l + 1 < kTileLevels) return;
        out_.left[static_cast<std::size_t>(y - out_.left_y) *
                      static_cast<std::size_t>(out_.left_width) +
                  static_cast<std::size_t>(x - out_.left_x)] = 1;
        out_.any_left = true;
    }

    // Does just one point land on each corner, at every wavelength? (With none, cells may lie
    // between the corners.) Where layers of one orientation lie over each other, their masks could
    // not be told apart nor their light be held to points of the cells.
    static bool Solved(const TileLevel::Sheet& sheet, const std::array<std::size_t, 4>& corners) {
        for (const std::size_t n : corners) {
            for (std::size_t k = 0; k < kTraced; ++k) {
                if (sheet.found[k][n] != 1) return false;
            }
        }
        return true;
    }

    // Makes the next level's wanted tiles of this one's bad ones; false if there are none.
    bool Descend(int l) {
        std::vector<std::array<int, 2>> bad;
        for (std::size_t t = 0; t < level_.tiles.size(); ++t) {
            if (level_.bad[t] != 0) bad.push_back(level_.tiles[t]);
        }
        if (bad.empty()) return false;
        TileBox box{bad[0][0], bad[0][1], bad[0][0], bad[0][1]};
        for (const auto& [x, y] : bad) {
            box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x),
                   std::max(box.y1, y)};
        }
        level_.Start(TileSize(l + 1), {2 * box.x0, 2 * box.y0, 2 * box.x1 + 2, 2 * box.y1 + 2});
        for (const auto& [x, y] : bad) {
            for (int child = 0; child < 4; ++child)
                level_.Want(2 * x + child % 2, 2 * y + child / 2);
        }
        return true;
    }

    const GhostLight& ghost_;
    const PixelWindow& window_;
    FittedGhost fitted_;
    TileLight light_;
    TileLevel& level_;
    GhostTiles out_;
    TileSolver solver_;
    TileEdges edges_;
};

}  // namespace

bool CanBeTiled(const GhostLight& ghost) {
    return ghost.channels == 3 && !ghost.bands.empty() &&
           ghost.bands.front().node_weights.size() == static_cast<std::size_t>(kTracedInTiles);
}

namespace {

template <class Tile>
BlockRows SortIntoRows(std::vector<Tile>& tiles) {
    // Towards minus infinity.
    const auto row_of = [](const Tile& tile) { return tile.y >> tile.level; };
    std::stable_sort(tiles.begin(), tiles.end(),
                     [&](const Tile& a, const Tile& b) { return row_of(a) < row_of(b); });
    BlockRows rows;
    if (tiles.empty()) return rows;
    rows.first = row_of(tiles.front());
    for (std::uint32_t n = 0; n < tiles.size(); ++n) {
        while (rows.first + static_cast<int>(rows.at.size()) <= row_of(tiles[n]))
            rows.at.push_back(n);
    }
    rows.at.push_back(static_cast<std::uint32_t>(tiles.size()));
    return rows;
}

}  // namespace

GhostTiles TilesOf(const GhostLight& ghost, const Iris& iris, const PictureMap& map,
                   const PixelWindow& window, const TileTolerance& tolerance, double unit) {
    GhostTiles tiles;
    if (ghost.cells.empty()) return tiles;
    if (!CanBeTiled(ghost) || ghost.masks.count() > kTileFields ||
        iris.edge_count() > kMostIrisEdges) {
        const TileBox all = Bounds(ghost, window);
        if (all.width() <= 0 || all.height() <= 0) return tiles;
        StartLeft(all, tiles);
        std::fill(tiles.left.begin(), tiles.left.end(), std::uint8_t{1});
        tiles.any_left = true;
        return tiles;
    }
    tiles = Tiler(ghost, ghost.IrisOr(iris), map, window, tolerance, unit).Run();
    tiles.smooth_rows = SortIntoRows(tiles.smooth);
    tiles.edge_rows = SortIntoRows(tiles.edges);
    return tiles;
}

}  // namespace flare
