// SPDX-License-Identifier: Apache-2.0
//
// A ghost as tiles of the picture, so that its cost follows edges and folds, not area. Where the
// ghost is smooth, the light at the four corners of a tile tells all of it; where only a mask cuts
// it, the mask's edge is shaded pixel by pixel; where it folds, ends or bends more than the
// tolerance, the tile is left to exact polygons (GhostWalk).
//
// The light at a corner comes from the pupil points that land there, found by Newton's method in
// every cell at each traced wavelength; the light of the drawn bands leans on those. Tiles have 16,
// 8 or 4 pixels a side, as coarse as the tolerance allows, at multiples of their size from the
// picture's origin: a crop is cut into the same tiles as the frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/image/flare_image.h"
#include "core/image/ghost_walk.h"
#include "core/image/tile_kernels.h"

namespace flare {

inline constexpr int kTileLevels = 5;
constexpr int TileSize(int level) {
    return kLargestTile >> level;
}

struct TileTolerance {
    double light = 0.04;    // relative, between a tile's bilinear light and the ghost's
    double edge_px = 0.15;  // of a mask's edge
};

// Red, green and blue at the corners (0, 0), (1, 0), (0, 1), (1, 1), light a pixel.
using TileCorners = std::array<std::array<float, 3>, 4>;

struct SmoothTile {
    std::int16_t level = 0;
    int x = 0, y = 0;  // in tiles of that level
    TileCorners corners{};
};

struct EdgeTile {
    std::int16_t level = 0;
    int x = 0, y = 0;
    int straight = 0, arcs = 0, fringes = 0;
    int pictured = 0;  // crossings of the stop at which the iris's picture is wanted
    bool dispersed = false;
    TileCorners corners{};  // dispersed: a factor on the bands' light
    // In the lists of GhostTiles.
    std::size_t straight_at = 0, arcs_at = 0, fringes_at = 0, bands_at = 0, pictured_at = 0;
};

// Where a tile's corners cross the stop, mm, at one wavelength.
struct TileAtStop {
    std::array<float, 4> x{}, y{};
};

// Where a list of tiles that goes block by block (of kLargestTile pixels) down the picture has the
// tiles of one row of blocks.
struct BlockRows {
    int first = 0;                  // row of blocks
    std::vector<std::uint32_t> at;  // first of each row's tiles, and the end

    template <class Tile>
    std::span<const Tile> In(const std::vector<Tile>& tiles, int row) const {
        const std::size_t n = static_cast<std::size_t>(row - first);
        if (row < first || n + 1 >= at.size()) return {};
        return std::span(tiles).subspan(at[n], at[n + 1] - at[n]);
    }
};

struct GhostTiles {
    std::vector<SmoothTile> smooth;
    std::vector<EdgeTile> edges;
    BlockRows smooth_rows, edge_rows;
    std::vector<StraightEdge> straight_edges;
    std::vector<ArcEdge> arc_edges;
    std::vector<TileAtStop> pictured;  // [crossing][traced wavelength, or the middle one]
    std::vector<FringeEdge> fringe_edges;
    std::vector<float> band_rgb;        // [band][channel] of each dispersed tile
    std::vector<float> band_sharpness;  // [band] of each
    std::vector<float> band_weights;    // [band][traced wavelength]

    // Tiles of the finest level that are left to polygons, over a box of such tiles.
    int left_x = 0, left_y = 0, left_width = 0, left_height = 0;
    std::vector<std::uint8_t> left;
    bool any_left = false;

    bool Left(int x, int y) const {
        const int i = x - left_x;
        const int j = y - left_y;
        if (i < 0 || j < 0 || i >= left_width || j >= left_height) return false;
        return left[static_cast<std::size_t>(j) * static_cast<std::size_t>(left_width) +
                    static_cast<std::size_t>(i)] != 0;
    }
};

// Can a ghost be cut into tiles? Of three channels, traced at three wavelengths.
bool CanBeTiled(const GhostLight& ghost);

// `window` is the part of the picture that is wanted, in whole tiles. Light is given in units of
// `unit`.
GhostTiles TilesOf(const GhostLight& ghost, const Iris& iris, const PictureMap& map,
                   const PixelWindow& window, const TileTolerance& tolerance, double unit);

}  // namespace flare
