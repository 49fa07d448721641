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
#include "core/optics/stop_outline.h"

namespace flare {
namespace {

constexpr int kBand = 4;              // cells around edges in which distances are known
constexpr float kOwnShade = 0.75F;    // farther from an edge than this a cell is of one shade
constexpr int kMostParts = 12;        // along a side of a footprint
constexpr double kPartsALevel = 4.0;  // no coarser level than leaves this many

std::size_t At2(int i, int j, int side) {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(side) +
           static_cast<std::size_t>(i);
}

double DistanceToSegment(Vec2d p, Vec2d a, Vec2d b) {
    const Vec2d along = b - a;
    const double length2 = along.length2();
    const double t = length2 > 0.0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
    return (p - a - along * t).length();
}

int PartsOf(double length) {
    return static_cast<int>(std::ceil(std::clamp(length, 1.0, static_cast<double>(kMostParts))));
}

}  // namespace

std::shared_ptr<const StopPicture> StopPicture::Smooth(StopGrid grid) {
    return std::shared_ptr<const StopPicture>(new StopPicture(std::move(grid), false));
}

std::shared_ptr<const StopPicture> StopPicture::Sharp(StopGrid grid) {
    return std::shared_ptr<const StopPicture>(new StopPicture(std::move(grid), true));
}

StopPicture::StopPicture(StopGrid grid, bool sharp)
    : half_width_(grid.half_width_mm),
      cell_(grid.cell_mm()),
      per_cell_(1.0 / grid.cell_mm()),
      sharp_(sharp) {
    const auto count = static_cast<std::size_t>(grid.side) * static_cast<std::size_t>(grid.side);
    FLARE_CHECK(grid.side > 0 && grid.half_width_mm > 0.0 && grid.values.size() == count);
    double sum = 0.0;
    for (const float value : grid.values) {
        FLARE_CHECK(value >= 0.0F && std::isfinite(value));
        sum += static_cast<double>(value);
    }
    area_mm2_ = sum * cell_ * cell_;
    levels_.push_back({grid.side, std::move(grid.values)});
    MakeLevels();
    if (sharp_) {
        FindEdges();
        FindShades(levels_.front().values);
    }
    MakeRanges();
    MeasureRadii();
}

void StopPicture::MakeLevels() {
    while (levels_.back().side > 1) {
        const Plane& fine = levels_.back();
        Plane coarse{(fine.side + 1) / 2, {}};
        coarse.values.resize(static_cast<std::size_t>(coarse.side) *
                             static_cast<std::size_t>(coarse.side));
        const auto at = [&](int i, int j) {
            return i < fine.side && j < fine.side ? fine.values[At2(i, j, fine.side)] : 0.0F;
        };
        for (int j = 0; j < coarse.side; ++j) {
            for (int i = 0; i < coarse.side; ++i) {
                coarse.values[At2(i, j, coarse.side)] =
                    0.25F * (at(2 * i, 2 * j) + at(2 * i + 1, 2 * j) + at(2 * i, 2 * j + 1) +
                             at(2 * i + 1, 2 * j + 1));
            }
        }
        levels_.push_back(std::move(coarse));
    }
}

void StopPicture::FindEdges() {
    const Plane& cells = levels_.front();
    const int side = cells.side;
    outlines_ = OutlinesOf(cells.values, side);
    distance_ = {side, std::vector<float>(cells.values.size(), static_cast<float>(kBand))};
    for (const std::vector<Vec2d>& loop : outlines_) {
        for (std::size_t n = 0; n < loop.size(); ++n) {
            const Vec2d& a = loop[n];
            const Vec2d& b = loop[(n + 1) % loop.size()];
            const int i0 = std::max(0, static_cast<int>(std::min(a.x, b.x)) - kBand);
            const int i1 = std::min(side - 1, static_cast<int>(std::max(a.x, b.x)) + kBand);
            const int j0 = std::max(0, static_cast<int>(std::min(a.y, b.y)) - kBand);
            const int j1 = std::min(side - 1, static_cast<int>(std::max(a.y, b.y)) + kBand);
            for (int j = j0; j <= j1; ++j) {
                for (int i = i0; i <= i1; ++i) {
                    float& nearest = distance_.values[At2(i, j, side)];
                    nearest = std::min(
                        nearest, static_cast<float>(DistanceToSegment({i + 0.5, j + 0.5}, a, b)));
                }
            }
        }
    }
    for (std::size_t n = 0; n < cells.values.size(); ++n) {
        if (cells.values[n] > 0.5F) distance_.values[n] *= -1.0F;
    }
    for (std::vector<Vec2d>& loop : outlines_) {
        for (Vec2d& p : loop) p = p * cell_ - Vec2d(half_width_, half_width_);
    }
}

// Cells well off the edges tell the shades; those on an edge take them from around.
void StopPicture::FindShades(const std::vector<float>& values) {
    const int side = distance_.side;
    const auto shade = [&](float sign, float otherwise) {
        std::vector<float> out(values.size(), -1.0F);
        bool plain = true;
        for (std::size_t n = 0; n < values.size(); ++n) {
            if (sign * distance_.values[n] < kOwnShade) continue;
            out[n] = values[n];
            plain = plain && values[n] == otherwise;
        }
        if (plain) return Plane{};
        for (int round = 0; round < 3; ++round) {
            const std::vector<float> from = out;
            for (int j = 0; j < side; ++j) {
                for (int i = 0; i < side; ++i) {
                    if (from[At2(i, j, side)] >= 0.0F) continue;
                    float sum = 0.0F;
                    int known = 0;
                    for (int y = std::max(0, j - 1); y <= std::min(side - 1, j + 1); ++y) {
                        for (int x = std::max(0, i - 1); x <= std::min(side - 1, i + 1); ++x) {
                            const float value = from[At2(x, y, side)];
                            sum += std::max(value, 0.0F);
                            known += value >= 0.0F ? 1 : 0;
                        }
                    }
                    if (known > 0) out[At2(i, j, side)] = sum / static_cast<float>(known);
                }
            }
        }
        for (float& value : out) value = value < 0.0F ? otherwise : value;
        return Plane{side, std::move(out)};
    };
    light_shade_ = shade(-1.0F, 1.0F);
    dark_shade_ = shade(1.0F, 0.0F);
}

// What a point of a cell may get comes from the cells around it.
void StopPicture::MakeRanges() {
    const Plane& cells = levels_.front();
    const int side = cells.side;
    Plane lo{side, std::vector<float>(cells.values.size())};
    Plane hi = lo;
    for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
            const bool rim = i == 0 || j == 0 || i == side - 1 || j == side - 1;
            float least = rim ? 0.0F : 1e30F;
            float most = 0.0F;
            for (int y = std::max(0, j - 1); y <= std::min(side - 1, j + 1); ++y) {
                for (int x = std::max(0, i - 1); x <= std::min(side - 1, i + 1); ++x) {
                    const float value = cells.values[At2(x, y, side)];
                    least = std::min(least, value);
                    most = std::max(most, value);
                }
            }
            lo.values[At2(i, j, side)] = least;
            hi.values[At2(i, j, side)] = most;
        }
    }
    lo_.push_back(std::move(lo));
    hi_.push_back(std::move(hi));
    while (lo_.back().side > 1) {
        const auto halve = [](const Plane& fine, auto pick) {
            Plane coarse{(fine.side + 1) / 2, {}};
            for (int j = 0; j < coarse.side; ++j) {
                for (int i = 0; i < coarse.side; ++i) {
                    const int right = std::min(2 * i + 1, fine.side - 1);
                    const int above = std::min(2 * j + 1, fine.side - 1);
                    coarse.values.push_back(pick(pick(fine.values[At2(2 * i, 2 * j, fine.side)],
                                                      fine.values[At2(right, 2 * j, fine.side)]),
                                                 pick(fine.values[At2(2 * i, above, fine.side)],
                                                      fine.values[At2(right, above, fine.side)])));
                }
            }
            return coarse;
        };
        Plane lower = halve(lo_.back(), [](float a, float b) { return std::min(a, b); });
        Plane upper = halve(hi_.back(), [](float a, float b) { return std::max(a, b); });
        lo_.push_back(std::move(lower));
        hi_.push_back(std::move(upper));
    }
}

