// SPDX-License-Identifier: Apache-2.0
//
// What a ghost mesh keeps of its traced grids: the rims that cut it, and of each grid the cells in
// use with the vertices around them that their slopes need. Used by the mesh builder.
#pragma once

#include <vector>

#include "core/mesh/ghost_mesh.h"
#include "core/mesh/raw_grid.h"

namespace flare {

// Fills `mesh.rims` and `mesh.grids`. `raws`: the main grid, then its patches, of a mirrored one
// those of the traced half; their cells have been put to use.
void PackGrids(const GridTracer& tracer, const std::vector<RawGrid>& raws, GhostMesh& mesh);

}  // namespace flare
