// SPDX-License-Identifier: Apache-2.0
#include "core/image/piece_clip.h"

#include <cmath>

namespace flare {

void PieceClip::Start(const CornerPoints& px) {
    px_ = px;
    mask_count_ = 0;
}

bool PieceClip::AddMask(const CornerValues& values) {
    int outside = 0;
    for (const double value : values) outside += value > 0.0 ? 1 : 0;
    if (outside == 4) return false;
    if (outside > 0 && mask_count_ < kMostMasks) masks_[mask_count_++] = values;
    return true;
}

// Sutherland-Hodgman, one mask after another.
void PieceClip::Clip() {
    polygon_.resize(4);
    for (std::size_t k = 0; k < 4; ++k) {
        polygon_[k].ab = {k == 1 || k == 2 ? 1.0 : 0.0, k >= 2 ? 1.0 : 0.0};
        polygon_[k].px = px_[k];
        for (std::size_t m = 0; m < mask_count_; ++m) polygon_[k].f[m] = masks_[m][k];
    }
    for (std::size_t m = 0; m < mask_count_ && !polygon_.empty(); ++m) {
        next_.clear();
        for (std::size_t k = 0; k < polygon_.size(); ++k) {
            const Vertex& p = polygon_[k];
            const Vertex& q = polygon_[(k + 1) % polygon_.size()];
            if (p.f[m] <= 0.0) next_.push_back(p);
            if ((p.f[m] <= 0.0) == (q.f[m] <= 0.0)) continue;
            const double t = p.f[m] / (p.f[m] - q.f[m]);
            Vertex& cut = next_.emplace_back();
            cut.ab = p.ab + (q.ab - p.ab) * t;
            cut.px = p.px + (q.px - p.px) * t;
            for (std::size_t n = m + 1; n < mask_count_; ++n)
                cut.f[n] = p.f[n] + (q.f[n] - p.f[n]) * t;
        }
        std::swap(polygon_, next_);
    }
}

bool PieceClip::Convex(std::span<const Vec2d> polygon) {
    bool left = false;
    bool right = false;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vec2d& a = polygon[k];
        const Vec2d& b = polygon[(k + 1) % polygon.size()];
        const Vec2d& c = polygon[(k + 2) % polygon.size()];
        const double turn = (b - a).cross(c - b);
        left = left || turn > 0.0;
        right = right || turn < 0.0;
    }
    return !(left && right);
}

}  // namespace flare
