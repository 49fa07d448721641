// SPDX-License-Identifier: Apache-2.0
//
// The inner loops of the tile rasteriser, compiled for each instruction set and chosen at run time:
// finding the pupil points that land on given places of the picture, and shading tiles. Single
// precision; results depend on the instruction set in the last bits (ArithmeticClass).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace flare {

inline constexpr int kTileNodes = 64;    // places solved in one call, a multiple of any vector
inline constexpr int kTileFields = 40;   // most mask fields of a ghost
inline constexpr int kLargestTile = 64;  // pixels along a side
inline constexpr int kLargestEdgeTile = 16;
inline constexpr int kTilePixels = kLargestEdgeTile * kLargestEdgeTile;
inline constexpr int kTracedInTiles = 3;  // wavelengths
inline constexpr int kTileEdges = 12;     // most straight edges in a tile, and most arcs

// A polynomial over a cell, 0 <= a, b <= 1: coefficient [4 * power of b + power of a].
using CellPolynomial = std::array<float, 16>;

// One cell of a ghost at one traced wavelength: where it lands, in pixels, and its masks.
struct CellFit {
    CellPolynomial x{}, y{};
    const CellPolynomial* fields = nullptr;
    int field_count = 0;
};

// The part of a cell in which solutions are sought, a0 <= a <= a1, b0 <= b <= b1, and a hair more:
// a point on a shared border is found in both of its parts.
struct CellPart {
    float a0 = 0.0F, a1 = 1.0F, b0 = 0.0F, b1 = 1.0F;
};

// Light at a cell's corners (0, 0), (1, 0), (0, 1), (1, 1): `count` numbers at each.
inline constexpr int kTileLights = 6;
struct LightCorners {
    int count = 0;
    std::array<std::array<float, kTileLights>, 4> at{};
};

struct NodeBlock {
    int count = 0;                                     // in
    alignas(64) float px[kTileNodes], py[kTileNodes];  // places on the picture
    alignas(64) float a[kTileNodes], b[kTileNodes];    // in the cell
    alignas(64) float det[kTileNodes];                 // Jacobian d(x, y) / d(a, b)
    alignas(64) float light[kTileLights][kTileNodes];  // a pixel: LightCorners over |det|
    alignas(64) float fields[kTileFields][kTileNodes];
    std::uint64_t found = 0;  // bit n: the point lies in the part
};

// Finds what lands at (px, py) by Newton's method from the part's middle: a, b, det and, if asked
// for, the first `fields` masks and the light (null: none) there.
void SolveNodes(const CellFit& cell, const CellPart& part, int fields, const LightCorners* light,
                NodeBlock& block);

// The same with the points (a, b) given and (px, py) found.
void EvaluatePoints(const CellFit& cell, int fields, const LightCorners* light, NodeBlock& block);

// A mask's edge within a tile, in pixels across the edge: negative inside. Corner values are those
// at (0, 0), (1, 0), (0, 1), (1, 1).
struct StraightEdge {
    float corners[4];
};
struct ArcEdge {
    float x[4], y[4];                          // from the arc's centre, mm
    float radius2;                             // mm^2
    float per_x_x, per_x_y, per_y_x, per_y_y;  // d(x, y) for a pixel to the right, and down
};

// An edge with a profile across it (edge_profile.h), in steps of its table: over the distance from
// a straight edge, in mm, or from an arc.
struct FringeEdge {
    float x[4] = {}, y[4] = {};  // from an arc's centre; straight: x is the distance
    float radius = 0.0F;         // 0: straight
    float per_mm = 0.0F;         // steps
    float half = 0.0F;           // of a pixel's extent across the edge, steps
    std::ptrdiff_t table = 0;    // first of its bands' tables
};

struct EdgeShade {
    int size = 0;  // pixels along the tile's side: 16, 8 or 4
    // Of each traced wavelength, one wavelength after another; at most kTileEdges of either.
    int straight = 0, arcs = 0;
    const StraightEdge* straight_edges = nullptr;
    const ArcEdge* arc_edges = nullptr;
    // Edges with a profile; only with dispersion. `fringe_start`: the place of an edge in its
    // table.
    int fringes = 0;
    const FringeEdge* fringe_edges = nullptr;
    const float* fringe_tables = nullptr;
    int fringe_entries = 0;
    float fringe_start = 0.0F;
    float light[3][4];  // at the corners
    // With dispersion: each band's share and how it leans on the traced wavelengths.
    int bands = 0;                          // 0: without
    const float* band_rgb = nullptr;        // [band][3]
    const float* band_weights = nullptr;    // [band][kTracedInTiles]
    const float* band_sharpness = nullptr;  // [band]: 1 over the width of its edge, px
    // `light` is then a factor on band_rgb.
    // What a picture of the stop lets pass, null: all: rows of kLargestEdgeTile, for each band.
    const float* pass = nullptr;
};

// Adds the light per pixel of an edge tile of 16, 8 or 4 pixels to three planes; each pointer is to
// the tile's first pixel, rows are `stride` floats apart.
void ShadeEdge(const EdgeShade& tile, float* const* planes, std::ptrdiff_t stride);

// Adds to one row of the three planes what the tiles of 64, 32, 16, 8 or 4 pixels hold whose bits
// are set in the `words` of `lit`: `corners` is [tile][corner][channel], the row is the `row`th of
// the tiles.
void ExpandTiles(const float* corners, const std::uint64_t* lit, int words, int size, int row,
                 float* const* planes);

}  // namespace flare
