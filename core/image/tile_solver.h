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
    TileSolver(const GhostLight& ghost, const Iris& iris, FittedGhost& fitted,
               const TileLight& light, const TileTolerance& tolerance, TileLevel& level)
        : ghost_(ghost),
          iris_(iris),
          fitted_(fitted),
          light_(light),
          tolerance_(tolerance),
          level_(level),
          masks_(ghost.masks) {}

    // After the level's records have been made.
    void Run();

  private:
    void MarkCell(const FittedCell& cell);
    int MasksFor(FittedCell& cell, const PixelBox& box);
    void SolveCell(FittedCell& cell, std::size_t k);
    void SolvePart(const FittedCell& cell, std::size_t k, const CellPart& part,
                   const PixelBox& box);
    void SolveBlock(const FittedCell& cell, std::size_t k, const CellPart& part);
    void Keep(const FittedCell& cell, std::size_t k, std::size_t n, std::size_t node,
              TileLevel::Sheet& sheet) const;
    void FillEnds();
    void FillNode(TileLevel::Sheet& sheet, std::size_t node, const std::array<float, 2>& px);
    void CheckCell(FittedCell& cell);
    void CheckPoint(std::size_t n, const TileColour& truth, float share);
    std::array<float, kTileLights> LightAt(const FittedCell& cell, std::size_t k,
                                           std::size_t n) const;
    bool CheckMasks(std::size_t n, const TileLevel::Sheet& sheet, std::size_t tile,
                    const std::array<std::size_t, 4>& corners, const std::array<float, 4>& w);
    float EdgeTolerance(std::size_t f) const;
    bool Passes(std::size_t n) const;
    bool FarFromIris(const std::array<std::size_t, 4>& corners, const TileLevel::Sheet& sheet,
                     std::size_t f) const;
    void TakeLight(TileLight::Of what, const FittedCell& cell, std::size_t k);

    const GhostLight& ghost_;
    const Iris& iris_;
    FittedGhost& fitted_;
    const TileLight& light_;
    const TileTolerance& tolerance_;
    TileLevel& level_;
    const MaskFields& masks_;
    NodeBlock block_;
    std::array<std::size_t, kTileNodes> nodes_{};
    TileLight::Of what_ = TileLight::Of::kAll;
    LightCorners corners_;                // light of the cell at hand
    const LightCorners* even_ = nullptr;  // if it is bilinear
    int fields_ = 0;                      // wanted of the cell at hand
};

}  // namespace flare
