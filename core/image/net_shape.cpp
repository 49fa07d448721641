// SPDX-License-Identifier: Apache-2.0
#include "core/image/net_shape.h"

#include <algorithm>
#include <cmath>

namespace flare {

NetRange RangeOf(const BezierNet& net) {
    NetRange range{net[0], net[0]};
    for (const double value : net) {
        range.lo = std::min(range.lo, value);
        range.hi = std::max(range.hi, value);
    }
    return range;
}

double NearestToOrigin(const NetRange& x, const NetRange& y) {
    const double dx = std::max({x.lo, -x.hi, 0.0});
    const double dy = std::max({y.lo, -y.hi, 0.0});
    return std::sqrt(dx * dx + dy * dy);
}

double FarthestFromOrigin(const NetRange& x, const NetRange& y) {
    const double dx = std::max(-x.lo, x.hi);
    const double dy = std::max(-y.lo, y.hi);
    return std::sqrt(dx * dx + dy * dy);
}

NetRange RangeOf(const CellJets& jets) {
    float lo = 1e30F;
    float hi = -1e30F;
    for (std::size_t corner = 0; corner < 4; ++corner) {
        const auto& [f, du, dv, duv] = jets[corner];
        const float u = corner % 2 == 0 ? du / 3.0F : -du / 3.0F;
        const float v = corner / 2 == 0 ? dv / 3.0F : -dv / 3.0F;
        const float uv = corner % 2 == corner / 2 ? duv / 9.0F : -duv / 9.0F;
        lo = std::min({lo, f, f + u, f + v, f + u + v + uv});
        hi = std::max({hi, f, f + u, f + v, f + u + v + uv});
    }
    return {static_cast<double>(lo), static_cast<double>(hi)};
}

void MapNets(CellJets& x, CellJets& y, const Vec2d& per_x, const Vec2d& per_y,
             const Vec2d& offset) {
    const auto xx = static_cast<float>(per_x.x), xy = static_cast<float>(per_x.y);
    const auto yx = static_cast<float>(per_y.x), yy = static_cast<float>(per_y.y);
    for (std::size_t corner = 0; corner < 4; ++corner) {
        for (std::size_t d = 0; d < 4; ++d) {
            const float at_x = x[corner][d];
            const float at_y = y[corner][d];
            x[corner][d] = xx * at_x + yx * at_y;
            y[corner][d] = xy * at_x + yy * at_y;
        }
        x[corner][0] += static_cast<float>(offset.x);
        y[corner][0] += static_cast<float>(offset.y);
    }
}

void MapNets(BezierNet& x, BezierNet& y, const Vec2d& per_x, const Vec2d& per_y,
             const Vec2d& offset) {
    for (std::size_t i = 0; i < 16; ++i) {
        const Vec2d p = offset + per_x * x[i] + per_y * y[i];
        x[i] = p.x;
        y[i] = p.y;
    }
}

NetShape ShapeOf(const BezierNet& x, const BezierNet& y) {
    NetShape shape;
    const auto distance = [](double a, double b) { return std::sqrt(a * a + b * b); };
    for (std::size_t line = 0; line < 4; ++line) {
        for (const bool along_u : {true, false}) {
            const std::size_t start = along_u ? 4 * line : line;
            const std::size_t step = along_u ? 1 : 4;
            double length = 0.0;
            double bend = 0.0;
            for (std::size_t i = 0; i < 3; ++i) {
                const std::size_t a = start + i * step;
                length += distance(x[a + step] - x[a], y[a + step] - y[a]);
                if (i == 2) break;
                bend = std::max(bend, distance(x[a] - 2.0 * x[a + step] + x[a + 2 * step],
                                               y[a] - 2.0 * y[a + step] + y[a + 2 * step]));
            }
            double& largest_length = along_u ? shape.length_u : shape.length_v;
            double& largest_bend = along_u ? shape.bend_u : shape.bend_v;
            largest_length = std::max(largest_length, length);
            largest_bend = std::max(largest_bend, bend);
        }
    }
    return shape;
}

NetShape ShapeOf(const BezierNet& x) {
    static const BezierNet kZero{};
    return ShapeOf(x, kZero);
}

double DensityChange(const BezierNet& x, const BezierNet& y) {
    const auto jacobian = [&](std::size_t at, std::size_t du, std::size_t dv) {
        return (x[du] - x[at]) * (y[dv] - y[at]) - (y[du] - y[at]) * (x[dv] - x[at]);
    };
    const std::array<double, 4> j = {jacobian(0, 1, 4), -jacobian(3, 2, 7), -jacobian(12, 13, 8),
                                     jacobian(15, 14, 11)};
    const auto [lo, hi] = std::minmax_element(j.begin(), j.end());
    const double size = 0.5 * (std::abs(*lo) + std::abs(*hi));
    return size > 0.0 ? (*hi - *lo) / size : 0.0;
}

std::array<double, 4> Bernstein(double t) {
    const double s = 1.0 - t;
    return {s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t};
}

}  // namespace flare
