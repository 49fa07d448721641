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
HWY_EXPORT(Points);
HWY_EXPORT(Shade);
HWY_EXPORT(Expand);

namespace {

// The padding repeats the last point.
void Pad(float* values, int count) {
    std::fill(values + count, values + kTileNodes, values[count - 1]);
}

}  // namespace

void SolveNodes(const CellFit& cell, const CellPart& part, int fields, const LightCorners* light,
                NodeBlock& block) {
    Pad(block.px, block.count);
    Pad(block.py, block.count);
    HWY_DYNAMIC_DISPATCH(Solve)(cell, part, fields, light, block);
}

void EvaluatePoints(const CellFit& cell, int fields, const LightCorners* light, NodeBlock& block) {
    Pad(block.a, block.count);
    Pad(block.b, block.count);
    HWY_DYNAMIC_DISPATCH(Points)(cell, fields, light, block);
}

void ShadeEdge(const EdgeShade& tile, float* const* planes, std::ptrdiff_t stride) {
    HWY_DYNAMIC_DISPATCH(Shade)(tile, planes, stride);
}

void ExpandTiles(const float* corners, const std::uint64_t* lit, int words, int size, int row,
                 float* const* planes) {
    HWY_DYNAMIC_DISPATCH(Expand)(corners, lit, words, size, row, planes);
}

}  // namespace flare
#endif  // HWY_ONCE