void StopPicture::MeasureRadii() {
    const int side = levels_.front().side;
    const double corner = half_width_ * std::sqrt(2.0);
    double outer = 0.0;
    double clear = half_width_;
    for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
            const std::size_t n = At2(i, j, side);
            const Vec2d middle((i + 0.5) * cell_ - half_width_, (j + 0.5) * cell_ - half_width_);
            if (hi_[0].values[n] > 0.0F) {
                const Vec2d far(std::abs(middle.x) + 0.5 * cell_, std::abs(middle.y) + 0.5 * cell_);
                outer = std::max(outer, far.length());
            }
            if (lo_[0].values[n] != 1.0F || hi_[0].values[n] != 1.0F) {
                const Vec2d near(std::max(0.0, std::abs(middle.x) - 0.5 * cell_),
                                 std::max(0.0, std::abs(middle.y) - 0.5 * cell_));
                clear = std::min(clear, near.length());
            }
        }
    }
    outer_radius_ = std::min(outer, corner);
    clear_radius_ = clear;
}

float StopPicture::Bilinear(const Plane& plane, double x, double y, float outside) {
    const double fx = std::floor(x - 0.5);
    const double fy = std::floor(y - 0.5);
    const double last = plane.side;
    if (!(fx >= -1.0 && fy >= -1.0 && fx < last && fy < last)) return outside;
    const int i = static_cast<int>(fx);
    const int j = static_cast<int>(fy);
    const auto u = static_cast<float>(x - 0.5 - fx);
    const auto v = static_cast<float>(y - 0.5 - fy);
    const auto at = [&](int a, int b) {
        if (a < 0 || b < 0 || a >= plane.side || b >= plane.side) return outside;
        return plane.values[At2(a, b, plane.side)];
    };
    const float below = at(i, j) + u * (at(i + 1, j) - at(i, j));
    const float above = at(i, j + 1) + u * (at(i + 1, j + 1) - at(i, j + 1));
    return below + v * (above - below);
}

