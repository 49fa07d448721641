// SPDX-License-Identifier: Apache-2.0
//
// The cells of a ghost as polynomials in pixels, ready for SolveNodes, and a rough survey of each:
// where its parts land, which way round, and which of them no light passes.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "core/image/ghost_walk.h"
#include "core/image/tile_kernels.h"

namespace flare {

// A box of places on the picture, px, or at the stop, mm.
struct PixelBox {
    float x0 = 1e30F, y0 = 1e30F, x1 = -1e30F, y1 = -1e30F;

    bool empty() const { return !(x0 <= x1 && y0 <= y1); }
    void Join(const PixelBox& other);
    void Clip(const PixelBox& other);
    PixelBox Grown(float by_x, float by_y) const {
        return {x0 - by_x, y0 - by_y, x1 + by_x, y1 + by_y};
    }
    // Squared distance from the origin, of the box's nearest and of its farthest point.
    float Nearest2() const;
    float Farthest2() const;
};

// What a cell may touch.
PixelBox BoxOf(const GhostLight::Cell& cell);

// A part of a cell at one traced wavelength.
struct PartView {
    PixelBox box;                    // with some room
    bool folds = false;              // the Jacobian changes its sign
    std::array<bool, 2> on_sheet{};  // positive, negative Jacobian
};
struct FittedPart {
    CellPart range;
    bool shut = false;  // by masks, at all wavelengths
    bool open = true;   // to all of it, at all wavelengths
    std::array<PartView, kTracedInTiles> views;
};

struct FittedCell {
    int cell = 0;  // index in GhostLight::cells
    bool ring = false;
    bool open = false;  // no mask cuts it
    std::array<CellFit, kTracedInTiles> fits;
    // What the cell may touch: beyond it, it is taken for absent, since a crop may lack it.
    PixelBox box;
    std::array<PixelBox, kTracedInTiles> boxes;
    float u = 0.0F, v = 0.0F, step = 1.0F;  // corner and side, in cells of the mesh's main grid
    std::size_t parts_at = 0, part_count = 0;
    // Places along each side for Newton's method to start from; 0: the middle of each part.
    std::array<int, kTracedInTiles> starts{1, 1, 1};
};

using Triangle = std::array<Vec2d, 3>;  // corners, px

class FittedGhost {
  public:
    // Fits the cells; all arguments must outlive it.
    FittedGhost(const GhostLight& ghost, const Iris& iris, const PictureMap& map);

    std::vector<FittedCell>& cells() { return cells_; }
    const std::vector<FittedCell>& cells() const { return cells_; }
    std::span<const FittedPart> Parts(const FittedCell& cell) const {
        return {parts_.data() + cell.parts_at, cell.part_count};
    }
    // The triangles of the mesh, each at all drawn wavelengths.
    const std::vector<std::vector<Triangle>>& triangles() const { return triangles_; }
    // Fits the masks of a cell, if they are not yet: cells that no mask cuts seldom need them.
    void NeedMasks(FittedCell& cell) {
        if (ghost_.masks.count() > 0 && cell.fits[0].field_count == 0) FitMasks(cell);
    }

  private:
    void FitMasks(FittedCell& cell);
    void AddTriangle(const CellPlace& place);

    const GhostLight& ghost_;
    const PictureMap& map_;
    std::vector<FittedCell> cells_;
    std::vector<FittedPart> parts_;
    std::vector<std::vector<Triangle>> triangles_;
    std::unique_ptr<CellPolynomial[]> fields_;  // [cell][wavelength][field]: the fits point to it
};

// The masks that cut any of the cells, which are all that the iris lets pass.
MaskFields MasksOf(const GhostSurface& surface, const std::vector<GhostLight::Cell>& cells,
                   const Iris& iris);

}  // namespace flare
