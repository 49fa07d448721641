// SPDX-License-Identifier: Apache-2.0
//
// Cuts a piece of a cell by masks. A piece is the image of a small rectangle of the pupil; a mask
// is a function over it, negative where light passes, known at the four corners and linear along
// the sides.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/base/vec.h"

namespace flare {

// Corners go round the piece: (0,0), (1,0), (1,1), (0,1) in its own (a, b).
using CornerPoints = std::array<Vec2d, 4>;
using CornerValues = std::array<double, 4>;

// A convex part of the piece's pupil rectangle and its image in the picture.
struct PiecePart {
    std::span<const Vec2d> px;  // a polygon, simple
    Vec2d middle{0.5, 0.5};     // of the part, in (a, b)
    double share = 1.0;         // of the rectangle's area
};

class PieceClip {
  public:
    // At most this many masks may cut one piece; more are ignored.
    static constexpr std::size_t kMostMasks = 32;

    void Start(const CornerPoints& px);
    // False if the mask shuts out the whole piece.
    bool AddMask(const CornerValues& values);

    // Calls use(part) for every part that passes. Parts whose image is folded or bent in are handed
    // out as triangles.
    template <class Use>
    void ForEachPart(Use use);

  private:
    struct Vertex {
        Vec2d ab, px;
        std::array<double, kMostMasks> f;
    };

    void Clip();
    static bool Convex(std::span<const Vec2d> polygon);

    template <class Use>
    void Triangles(Use use) const;

    CornerPoints px_;
    std::array<CornerValues, kMostMasks> masks_;
    std::size_t mask_count_ = 0;
    std::vector<Vertex> polygon_, next_;
    std::vector<Vec2d> points_;
};

template <class Use>
void PieceClip::Triangles(Use use) const {
    for (std::size_t k = 1; k + 1 < polygon_.size(); ++k) {
        const Vertex& a = polygon_[0];
        const Vertex& b = polygon_[k];
        const Vertex& c = polygon_[k + 1];
        const std::array<Vec2d, 3> px = {a.px, b.px, c.px};
        const double share = 0.5 * std::abs((b.ab - a.ab).cross(c.ab - a.ab));
        use(PiecePart{px, (a.ab + b.ab + c.ab) / 3.0, share});
    }
}

template <class Use>
void PieceClip::ForEachPart(Use use) {
    if (mask_count_ == 0 && Convex(px_)) {
        use(PiecePart{px_, {0.5, 0.5}, 1.0});
        return;
    }
    Clip();
    if (polygon_.size() < 3) return;
    points_.clear();
    for (const Vertex& v : polygon_) points_.push_back(v.px);
    if (!Convex(points_)) {
        Triangles(use);
        return;
    }
    double share = 0.0;
    Vec2d middle(0.0, 0.0);
    Triangles([&](const PiecePart& part) {
        share += part.share;
        middle += part.middle * part.share;
    });
    if (share > 0.0) use(PiecePart{points_, middle / share, share});
}

}  // namespace flare
