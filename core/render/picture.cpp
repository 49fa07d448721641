// SPDX-License-Identifier: Apache-2.0
#include "core/render/picture.h"

#include <algorithm>

#include "core/image/raster_sink.h"

namespace flare {
namespace {

constexpr int kStripRows = 64;

}  // namespace

Picture::Picture(const PixelWindow& window, int planes) : window_(window) {
    planes_.assign(static_cast<std::size_t>(planes), std::vector<double>(window.pixels(), 0.0));
}

WalkWindow WalkWindowOf(const PixelWindow& window) {
    return {static_cast<double>(window.x), static_cast<double>(window.y),
            static_cast<double>(window.x + window.width),
            static_cast<double>(window.y + window.height)};
}

Picture::Drawn Picture::Draw(const std::vector<GhostLight>& ghosts, const Iris& iris,
                             const PictureMap& map, const WalkTolerance& tolerance,
                             ThreadPool& threads, const CancelToken& cancel) {
    const int strips = (window_.height + kStripRows - 1) / kStripRows;
    std::vector<Drawn> drawn(static_cast<std::size_t>(strips));
    threads.For(strips, [&](int strip) {
        const int row = strip * kStripRows;
        const int rows = std::min(kStripRows, window_.height - row);
        drawn[static_cast<std::size_t>(strip)] =
            DrawStrip(row, rows, ghosts, iris, map, tolerance, cancel);
    });
    Drawn sum;
    for (const Drawn& d : drawn) {
        sum.pieces += d.pieces;
        sum.fragments += d.fragments;
    }
    return sum;
}

Picture::Drawn Picture::DrawStrip(int row, int rows, const std::vector<GhostLight>& ghosts,
                                  const Iris& iris, const PictureMap& map,
                                  const WalkTolerance& tolerance, const CancelToken& cancel) {
    RasterTarget target;
    target.x0 = window_.x;
    target.y0 = window_.y + row;
    target.width = window_.width;
    target.rows = rows;
    for (std::vector<double>& plane : planes_) {
        target.planes.push_back(plane.data() + static_cast<std::ptrdiff_t>(row) * window_.width);
    }
    const WalkWindow window = WalkWindowOf({window_.x, target.y0, window_.width, rows});

    Drawn drawn;
    for (const GhostLight& ghost : ghosts) {
        if (cancel.cancelled()) break;
        if (ghost.cells.empty()) continue;
        RasterSink sink(ghost, target);
        GhostWalk walk(ghost, iris, map, tolerance);
        for (const GhostLight::Cell& cell : ghost.cells) {
            if (cell.y1 >= window.y0 && cell.y0 <= window.y1) walk.Cell(cell, window, sink);
        }
        drawn.pieces += walk.pieces();
        drawn.fragments += sink.fragments();
    }
    return drawn;
}

}  // namespace flare
