// SPDX-License-Identifier: Apache-2.0
//
// Fills a level of tiles from a ghost's cells: solves for what lands on the wanted nodes, and holds
// the wanted tiles to points of the cells themselves.
#pragma once

#include <array>
#include <vector>

#include "core/image/ghost_tiles.h"
#include "core/image/tile_level.h"
#include "core/image/tile_light.h"

namespace flare {

class TileSolver {
  public:
    // All arguments must outlive it.
    TileSolver(const GhostLight& ghost, const Iris& iris, const std::vector<FittedCell>& cells,
               const TileLight& light, const TileTolerance& tolerance, TileLevel& level)
        : ghost_(ghost),
          iris_(iris),
          cells_(cells),
          light_(light),
          tolerance_(tolerance),
          level_(level),
          masks_(ghost.masks) {}

    // After the level's records have been made.
    void Run();

  private:
    void SolveCell(const FittedCell& cell, std::size_t k);
    void SolvePart(const FittedCell& cell, std::size_t k, const CellPart& part,
                   const PixelBox& box);
    void SolveBlock(const FittedCell& cell, std::size_t k, const CellPart& part);
    void CheckCell(const FittedCell& cell);
    void CheckPoint(const FittedCell& cell, const CellFit& fit, float a, float b, float share);
    bool Passes(const CellFit& fit, float a, float b) const;
    bool FarFromIris(const std::array<std::size_t, 4>& corners, const TileLevel::Sheet& sheet,
                     std::size_t f) const;

    const GhostLight& ghost_;
    const Iris& iris_;
    const std::vector<FittedCell>& cells_;
    const TileLight& light_;
    const TileTolerance& tolerance_;
    TileLevel& level_;
    const MaskFields& masks_;
    NodeBlock block_;
    std::array<std::size_t, kTileNodes> nodes_{};
};

}  // namespace flare
