// SPDX-License-Identifier: Apache-2.0
//
// Where a cell of a ghost may lie on the picture and what its masks do there, from the Bezier nets
// alone. Pure.
#pragma once

#include <vector>

#include "core/image/ghost_walk.h"

namespace flare {

// Where a cell may lie on the picture at the given wavelengths, whether the masks let any of it
// pass, and whether they are open to all of it.
struct CellBounds {
    bool passes = false;
    bool open = true;
    double y0 = 0.0, y1 = 0.0, x0 = 0.0, x1 = 0.0;
};
CellBounds BoundCell(const GhostSurface& surface,
                     const std::vector<std::vector<double>>& node_weights, const CellPlace& cell,
                     const Iris& iris, const PictureMap& map);

}  // namespace flare
