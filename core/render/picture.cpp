// SPDX-License-Identifier: Apache-2.0
#include "core/render/picture.h"

#include <algorithm>
#include <limits>

#include "core/image/raster_sink.h"

namespace flare {
namespace {

constexpr int kStripRows = 64;

}  // namespace

Picture::Picture(const PixelWindow& window, int spectral_layers)
    : window_(window), spectral_(spectral_layers > 0) {
    if (spectral_) {
        layers_.assign(static_cast<std::size_t>(spectral_layers),
                       std::vector<double>(window.pixels(), 0.0));
    } else {
        layers_.assign(1, std::vector<double>(window.pixels() * kColourStride, 0.0));
    }
}

void Picture::Clear() {
    for (std::vector<double>& layer : layers_) std::fill(layer.begin(), layer.end(), 0.0);
}

std::vector<float> Picture::Channel(int index, double scale) const {
    constexpr double kMost = std::numeric_limits<float>::max();
    const std::vector<double>& layer = layers_[spectral_ ? static_cast<std::size_t>(index) : 0];
    const std::size_t stride = spectral_ ? 1 : kColourStride;
    const std::size_t offset = spectral_ ? 0 : static_cast<std::size_t>(index);
    std::vector<float> values(window_.pixels());
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] =
            static_cast<float>(std::clamp(layer[i * stride + offset] * scale, -kMost, kMost));
    }
    return values;
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
    const std::ptrdiff_t stride = spectral_ ? 1 : kColourStride;
    for (std::vector<double>& layer : layers_) {
        target.layers.push_back(layer.data() + stride * row * window_.width);
    }
    const WalkWindow window = WalkWindowOf({window_.x, target.y0, window_.width, rows});

    Drawn drawn;
    for (const GhostLight& ghost : ghosts) {
        if (cancel.cancelled()) break;
        if (ghost.cells.empty()) continue;
        RasterSink sink(ghost, target);
        GhostWalk walk(ghost, iris, map, tolerance);
        for (const GhostLight::Cell& cell : ghost.cells) {
            if (!cell.ring && cell.y1 >= window.y0 && cell.y0 <= window.y1)
                walk.Cell(cell, window, sink);
        }
        drawn.pieces += walk.pieces();
        drawn.fragments += sink.fragments();
    }
    return drawn;
}

}  // namespace flare
