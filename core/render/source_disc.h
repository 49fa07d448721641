// SPDX-License-Identifier: Apache-2.0
//
// A light of some size, in parts that fade into each other: on the square that the concentric map
// (Shirley and Chiu 1997, A low distortion map between disk and square) takes to a disc, or that a
// shape's image fills, every part is a product of hats, 1 at its own node and 0 at its neighbours'.
// Hats of one row add up to 1, so all parts together are the light, and a picture made of their
// pictures has no seams where they meet. Each part is a point light at the middle of its light,
// with its share of the irradiance, and a cell to blur that point's ghosts by.
#pragma once

#include <vector>

#include "core/image/source_kernel.h"
#include "core/render/lights.h"

namespace flare {

// A hat over one side of the square: 1 at its node, falling to 0 at `reach` from it, but level
// beyond the first and the last node of its row. Alone in its row it is 1 everywhere.
struct SourceHat {
    double node = 0.0, reach = 1.0;
    bool first = true, last = true;

    double At(double a) const;
};

// What a part takes of one side of the square, -1..1: a hat, or one within another.
struct SourceSide {
    double from = -1.0, to = 1.0;
    SourceHat outer, inner;

    // Between places where it is no polynomial, at least `count`; each with its share.
    struct Piece {
        double from = 0.0, to = 0.0, share = 0.0;
    };
    std::vector<Piece> Pieces(int count) const;
    // Of what it takes, over a < b.
    double MeanOver(double a, double b) const;
    bool whole() const { return inner.first && inner.last; }
    double share() const;
    // Hat i of n; of a part, once.
    SourceSide Part(int i, int n) const;

  private:
    double At(double a) const { return outer.At(a) * inner.At(a); }
};

struct SourceSquare {
    SourceSide x, y;

    bool whole() const { return x.whole() && y.whole(); }
    // Of the square.
    double share() const { return x.share() * y.share(); }
    // Part (i, j) of n x n.
    SourceSquare Part(int i, int j, int n) const { return {x.Part(i, n), y.Part(j, n)}; }
};

class SourceDisc {
  public:
    // The arguments must outlive the disc.
    SourceDisc(const Lens& lens, const PlacedLight& light);

    // Is it a disc, no shape?
    bool round() const { return !light_.shape; }
    // Of the light; a part of a shape may have none, and is then neither a light nor a cell.
    double ShareOf(const SourceSquare& part) const;
    // A part as a point light; its angular diameter is that of a disc as wide as the part's light.
    PlacedLight LightOf(const SourceSquare& part) const;
    // A part in the turns of `seen_from`, which stands near it.
    SourceCell CellOf(const SourceSquare& part, const PlacedLight& seen_from) const;

  private:
    // In turns of the light itself, about its own middle.
    SourceCell OwnCell(const SourceSquare& part, Vec2d& middle) const;
    std::vector<SourcePatch> PatchesOfDisc(const SourceSquare& part) const;
    std::vector<SourcePatch> PatchesOfShape(const SourceSquare& part) const;
    // Direction of travel in lens space.
    Vec3d Travel(Vec2d turn_rad) const;

    const Lens& lens_;
    const PlacedLight& light_;
    LightBundle bundle_;
    // Half of a shape's image, to the right and up, as turns.
    Vec2d right_{0.0, 0.0}, up_{0.0, 0.0};
};

}  // namespace flare
