// SPDX-License-Identifier: Apache-2.0
//
// Turns a solved tile into a smooth one or, where masks cut it, into one with edges.
#pragma once

#include <array>
#include <vector>

#include "core/image/ghost_tiles.h"
#include "core/image/tile_level.h"
#include "core/image/tile_light.h"

namespace flare {

class TileEdges {
  public:
    // All arguments must outlive it; tiles are added to `out`, their light in units of `unit`.
    TileEdges(const GhostLight& ghost, const Iris& iris, const std::vector<FittedCell>& cells,
              const TileLight& light, double unit, GhostTiles& out)
        : ghost_(ghost),
          iris_(iris),
          cells_(cells),
          light_(light),
          unit_(unit),
          out_(out),
          masks_(ghost.masks) {}

    enum class Outcome {
        kAdded,
        kShut,      // by a mask
        kDark,      // beyond the fringes
        kTooMany,   // edges for the kernel
        kTooLarge,  // a tile for edges
    };
    // The tile (x, y) of a level with its corners on one sheet, its light times `scale`; `cut` says
    // whether a mask may cut it.
    Outcome Emit(int level, int x, int y, const TileLevel::Sheet& sheet,
                 const std::array<std::size_t, 4>& corners, const TileColour& scale, bool cut);

  private:
    // Corner values of a condition at one wavelength, as pixels across the edge.
    struct Scalar {
        std::array<float, 4> at{};
        float lo = 0.0F, hi = 0.0F;  // over the tile, with half a pixel of room
    };
    static Scalar InPixels(std::array<float, 4> at, int size);

    float Field(const TileLevel::Sheet& sheet, std::size_t node, std::size_t k,
                std::size_t f) const {
        return sheet.fields[(node * kTraced + k) * static_cast<std::size_t>(masks_.count()) + f];
    }
    template <class At>
    bool AddStraight(At at);
    bool AddArc(const Iris::Edge& edge, std::size_t c, const TileLevel::Sheet& sheet,
                const std::array<std::size_t, 4>& corners);
    bool AddFringe(const Iris::Edge& edge, std::size_t c, const TileLevel::Sheet& sheet,
                   const std::array<std::size_t, 4>& corners);
    // False if the iris shuts the tile out.
    bool AddIris(std::size_t c, const TileLevel::Sheet& sheet,
                 const std::array<std::size_t, 4>& corners);
    bool AddPicture(std::size_t c, const TileLevel::Sheet& sheet,
                    const std::array<std::size_t, 4>& corners);
    bool whole() const {
        return straight_.empty() && arcs_.empty() && pictured_.empty() && fringes_.empty();
    }
    void EmitEdge(int level, int x, int y, const TileLevel::Sheet& sheet,
                  const std::array<std::size_t, 4>& corners, const TileCorners& light);
    void Rescale(TileCorners& light) const;
    bool Disperses() const;
    void AddBands(EdgeTile& tile, const TileLevel::Sheet& sheet,
                  const std::array<std::size_t, 4>& corners);
    void AddSharpness();

    const GhostLight& ghost_;
    const Iris& iris_;
    const std::vector<FittedCell>& cells_;
    const TileLight& light_;
    double unit_;
    GhostTiles& out_;
    const MaskFields& masks_;
    int size_ = 0;       // of the tile at hand
    bool dark_ = false;  // it lies beyond the fringes of an edge
    std::vector<std::array<Scalar, kTraced>> straight_;
    std::vector<std::array<ArcEdge, kTraced>> arcs_;
    std::vector<std::array<TileAtStop, kTraced>> pictured_;
    std::vector<std::array<FringeEdge, kTraced>> fringes_;
};

}  // namespace flare
