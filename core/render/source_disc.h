// SPDX-License-Identifier: Apache-2.0
//
// A light that is a disc, in parts of equal solid angle: squares of the square that the concentric
// map (Shirley and Chiu 1997, A low distortion map between disk and square) takes to the disc. Each
// part is a point light at its middle, with its share of the irradiance, and an outline to blur
// that point's ghosts by.
#pragma once

#include "core/image/source_kernel.h"
#include "core/render/lights.h"

namespace flare {

// A part of the map's square, -1..1 along both sides.
struct SourceSquare {
    double x0 = -1.0, x1 = 1.0, y0 = -1.0, y1 = 1.0;

    bool whole() const { return x0 == -1.0 && x1 == 1.0 && y0 == -1.0 && y1 == 1.0; }
    double share() const { return 0.25 * (x1 - x0) * (y1 - y0); }
    // Part (i, j) of n x n.
    SourceSquare Part(int i, int j, int n) const;
};

class SourceDisc {
  public:
    // The arguments must outlive the disc.
    SourceDisc(const Lens& lens, const PlacedLight& light);

    // A part as a point light; its angular diameter is that of a disc of the part's width.
    PlacedLight LightOf(const SourceSquare& part) const;
    // A part's outline in the turns of `seen_from`, which stands near it.
    SourceCell CellOf(const SourceSquare& part, const PlacedLight& seen_from) const;

  private:
    std::vector<Vec2d> Outline(const SourceSquare& part) const;
    // Direction of travel in lens space.
    Vec3d Travel(Vec2d turn_rad) const;

    const Lens& lens_;
    const PlacedLight& light_;
    LightBundle bundle_;
};

}  // namespace flare
