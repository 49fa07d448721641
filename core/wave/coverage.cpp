// SPDX-License-Identifier: Apache-2.0
//
// Each side is cut at the lines of the grid. A fragment adds to its cell the area between itself
// and the cell's right edge, and to all cells further right of its row its whole height; the second
// is written down once and summed along the row at the end.
#include "core/wave/coverage.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace flare {
namespace {

class Accumulator {
  public:
    explicit Accumulator(int side)
        : side_(side),
          changes_(static_cast<std::size_t>(side + 1) * static_cast<std::size_t>(side)) {}

    void Side(Vec2d a, Vec2d b) {
        if (a.y == b.y) return;
        const double sign = a.y < b.y ? 1.0 : -1.0;
        if (a.y > b.y) std::swap(a, b);
        const double slope = (b.x - a.x) / (b.y - a.y);
        Vec2d from = a;
        for (int row = Cell(a.y); row < side_ && from.y < b.y; ++row) {
            const double top = std::min(b.y, row + 1.0);
            const Vec2d to(top == b.y ? b.x : a.x + (top - a.y) * slope, top);
            InRow(row, from, to, sign);
            from = to;
        }
    }

    std::vector<double> Shares() const {
        const auto n = static_cast<std::size_t>(side_);
        std::vector<double> shares(n * n);
        for (std::size_t j = 0; j < n; ++j) {
            double sum = 0.0;
            for (std::size_t i = 0; i < n; ++i) {
                sum += changes_[j * (n + 1) + i];
                shares[j * n + i] = std::clamp(std::abs(sum), 0.0, 1.0);
            }
        }
        return shares;
    }

  private:
    int Cell(double at) const { return std::clamp(static_cast<int>(std::floor(at)), 0, side_ - 1); }

    void InRow(int row, Vec2d from, Vec2d to, double sign) {
        if (from.x > to.x) std::swap(from, to);
        const double height = std::abs(to.y - from.y) * sign;
        double* const line =
            changes_.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(side_ + 1);
        const int last = Cell(to.x);
        double x = from.x;
        for (int i = Cell(from.x); i <= last; ++i) {
            const double next = i == last ? to.x : i + 1.0;
            const double share = to.x > from.x ? height * (next - x) / (to.x - from.x) : height;
            const double left_out = 0.5 * (x + next) - i;  // of the cell, to the fragment's left
            line[i] += share * (1.0 - left_out);
            line[i + 1] += share * left_out;
            x = next;
        }
    }

    int side_;
    std::vector<double> changes_;  // rows of side + 1
};

}  // namespace

double SignedArea(const Loop& loop) {
    double twice = 0.0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const Vec2d& a = loop[i];
        const Vec2d& b = loop[(i + 1) % loop.size()];
        twice += a.x * b.y - a.y * b.x;
    }
    return 0.5 * twice;
}

std::vector<double> Coverage(const std::vector<Loop>& loops, int side, double pitch) {
    FLARE_CHECK(side >= 2 && pitch > 0.0);
    Accumulator accumulator(side);
    const double offset = side / 2 + 0.5;
    for (const Loop& loop : loops) {
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Vec2d a = loop[i] / pitch + Vec2d(offset, offset);
            const Vec2d b = loop[(i + 1) % loop.size()] / pitch + Vec2d(offset, offset);
            FLARE_CHECK(std::min(a.x, a.y) >= 0.0 && std::max(a.x, a.y) <= side);
            accumulator.Side(a, b);
        }
    }
    return accumulator.Shares();
}

std::vector<double> Sharpened(const std::vector<double>& shares, int side) {
    const auto n = static_cast<std::size_t>(side);
    std::vector<double> out(shares);
    // The grid is periodic, as its transform is.
    for (const std::size_t step : {std::size_t{1}, n}) {
        const std::vector<double> from(out);
        for (std::size_t k = 0; k < from.size(); ++k) {
            const std::size_t base = step == 1 ? k - k % n : k % n;
            const std::size_t at = step == 1 ? k % n : k / n;
            const double before = from[base + (at + n - 1) % n * step];
            const double after = from[base + (at + 1) % n * step];
            out[k] = from[k] - (before - 2.0 * from[k] + after) / 24.0;
        }
    }
    return out;
}

}  // namespace flare
