// SPDX-License-Identifier: Apache-2.0
//
// Draws the pieces that a GhostWalk hands out.
#pragma once

#include "core/image/ghost_walk.h"
#include "core/image/polygon_raster.h"

namespace flare {

class RasterSink final : public PieceSink {
  public:
    // The ghost must outlive the sink.
    RasterSink(const GhostLight& ghost, const RasterTarget& target);

    void Add(std::span<const Vec2d> points, std::span<const double> light, int band) override;
    void EndOfPiece() override;

    std::uint64_t fragments() const { return raster_.fragments(); }

  private:
    const GhostLight& ghost_;
    PolygonRaster raster_;
};

}  // namespace flare
