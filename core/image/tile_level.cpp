// SPDX-License-Identifier: Apache-2.0
#include "core/image/tile_level.h"

#include <cmath>

namespace flare {

int FloorTo(float value, int size) {
    constexpr float kFar = 1e6F;
    const float tile = std::floor(value / static_cast<float>(size));
    return tile > -kFar ? static_cast<int>(std::min(tile, kFar)) : -static_cast<int>(kFar);
}

void TileLevel::Start(int tile_size, const TileBox& tile_box) {
    size = tile_size;
    box = tile_box;
    tile_at.assign(box.count(), -1);
    node_at.assign(
        static_cast<std::size_t>(box.width() + 1) * static_cast<std::size_t>(box.height() + 1), -1);
    tiles.clear();
    nodes.clear();
}

void TileLevel::Want(int x, int y) {
    tile_at[Tile(x, y)] = static_cast<std::int32_t>(tiles.size());
    tiles.push_back({x, y});
    for (int corner = 0; corner < 4; ++corner) {
        const int nx = x + corner % 2;
        const int ny = y + corner / 2;
        std::int32_t& at = node_at[Node(nx, ny)];
        if (at >= 0) continue;
        at = static_cast<std::int32_t>(nodes.size());
        nodes.push_back({nx, ny});
    }
}

void TileLevel::MakeRecords(int fields) {
    bad.assign(tiles.size(), 0);
    for (std::size_t s = 0; s < kSheets; ++s) {
        live[s].assign(tiles.size(), 0);
        lit[s].assign(tiles.size(), 0);
        truth[s].assign(tiles.size(), 0.0F);
        flat[s].assign(tiles.size(), 0.0F);
        Sheet& sheet = sheets[s];
        for (auto& found : sheet.found) found.assign(nodes.size(), 0);
        sheet.rgb.assign(nodes.size() * 3, 0.0F);
        sheet.middle.resize(nodes.size());
        sheet.fields.resize(nodes.size() * kTraced * static_cast<std::size_t>(fields));
        sheet.cell.resize(nodes.size());
        sheet.at.resize(nodes.size());
    }
}

TileBox TileLevel::Touched(const PixelBox& b) const {
    return {std::max(box.x0, FloorTo(b.x0, size)), std::max(box.y0, FloorTo(b.y0, size)),
            std::min(box.x1, FloorTo(b.x1, size) + 1), std::min(box.y1, FloorTo(b.y1, size) + 1)};
}

void TileLevel::Mark(std::vector<std::uint8_t>& what, const PixelBox& b) const {
    const TileBox t = Touched(b);
    for (int y = t.y0; y < t.y1; ++y) {
        for (int x = t.x0; x < t.x1; ++x) {
            const std::int32_t tile = tile_at[Tile(x, y)];
            if (tile >= 0) what[static_cast<std::size_t>(tile)] = 1;
        }
    }
}

bool TileLevel::AnyWanted(const PixelBox& b) const {
    const TileBox t = Touched(b);
    for (int y = t.y0; y < t.y1; ++y) {
        for (int x = t.x0; x < t.x1; ++x) {
            if (tile_at[Tile(x, y)] >= 0) return true;
        }
    }
    return false;
}

}  // namespace flare
