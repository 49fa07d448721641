// SPDX-License-Identifier: Apache-2.0
#include "core/optics/stop_dirt.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"

namespace flare {
namespace {

constexpr double kWidth = 1.02;  // of the picture, rims: nothing of the beam meets its own edge
constexpr int kLeastSide = 256, kMostSide = 2048;
constexpr double kCellsAcross = 10.0;  // a mark, where that many cells are allowed
constexpr int kLines = 16;             // that a cell's area is told from; exact along each
constexpr int kTries = 30;

// Numbers in 0..1 (SplitMix64).
class Numbers {
  public:
    explicit Numbers(std::uint64_t seed) : state_(seed) {}
    double Next() {
        state_ += 0x9E3779B97F4A7C15ULL;
        std::uint64_t z = state_;
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
        z ^= z >> 31;
        return static_cast<double>(z >> 11) * 0x1.0p-53;
    }
    Vec2d InDisc(double radius) {
        const double r = radius * std::sqrt(Next());
        const double angle = 2.0 * kPi * Next();
        return Vec2d(std::cos(angle), std::sin(angle)) * r;
    }

  private:
    std::uint64_t state_;
};

struct Span {
    double from = 1e300, to = -1e300;
    void Add(double x) {
        from = std::min(from, x);
        to = std::max(to, x);
    }
};

// Where the line at this height meets a mark, which is convex: its two round ends, and the strip
// between them.
Span SpanAt(const StopMark& mark, double y) {
    Span span;
    for (const Vec2d& end : {mark.a, mark.b}) {
        const double rest = mark.radius_mm * mark.radius_mm - (y - end.y) * (y - end.y);
        if (rest < 0.0) continue;
        span.Add(end.x - std::sqrt(rest));
        span.Add(end.x + std::sqrt(rest));
    }
    const Vec2d along = mark.b - mark.a;
    const double length = along.length();
    if (length == 0.0) return span;
    const Vec2d off = Vec2d(-along.y, along.x) * (mark.radius_mm / length);
    for (const double side : {1.0, -1.0}) {
        const double t = along.y != 0.0 ? (y - mark.a.y - side * off.y) / along.y : -1.0;
        if (t >= 0.0 && t <= 1.0) span.Add(mark.a.x + side * off.x + t * along.x);
    }
    return span;
}

// Multiplies the cells under a mark by what it lets through of them.
void Cover(const StopMark& mark, StopGrid& grid, double half_mm) {
    const double cell = 2.0 * half_mm / grid.side;
    const auto clamp = [&](double mm) {
        return static_cast<int>(
            std::clamp(std::floor((mm + half_mm) / cell), 0.0, grid.side - 1.0));
    };
    const double r = mark.radius_mm;
    const int i0 = clamp(std::min(mark.a.x, mark.b.x) - r);
    const int i1 = clamp(std::max(mark.a.x, mark.b.x) + r);
    const int j0 = clamp(std::min(mark.a.y, mark.b.y) - r);
    const int j1 = clamp(std::max(mark.a.y, mark.b.y) + r);
    std::vector<double> covered(static_cast<std::size_t>(i1 - i0 + 1));
    for (int j = j0; j <= j1; ++j) {
        std::fill(covered.begin(), covered.end(), 0.0);
        for (int line = 0; line < kLines; ++line) {
            const Span span = SpanAt(mark, (j + (line + 0.5) / kLines) * cell - half_mm);
            if (span.from >= span.to) continue;
            const double from = (span.from + half_mm) / cell, to = (span.to + half_mm) / cell;
            for (int i = clamp(span.from); i <= clamp(span.to); ++i) {
                const double part = std::min(to, i + 1.0) - std::max(from, 1.0 * i);
                covered[static_cast<std::size_t>(i - i0)] += std::max(0.0, part) / kLines;
            }
        }
        for (int i = i0; i <= i1; ++i) {
            const double passes = 1.0 - mark.opacity * covered[static_cast<std::size_t>(i - i0)];
            grid.values[static_cast<std::size_t>(j) * static_cast<std::size_t>(grid.side) +
                        static_cast<std::size_t>(i)] *= static_cast<float>(std::max(0.0, passes));
        }
    }
}

}  // namespace

std::vector<StopMark> MarksOf(const StopDust& dust, const StopScratches& scratches, double rim_mm) {
    std::vector<StopMark> marks;
    Numbers of_dust(dust.seed);
    for (int k = 0; k < dust.count; ++k) {
        const double radius = 0.5 * dust.size_mm * std::exp2(2.0 * of_dust.Next() - 1.0);
        for (int attempt = 0; attempt < kTries; ++attempt) {
            const Vec2d at = of_dust.InDisc(rim_mm);
            const bool clear = std::all_of(marks.begin(), marks.end(), [&](const StopMark& other) {
                return (at - other.a).length() > radius + other.radius_mm;
            });
            if (!clear && attempt + 1 < kTries) continue;
            marks.push_back({at, at, radius, dust.opacity});
            break;
        }
    }
    Numbers of_scratches(scratches.seed ^ 0x5C3A7C4E5ULL);
    for (int k = 0; k < scratches.count; ++k) {
        const Vec2d at = of_scratches.InDisc(rim_mm);
        const double angle = kPi * of_scratches.Next();
        const Vec2d half = Vec2d(std::cos(angle), std::sin(angle)) * (0.5 * scratches.length_mm);
        marks.push_back({at - half, at + half, 0.5 * scratches.width_mm, scratches.opacity});
    }
    return marks;
}

std::shared_ptr<const StopPicture> DirtyStop(const std::vector<StopMark>& marks, double rim_mm) {
    if (marks.empty()) return nullptr;
    double finest = 2.0 * rim_mm;
    for (const StopMark& mark : marks) finest = std::min(finest, 2.0 * mark.radius_mm);
    const double half_mm = kWidth * rim_mm;
    StopGrid grid;
    grid.side = static_cast<int>(
        std::clamp(2.0 * half_mm * kCellsAcross / finest, 1.0 * kLeastSide, 1.0 * kMostSide));
    grid.half_width_mm = kWidth;
    grid.values.assign(static_cast<std::size_t>(grid.side) * static_cast<std::size_t>(grid.side),
                       1.0F);
    for (const StopMark& mark : marks) Cover(mark, grid, half_mm);
    return StopPicture::Sharp(std::move(grid));
}

}  // namespace flare
