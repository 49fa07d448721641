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

Fingerprint StopPicture::fingerprint() const {
    Fingerprinter name;
    name.Add(cells_->fingerprint).Add(half_width_).Add(across_.x).Add(across_.y);
    return name.value();
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
    return StopSampler(*this, footprint.right, footprint.down, footprint.smear)
        .At(footprint.middle);
}

StopSampler::StopSampler(const StopPicture& picture, Vec2d right, Vec2d down, Vec2d smear)
    : picture_(picture), cells_(*picture.cells_) {
    right_ = picture.Turned(right);
    down_ = picture.Turned(down);
    smear_ = picture.Turned(smear);
    const double across = right_.length();
    const double along = down_.length();
    const double deep = smear_.length();
    const double least = std::min(across, along);
    const double most = std::max({across, along, deep});
    dark_ = !(most < 1e9);
    if (dark_) return;
    reach_ = 0.5 * (across + along + deep);
    int level = 0;
    if (least > kPartsALevel) level = static_cast<int>(std::log2(least / kPartsALevel)) + 1;
    if (most > kMostParts)
        level = std::max(level, static_cast<int>(std::ceil(std::log2(most / kMostParts))));
    level_ = std::min(static_cast<std::size_t>(level), cells_.levels.size() - 1);
    size_ = std::exp2(-static_cast<double>(level_));
    across_ = PartsOf(across * size_);
    along_ = PartsOf(along * size_);
    deep_ = PartsOf(deep * size_);
    right_ *= size_ / across_;
    down_ *= size_ / along_;
    smear_ *= size_ / deep_;
}

double StopSampler::At(Vec2d middle) const {
    if (dark_) return 0.0;
    const Vec2d at = picture_.InCells(middle) * size_;
    if (cells_.sharp && level_ == 0) {
        // Distances grow by no more than the way gone.
        const double distance = cells_.DistanceAt(at);
        if (distance >= reach_ && cells_.dark_shade.side == 0) return 0.0;
        if (-distance >= reach_ && cells_.light_shade.side == 0) return 1.0;
        return SharpMean(at);
    }
    const StopPlane& plane = cells_.levels[level_];
    if (across_ * along_ * deep_ == 1) return static_cast<double>(Bilinear(plane, at, 0.0F));
    double sum = 0.0;
    for (int k = 0; k < deep_; ++k) {
        for (int j = 0; j < along_; ++j) {
            for (int i = 0; i < across_; ++i) {
                const Vec2d p = at + right_ * (i - 0.5 * (across_ - 1)) +
                                down_ * (j - 0.5 * (along_ - 1)) + smear_ * (k - 0.5 * (deep_ - 1));
                sum += static_cast<double>(Bilinear(plane, p, 0.0F));
            }
        }
    }
    return sum / (static_cast<double>(across_) * along_ * deep_);
}

double StopSampler::SharpMean(Vec2d middle) const {
    double sum = 0.0;
    for (int k = 0; k < deep_; ++k) {
        for (int j = 0; j < along_; ++j) {
            for (int i = 0; i < across_; ++i) {
                sum += cells_.SharpAt(middle + right_ * (i - 0.5 * (across_ - 1)) +
                                          down_ * (j - 0.5 * (along_ - 1)) +
                                          smear_ * (k - 0.5 * (deep_ - 1)),
                                      right_, down_, smear_);
            }
        }
    }
    return sum / (static_cast<double>(across_) * along_ * deep_);
}

}  // namespace flare
