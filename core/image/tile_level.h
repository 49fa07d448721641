// SPDX-License-Identifier: Apache-2.0
//
// What GhostTiles knows of the tiles and nodes of one level while it works. Tiles are counted from
// the picture's origin, in units of their size; a node stands at its tile's first corner. The two
// sheets of a ghost are kept apart: that of positive and that of negative Jacobian.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/image/cell_fits.h"
#include "core/image/tile_bits.h"
#include "core/image/tile_kernels.h"
#include "core/image/tile_light.h"

namespace flare {

inline constexpr std::size_t kSheets = 2;
inline constexpr std::size_t kTraced = kTracedInTiles;

// The tile that holds a place; far away is far away.
inline int FloorTo(float value, int size) {
    constexpr float kFar = 1e6F;
    const float tile = value / static_cast<float>(size);
    const int whole = static_cast<int>(tile < kFar ? std::max(tile, -kFar) : kFar);
    return static_cast<float>(whole) > tile ? whole - 1 : whole;
}

// Maps over the ghost's box say which tiles and nodes are wanted and where their records are.
struct TileLevel {
    int size = 0;
    TileBox box;
    TileBits wanted, wanted_nodes;
    std::array<TileBits, kSheets> live;          // light of the sheet may fall there
    TileBits cut;                                // a mask may cut it
    TileBits shut;                               // a mask may shut it, or part of it
    TileBits folded;                             // not for tiles of this size
    std::vector<std::int32_t> tile_at, node_at;  // of the records, where wanted
    std::vector<std::array<int, 2>> tiles, nodes;

    // Records of tiles.
    std::vector<std::uint8_t> bad;                       // to be refined
    std::array<std::vector<std::uint8_t>, kSheets> lit;  // one of the cells' own points passes
    // Sums over the cells' own points, of each sheet.
    struct Sums {
        float area = 0.0F;
        TileColour truth{}, flat{};  // their light, and what the corners make of it there
        float bulge = 0.0F;          // u (1 - u) + v (1 - v), of places in the tile
        // By how much bilinear light is to be scaled: it is too much where light is convex.
        TileColour Scale() const;
    };
    std::array<std::vector<Sums>, kSheets> sums;

    // Records of nodes.
    struct Sheet {
        std::array<std::vector<std::uint8_t>, kTraced> found;  // solutions
        std::vector<float> rgb;          // [node][channel], over all wavelengths
        std::vector<TileColour> middle;  // of all bands by the middle map
        std::vector<float> fields;       // [node][traced][field], where cut
        // The cell of the solution and the place in it.
        std::array<std::vector<std::int32_t>, kTraced> cell;
        std::array<std::vector<std::array<float, 2>>, kTraced> at;
        std::array<std::vector<float>, kTraced> stretch;  // |d(x, y) / d(a, b)| there
    };
    std::array<Sheet, kSheets> sheets;

    void Start(int tile_size, const TileBox& tile_box);
    void Want(int x, int y);
    // After all that is wanted is known.
    void MakeRecords(int fields);
    std::size_t Tile(int x, int y) const {
        return static_cast<std::size_t>(y - box.y0) * static_cast<std::size_t>(box.width()) +
               static_cast<std::size_t>(x - box.x0);
    }
    std::size_t Node(int x, int y) const {
        return static_cast<std::size_t>(y - box.y0) * static_cast<std::size_t>(box.width() + 1) +
               static_cast<std::size_t>(x - box.x0);
    }
    // Records of a wanted tile's corners.
    std::array<std::size_t, 4> Corners(int x, int y) const {
        const std::int32_t* const at = &node_at[Node(x, y)];
        const std::int32_t* const below = at + box.width() + 1;
        return {static_cast<std::size_t>(at[0]), static_cast<std::size_t>(at[1]),
                static_cast<std::size_t>(below[0]), static_cast<std::size_t>(below[1])};
    }
    // Marks the tiles that the triangles or what lies between them in a row touch, with a little
    // room.
    void MarkTriangles(const std::vector<Triangle>& triangles, TileBits& bits) const;
    // The tiles that a box of pixels touches, and the nodes in it.
    TileBox Touched(const PixelBox& b) const;
    TileBox NodesIn(const PixelBox& b) const;
};

}  // namespace flare
