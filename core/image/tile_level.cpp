// SPDX-License-Identifier: Apache-2.0
#include "core/image/tile_level.h"

#include <algorithm>
#include <cmath>

namespace flare {

void TileLevel::Start(int tile_size, const TileBox& tile_box) {
    size = tile_size;
    box = tile_box;
    for (TileBits* const bits : {&wanted, &live[0], &live[1], &cut, &shut, &folded})
        bits->Start(box);
    wanted_nodes.Start({box.x0, box.y0, box.x1 + 1, box.y1 + 1});
    tile_at.resize(std::max(tile_at.size(), box.count()));
    node_at.resize(std::max(node_at.size(), static_cast<std::size_t>(box.width() + 1) *
                                                static_cast<std::size_t>(box.height() + 1)));
    tiles.clear();
    nodes.clear();
}

void TileLevel::Want(int x, int y) {
    wanted.Mark(x, y);
    tile_at[Tile(x, y)] = static_cast<std::int32_t>(tiles.size());
    tiles.push_back({x, y});
    for (int corner = 0; corner < 4; ++corner) {
        const int nx = x + corner % 2;
        const int ny = y + corner / 2;
        if (wanted_nodes.Has(nx, ny)) continue;
        wanted_nodes.Mark(nx, ny);
        node_at[Node(nx, ny)] = static_cast<std::int32_t>(nodes.size());
        nodes.push_back({nx, ny});
    }
}

void TileLevel::MakeRecords(int fields) {
    bad.assign(tiles.size(), 0);
    for (std::size_t s = 0; s < kSheets; ++s) {
        lit[s].assign(tiles.size(), 0);
        sums[s].assign(tiles.size(), Sums());
        Sheet& sheet = sheets[s];
        for (auto& found : sheet.found) found.assign(nodes.size(), 0);
        sheet.rgb.assign(nodes.size() * 3, 0.0F);
        sheet.middle.resize(nodes.size());
        sheet.fields.resize(nodes.size() * kTraced * static_cast<std::size_t>(fields));
        for (auto& cell : sheet.cell) cell.resize(nodes.size());
        for (auto& at : sheet.at) at.resize(nodes.size());
        for (auto& stretch : sheet.stretch) stretch.resize(nodes.size());
    }
}

// A parabola's excess over its chords goes with the bulge, whose mean over a tile is 1/3: few
// points near the middle would say too much. Channels bend differently, as coatings do.
TileColour TileLevel::Sums::Scale() const {
    constexpr float kMeanBulge = 1.0F / 3.0F;
    constexpr float kMost = 0.25F;
    TileColour scale = {1.0F, 1.0F, 1.0F};
    if (!(area > 0.0F)) return scale;
    const float mean = std::clamp(bulge / area, 0.5F * kMeanBulge, 2.0F * kMeanBulge);
    for (std::size_t c = 0; c < 3; ++c) {
        const float excess = (truth[c] - flat[c]) / flat[c] * kMeanBulge / mean;
        if (std::abs(excess) < kMost) scale[c] += excess;
    }
    return scale;
}

TileBox TileLevel::Touched(const PixelBox& b) const {
    return {FloorTo(b.x0, size), FloorTo(b.y0, size), FloorTo(b.x1, size) + 1,
            FloorTo(b.y1, size) + 1};
}

TileBox TileLevel::NodesIn(const PixelBox& b) const {
    return {FloorTo(b.x0, size) + 1, FloorTo(b.y0, size) + 1, FloorTo(b.x1, size) + 1,
            FloorTo(b.y1, size) + 1};
}

}  // namespace flare