double StopPicture::At(Vec2d p) const {
    const Vec2d c = Cells(p);
    if (!sharp_) return static_cast<double>(Bilinear(levels_.front(), c.x, c.y, 0.0F));
    const bool lit = Bilinear(distance_, c.x, c.y, static_cast<float>(kBand)) < 0.0F;
    const Plane& shade = lit ? light_shade_ : dark_shade_;
    if (shade.side == 0) return lit ? 1.0 : 0.0;
    return static_cast<double>(Bilinear(shade, c.x, c.y, 0.0F));
}

StopPicture::Range StopPicture::Over(double x0, double y0, double x1, double y1) const {
    const int side = levels_.front().side;
    const auto cell = [&](double mm) {
        const double at = std::floor((mm + half_width_) * per_cell_);
        return static_cast<int>(std::clamp(at, -1.0, static_cast<double>(side)));
    };
    int i0 = cell(x0), i1 = cell(x1), j0 = cell(y0), j1 = cell(y1);
    const bool beyond = i0 < 0 || j0 < 0 || i1 >= side || j1 >= side;
    Range range{beyond ? 0.0F : 1e30F, 0.0F};
    if (i1 < 0 || j1 < 0 || i0 >= side || j0 >= side) return {0.0F, 0.0F};
    i0 = std::max(i0, 0);
    j0 = std::max(j0, 0);
    i1 = std::min(i1, side - 1);
    j1 = std::min(j1, side - 1);
    std::size_t level = 0;
    while (level + 1 < lo_.size() && std::max(i1 - i0, j1 - j0) >= 4) {
        i0 /= 2;
        j0 /= 2;
        i1 /= 2;
        j1 /= 2;
        ++level;
    }
    for (int j = j0; j <= j1; ++j) {
        for (int i = i0; i <= i1; ++i) {
            range.lo = std::min(range.lo, lo_[level].values[At2(i, j, lo_[level].side)]);
            range.hi = std::max(range.hi, hi_[level].values[At2(i, j, hi_[level].side)]);
        }
    }
    return range;
}

