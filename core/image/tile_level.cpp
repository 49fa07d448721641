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

void TileLevel::MarkTriangles(const std::vector<Triangle>& triangles, TileBits& bits) const {
    constexpr double kRoom_px = 2.0;
    double low = 1e300;
    double high = -1e300;
    for (const Triangle& triangle : triangles) {
        for (const Vec2d& p : triangle) {
            low = std::min(low, p.y);
            high = std::max(high, p.y);
        }
    }
    const int first = std::max(FloorTo(static_cast<float>(low - kRoom_px), size), box.y0);
    const int last = std::min(FloorTo(static_cast<float>(high + kRoom_px), size), box.y1 - 1);
    for (int y = first; y <= last; ++y) {
        // Corners within this row of tiles, and where sides enter and leave it.
        const double above = y * size - kRoom_px;
        const double below = (y + 1) * size + kRoom_px;
        double left = 1e300;
        double right = -1e300;
        const auto join = [&](double x) {
            left = std::min(left, x);
            right = std::max(right, x);
        };
        for (const Triangle& triangle : triangles) {
            for (std::size_t c = 0; c < 3; ++c) {
                const Vec2d& p = triangle[c];
                const Vec2d& q = triangle[(c + 1) % 3];
                if (p.y >= above && p.y <= below) join(p.x);
                for (const double edge : {above, below}) {
                    if ((p.y < edge) != (q.y < edge))
                        join(p.x + (q.x - p.x) * ((edge - p.y) / (q.y - p.y)));
                }
            }
        }
        if (left > right) continue;
        bits.Mark({FloorTo(static_cast<float>(left - kRoom_px), size), y,
                   FloorTo(static_cast<float>(right + kRoom_px), size) + 1, y + 1});
    }
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
