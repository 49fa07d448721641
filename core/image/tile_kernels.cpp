// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/image/tile_kernels.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h must come before highway.h.
#include <hwy/highway.h>

#include "core/image/tile_kernels-inl.h"

#if HWY_ONCE

namespace flare {

HWY_EXPORT(Solve);
HWY_EXPORT(Shade);
HWY_EXPORT(Expand);

void SolveNodes(const CellFit& cell, const CellPart& part, NodeBlock& block) {
    // The padding repeats the last place.
    for (int n = block.count; n < kTileNodes; ++n) {
        block.px[n] = block.px[block.count - 1];
        block.py[n] = block.py[block.count - 1];
    }
    HWY_DYNAMIC_DISPATCH(Solve)(cell, part, block);
}

void ShadeEdge(const EdgeShade& tile, TilePixels& out) {
    HWY_DYNAMIC_DISPATCH(Shade)(tile, out);
}

void ExpandTiles(const float* corners, int tiles, int size, int row, float* const* planes) {
    HWY_DYNAMIC_DISPATCH(Expand)(corners, tiles, size, row, planes);
}

}  // namespace flare
#endif  // HWY_ONCE
