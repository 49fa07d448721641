// SPDX-License-Identifier: Apache-2.0
#include "core/image/raster_sink.h"

namespace flare {

RasterSink::RasterSink(const GhostLight& ghost, const RasterTarget& target)
    : ghost_(ghost), raster_(target, ghost.channels) {}

void RasterSink::Add(std::span<const Vec2d> points, std::span<const double> light, int band) {
    raster_.Add(points, light, ghost_.bands[static_cast<std::size_t>(band)].layer);
}

void RasterSink::EndOfPiece() {
    raster_.Flush();
}

}  // namespace flare