double StopPicture::Mean(const StopFootprint& footprint) const {
    const double right = footprint.right.length() * per_cell_;
    const double down = footprint.down.length() * per_cell_;
    const double smear = footprint.smear.length() * per_cell_;
    const double least = std::min(right, down);
    const double most = std::max({right, down, smear});
    int level = 0;
    if (least > kPartsALevel) level = static_cast<int>(std::log2(least / kPartsALevel)) + 1;
    if (most > kMostParts)
        level = std::max(level, static_cast<int>(std::ceil(std::log2(most / kMostParts))));
    level = std::min(level, static_cast<int>(levels_.size()) - 1);
    const double size = std::exp2(-level);
    const int n = PartsOf(right * size);
    const int m = PartsOf(down * size);
    const int s = PartsOf(smear * size);
    if (sharp_ && level == 0) return SharpMean(footprint, n, m, s);
    return LevelMean(footprint, level, n, m, s);
}

double StopPicture::LevelMean(const StopFootprint& f, int level, int n, int m, int s) const {
    const Plane& plane = levels_[static_cast<std::size_t>(level)];
    const double size = std::exp2(-level);
    const Vec2d middle = Cells(f.middle) * size;
    const Vec2d r = f.right * (per_cell_ * size / n);
    const Vec2d d = f.down * (per_cell_ * size / m);
    const Vec2d e = f.smear * (per_cell_ * size / s);
    double sum = 0.0;
    for (int k = 0; k < s; ++k) {
        for (int j = 0; j < m; ++j) {
            for (int i = 0; i < n; ++i) {
                const Vec2d p = middle + r * (i - 0.5 * (n - 1)) + d * (j - 0.5 * (m - 1)) +
                                e * (k - 0.5 * (s - 1));
                sum += static_cast<double>(Bilinear(plane, p.x, p.y, 0.0F));
            }
        }
    }
    return sum / (static_cast<double>(n) * m * s);
}

double StopPicture::SharpMean(const StopFootprint& f, int n, int m, int s) const {
    const Vec2d middle = Cells(f.middle);
    const Vec2d r = f.right * (per_cell_ / n);
    const Vec2d d = f.down * (per_cell_ / m);
    const Vec2d e = f.smear * (per_cell_ / s);
    constexpr auto kFar = static_cast<float>(kBand);
    const auto distance = [&](const Vec2d& p) {
        return static_cast<double>(Bilinear(distance_, p.x, p.y, kFar));
    };
    const auto shade = [](const Plane& plane, const Vec2d& p, double otherwise) {
        return plane.side == 0 ? otherwise : static_cast<double>(Bilinear(plane, p.x, p.y, 0.0F));
    };
    const double reach = 0.5 * (r.length() + d.length() + e.length());
    double sum = 0.0;
    for (int k = 0; k < s; ++k) {
        for (int j = 0; j < m; ++j) {
            for (int i = 0; i < n; ++i) {
                const Vec2d p = middle + r * (i - 0.5 * (n - 1)) + d * (j - 0.5 * (m - 1)) +
                                e * (k - 0.5 * (s - 1));
                const double at = distance(p);
                double cover = at < 0.0 ? 1.0 : 0.0;
                if (std::abs(at) < reach) {
                    // The edge's normal, over about a cell.
                    const Vec2d slope(
                        distance(p + Vec2d(0.5, 0.0)) - distance(p - Vec2d(0.5, 0.0)),
                        distance(p + Vec2d(0.0, 0.5)) - distance(p - Vec2d(0.0, 0.5)));
                    const double steep = slope.length();
                    const Vec2d normal = steep > 0.3 ? slope / steep : Vec2d(0.7, 0.7);
                    const double width = std::hypot(
                        std::abs(normal.dot(r)) + std::abs(normal.dot(d)), normal.dot(e));
                    cover = std::clamp(0.5 - at / std::max(width, 1e-12), 0.0, 1.0);
                }
                if (cover > 0.0) sum += cover * shade(light_shade_, p, 1.0);
                if (cover < 1.0 && dark_shade_.side > 0)
                    sum += (1.0 - cover) * shade(dark_shade_, p, 0.0);
            }
        }
    }
    return sum / (static_cast<double>(n) * m * s);
}

}  // namespace flare
