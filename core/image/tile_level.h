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
#include "core/image/tile_kernels.h"

namespace flare {

inline constexpr std::size_t kSheets = 2;
inline constexpr std::size_t kTraced = kTracedInTiles;

struct TileBox {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // tiles x0 ... x1 - 1
    int width() const { return x1 - x0; }
    int height() const { return y1 - y0; }
    std::size_t count() const {
        return static_cast<std::size_t>(width()) * static_cast<std::size_t>(height());
    }
};

// The tile that holds a place; far away is far away.
int FloorTo(float value, int size);

// Maps over the ghost's box say which tiles and nodes are wanted and where their records are.
struct TileLevel {
    int size = 0;
    TileBox box;
    std::vector<std::int32_t> tile_at, node_at;  // of the records, -1: not wanted
    std::vector<std::array<int, 2>> tiles, nodes;

    // Records of tiles.
    std::vector<std::uint8_t> bad;                        // to be refined
    std::array<std::vector<std::uint8_t>, kSheets> live;  // cells that are drawn touch it
    std::array<std::vector<std::uint8_t>, kSheets> lit;   // one of the cells' own points passes
    // Light of the cells' own points, and what the corners make of it there, of each sheet.
    std::array<std::vector<float>, kSheets> truth, flat;

    // Records of nodes.
    struct Sheet {
        std::array<std::vector<std::uint8_t>, kTraced> found;  // solutions
        std::vector<float> rgb;          // [node][channel], over all wavelengths
        std::vector<float> middle;       // light of all bands by the middle wavelength's map
        std::vector<float> fields;       // [node][traced][field]
        std::vector<std::int32_t> cell;  // of the middle wavelength
        std::vector<std::array<float, 2>> at;
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
    // The tiles that a box of pixels touches.
    TileBox Touched(const PixelBox& b) const;
    void Mark(std::vector<std::uint8_t>& what, const PixelBox& b) const;
    // Is any tile that the box touches wanted?
    bool AnyWanted(const PixelBox& b) const;
};

}  // namespace flare
