// SPDX-License-Identifier: Apache-2.0
//
// The cells of a ghost as polynomials in pixels, ready for SolveNodes.
#pragma once

#include <array>
#include <vector>

#include "core/image/ghost_walk.h"
#include "core/image/tile_kernels.h"

namespace flare {

struct PixelBox {
    float x0 = 1e30F, y0 = 1e30F, x1 = -1e30F, y1 = -1e30F;

    bool empty() const { return !(x0 <= x1 && y0 <= y1); }
    void Join(const PixelBox& other);
};

// What a cell may touch.
PixelBox BoxOf(const GhostLight::Cell& cell);

struct FittedCell {
    int cell = 0;  // index in GhostLight::cells
    bool ring = false;
    std::array<CellFit, kTracedInTiles> fits;
    std::array<PixelBox, kTracedInTiles> boxes;
    std::array<int, kTracedInTiles> parts{1, 1, 1};  // along each side, for Newton to start from
    std::array<bool, 2> on_sheet{};  // positive, negative Jacobian: at any wavelength
};

// The masks that cut any of the cells, which are all that the iris lets pass.
MaskFields MasksOf(const GhostSurface& surface, const std::vector<GhostLight::Cell>& cells,
                   const Iris& iris);

std::vector<FittedCell> FitCells(const GhostLight& ghost, const PictureMap& map);

// Value and slopes of a polynomial.
struct PolynomialJet {
    float value = 0.0F, per_a = 0.0F, per_b = 0.0F;
};
PolynomialJet JetOf(const CellPolynomial& p, float a, float b);

}  // namespace flare
