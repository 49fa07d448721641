// SPDX-License-Identifier: Apache-2.0
//
// A footprint of up to a few cells is cut into parts no larger than a cell: of a sharp picture each
// gets what a straight edge at its distance covers, of a smooth one the bilinear value. Larger ones
// take their parts from levels of means over 2, 4, 8 ... cells.
#include "core/optics/stop_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/check.h"
#include "core/optics/stop_cells.h"

namespace flare {
namespace {

constexpr int kMostParts = 12;        // along a side of a footprint
constexpr double kPartsALevel = 4.0;  // no coarser level than leaves this many

int PartsOf(double length) {
    return static_cast<int>(std::ceil(std::clamp(length, 1.0, static_cast<double>(kMostParts))));
}

// Parts of a footprint, in cells of a level: right, down and smear are each cut into some.
struct Parts {
    Vec2d middle, right, down, smear;  // of one part, but for the middle
    int across = 1, along = 1, deep = 1;

    template <class Value>
    double Mean(Value value) const {
        double sum = 0.0;
        for (int k = 0; k < deep; ++k) {
            for (int j = 0; j < along; ++j) {
                for (int i = 0; i < across; ++i) {
                    sum += value(middle + right * (i - 0.5 * (across - 1)) +
                                 down * (j - 0.5 * (along - 1)) + smear * (k - 0.5 * (deep - 1)));
                }
            }
        }
        return sum / (static_cast<double>(across) * along * deep);
    }
};

}  // namespace

std::shared_ptr<const StopPicture> StopPicture::Smooth(StopGrid grid) {
    return std::shared_ptr<const StopPicture>(
        new StopPicture(std::make_shared<const StopCells>(grid.side, std::move(grid.values), false),
                        grid.half_width_mm, 0.0));
}

std::shared_ptr<const StopPicture> StopPicture::Sharp(StopGrid grid) {
    return std::shared_ptr<const StopPicture>(
        new StopPicture(std::make_shared<const StopCells>(grid.side, std::move(grid.values), true),
                        grid.half_width_mm, 0.0));
}

StopPicture::StopPicture(std::shared_ptr<const StopCells> cells, double half_width_mm,
                         double turn_rad)
    : cells_(std::move(cells)), half_width_(half_width_mm) {
    FLARE_CHECK(half_width_mm > 0.0);
    const int side = cells_->levels.front().side;
    per_cell_ = side / (2.0 * half_width_mm);
    across_ = Vec2d(std::cos(turn_rad), std::sin(turn_rad)) * per_cell_;
    up_ = Vec2d(-across_.y, across_.x);
    middle_ = Vec2d(0.5 * side, 0.5 * side);
    area_mm2_ = cells_->area / (per_cell_ * per_cell_);
    outer_radius_ = cells_->outer_radius / per_cell_;
    clear_radius_ = cells_->clear_radius / per_cell_;
}

std::shared_ptr<const StopPicture> StopPicture::Placed(double half_width_mm,
                                                       double turn_rad) const {
    return std::shared_ptr<const StopPicture>(new StopPicture(cells_, half_width_mm, turn_rad));
}

std::vector<std::vector<Vec2d>> StopPicture::Outlines() const {
    std::vector<std::vector<Vec2d>> loops = cells_->outlines;
    for (std::vector<Vec2d>& loop : loops) {
        for (Vec2d& p : loop) {
            const Vec2d q = p - middle_;
            p = (across_ * q.x + up_ * q.y) / (per_cell_ * per_cell_);
        }
    }
    return loops;
}

StopRange StopPicture::Over(double x0, double y0, double x1, double y1) const {
    const Vec2d middle = InCells({0.5 * (x0 + x1), 0.5 * (y0 + y1)});
    const Vec2d half(0.5 * (x1 - x0), 0.5 * (y1 - y0));
    // Around the turned box.
    const Vec2d reach(std::abs(across_.x) * half.x + std::abs(across_.y) * half.y,
                      std::abs(up_.x) * half.x + std::abs(up_.y) * half.y);
    return cells_->Over(middle - reach, middle + reach);
}

double StopPicture::At(Vec2d mm) const {
    const Vec2d p = InCells(mm);
    if (!cells_->sharp) return static_cast<double>(Bilinear(cells_->levels.front(), p, 0.0F));
    const bool lit = cells_->DistanceAt(p) < 0.0;
    return cells_->ShadeAt(lit ? cells_->light_shade : cells_->dark_shade, p, lit ? 1.0 : 0.0);
}

double StopPicture::Mean(const StopFootprint& footprint) const {
    const double right = footprint.right.length() * per_cell_;
    const double down = footprint.down.length() * per_cell_;
    const double smear = footprint.smear.length() * per_cell_;
    const double least = std::min(right, down);
    const double most = std::max({right, down, smear});
    if (!(most < 1e9)) return 0.0;
    int level = 0;
    if (least > kPartsALevel) level = static_cast<int>(std::log2(least / kPartsALevel)) + 1;
    if (most > kMostParts)
        level = std::max(level, static_cast<int>(std::ceil(std::log2(most / kMostParts))));
    level = std::min(level, static_cast<int>(cells_->levels.size()) - 1);
    const double size = std::exp2(-level);
    Parts parts;
    parts.across = PartsOf(right * size);
    parts.along = PartsOf(down * size);
    parts.deep = PartsOf(smear * size);
    parts.middle = InCells(footprint.middle) * size;
    parts.right = Turned(footprint.right) * (size / parts.across);
    parts.down = Turned(footprint.down) * (size / parts.along);
    parts.smear = Turned(footprint.smear) * (size / parts.deep);
    if (cells_->sharp && level == 0)
        return parts.Mean([&](const Vec2d& p) {
            return cells_->SharpAt(p, parts.right, parts.down, parts.smear);
        });
    const StopPlane& plane = cells_->levels[static_cast<std::size_t>(level)];
    return parts.Mean(
        [&](const Vec2d& p) { return static_cast<double>(Bilinear(plane, p, 0.0F)); });
}

}  // namespace flare
