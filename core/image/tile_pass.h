// SPDX-License-Identifier: Apache-2.0
//
// What the iris's picture lets pass of the pixels of an edge tile, drawn band by drawn band. Pure.
#pragma once

#include <vector>

#include "core/image/ghost_tiles.h"

namespace flare {

// Rows of kLargestEdgeTile pixels, one layer a band if the tile is dispersed, else one. The tile is
// one of `tiles`, and pictured at one crossing at least.
void FindTilePass(const GhostTiles& tiles, const EdgeTile& tile, const StopPicture& picture,
                  std::vector<float>& pass);

}  // namespace flare
