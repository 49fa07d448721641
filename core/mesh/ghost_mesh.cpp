// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/ghost_mesh.h"

namespace flare {

std::size_t GhostMesh::bytes() const {
    std::size_t sum =
        sizeof(GhostMesh) + (sequence.size() + rims.size() + absorbing.size()) * sizeof(int);
    for (const MeshGrid& grid : grids) {
        sum += sizeof(MeshGrid) + grid.alive.size() + grid.cells.size();
        for (const MeshNode& node : grid.nodes) {
            sum += sizeof(MeshNode) + (node.fields.size() + node.passage.size()) * sizeof(float);
        }
    }
    return sum;
}

}  // namespace flare
