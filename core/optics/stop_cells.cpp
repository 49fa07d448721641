// SPDX-License-Identifier: Apache-2.0
#include "core/optics/stop_cells.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/optics/stop_outline.h"

namespace flare {
namespace {

constexpr int kBand = static_cast<int>(kStopBand);
constexpr float kOwnShade = 0.75F;  // farther from an edge than this a cell is of one shade

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

}  // namespace

float Bilinear(const StopPlane& plane, const Vec2d& p, float outside) {
    const double x = p.x - 0.5;
    const double y = p.y - 0.5;
    const int side = plane.side;
    if (!(x >= -1.0 && y >= -1.0 && x < side && y < side)) return outside;
    // Downwards: both are at least -1.
    const int i = static_cast<int>(x + 1.0) - 1;
    const int j = static_cast<int>(y + 1.0) - 1;
    const auto u = static_cast<float>(x - i);
    const auto v = static_cast<float>(y - j);
    if (i >= 0 && j >= 0 && i + 1 < side && j + 1 < side) {
        const float* const at = &plane.values[At2(i, j, side)];
        const float* const next = at + side;
        const float below = at[0] + u * (at[1] - at[0]);
        const float above = next[0] + u * (next[1] - next[0]);
        return below + v * (above - below);
    }
    const auto at = [&](int a, int b) {
        if (a < 0 || b < 0 || a >= side || b >= side) return outside;
        return plane.values[At2(a, b, side)];
    };
    const float below = at(i, j) + u * (at(i + 1, j) - at(i, j));
    const float above = at(i, j + 1) + u * (at(i + 1, j + 1) - at(i, j + 1));
    return below + v * (above - below);
}

StopCells::StopCells(int side, std::vector<float> values, bool sharp_edges) : sharp(sharp_edges) {
    FLARE_CHECK(side > 0 &&
                values.size() == static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    Fingerprinter name;
    name.Add(side).Add(sharp_edges);
    for (const float value : values) {
        FLARE_CHECK(value >= 0.0F && std::isfinite(value));
        area += static_cast<double>(value);
        name.Add(static_cast<double>(value));
    }
    fingerprint = name.value();
    levels.push_back({side, std::move(values)});
    MakeLevels();
    if (sharp) {
        FindEdges();
        FindShades(levels.front().values);
    }
    MakeRanges();
    MeasureRadii();
}

void StopCells::MakeLevels() {
    while (levels.back().side > 1) {
        const StopPlane& fine = levels.back();
        StopPlane coarse{(fine.side + 1) / 2, {}};
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
        levels.push_back(std::move(coarse));
    }
}

void StopCells::FindEdges() {
    const StopPlane& cells = levels.front();
    const int side = cells.side;
    outlines = OutlinesOf(cells.values, side);
    distance = {side, std::vector<float>(cells.values.size(), kStopBand)};
    for (const std::vector<Vec2d>& loop : outlines) {
        for (std::size_t n = 0; n < loop.size(); ++n) {
            const Vec2d& a = loop[n];
            const Vec2d& b = loop[(n + 1) % loop.size()];
            const int i0 = std::max(0, static_cast<int>(std::min(a.x, b.x)) - kBand);
            const int i1 = std::min(side - 1, static_cast<int>(std::max(a.x, b.x)) + kBand);
            const int j0 = std::max(0, static_cast<int>(std::min(a.y, b.y)) - kBand);
            const int j1 = std::min(side - 1, static_cast<int>(std::max(a.y, b.y)) + kBand);
            for (int j = j0; j <= j1; ++j) {
                for (int i = i0; i <= i1; ++i) {
                    float& nearest = distance.values[At2(i, j, side)];
                    nearest = std::min(
                        nearest, static_cast<float>(DistanceToSegment({i + 0.5, j + 0.5}, a, b)));
                }
            }
        }
    }
    for (std::size_t n = 0; n < cells.values.size(); ++n) {
        if (cells.values[n] > 0.5F) distance.values[n] *= -1.0F;
    }
}

// Cells well off the edges tell the shades; those on an edge take them from around.
void StopCells::FindShades(const std::vector<float>& values) {
    const int side = distance.side;
    const auto shade = [&](float sign, float otherwise) {
        std::vector<float> out(values.size(), -1.0F);
        bool plain = true;
        for (std::size_t n = 0; n < values.size(); ++n) {
            if (sign * distance.values[n] < kOwnShade) continue;
            out[n] = values[n];
            plain = plain && values[n] == otherwise;
        }
        if (plain) return StopPlane{};
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
        return StopPlane{side, std::move(out)};
    };
    light_shade = shade(-1.0F, 1.0F);
    dark_shade = shade(1.0F, 0.0F);
}

// What a point of a cell may get comes from the cells around it.
void StopCells::MakeRanges() {
    const StopPlane& cells = levels.front();
    const int side = cells.side;
    StopPlane least_of{side, std::vector<float>(cells.values.size())};
    StopPlane most_of = least_of;
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
            least_of.values[At2(i, j, side)] = least;
            most_of.values[At2(i, j, side)] = most;
        }
    }
    lo.push_back(std::move(least_of));
    hi.push_back(std::move(most_of));
    while (lo.back().side > 1) {
        const auto halve = [](const StopPlane& fine, auto pick) {
            StopPlane coarse{(fine.side + 1) / 2, {}};
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
        StopPlane lower = halve(lo.back(), [](float a, float b) { return std::min(a, b); });
        StopPlane upper = halve(hi.back(), [](float a, float b) { return std::max(a, b); });
        lo.push_back(std::move(lower));
        hi.push_back(std::move(upper));
    }
}

void StopCells::MeasureRadii() {
    const int side = levels.front().side;
    const double half = 0.5 * side;
    double outer = 0.0;
    double clear = half;
    for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
            const std::size_t n = At2(i, j, side);
            const Vec2d middle(i + 0.5 - half, j + 0.5 - half);
            if (hi[0].values[n] > 0.0F) {
                const Vec2d far(std::abs(middle.x) + 0.5, std::abs(middle.y) + 0.5);
                outer = std::max(outer, far.length());
            }
            if (lo[0].values[n] != 1.0F || hi[0].values[n] != 1.0F) {
                const Vec2d near(std::max(0.0, std::abs(middle.x) - 0.5),
                                 std::max(0.0, std::abs(middle.y) - 0.5));
                clear = std::min(clear, near.length());
            }
        }
    }
    outer_radius = outer;
    clear_radius = clear;
}

StopRange StopCells::Over(Vec2d from, Vec2d to) const {
    const int side = levels.front().side;
    const auto cell = [&](double at) {
        // What is not a number is outside.
        return at >= 0.0 ? static_cast<int>(std::min(at, static_cast<double>(side))) : -1;
    };
    int i0 = cell(from.x), i1 = cell(to.x), j0 = cell(from.y), j1 = cell(to.y);
    if (i1 < 0 || j1 < 0 || i0 >= side || j0 >= side) return {0.0F, 0.0F};
    const bool beyond = i0 < 0 || j0 < 0 || i1 >= side || j1 >= side;
    StopRange range{beyond ? 0.0F : 1e30F, 0.0F};
    i0 = std::max(i0, 0);
    j0 = std::max(j0, 0);
    i1 = std::min(i1, side - 1);
    j1 = std::min(j1, side - 1);
    std::size_t level = 0;
    while (level + 1 < lo.size() && std::max(i1 - i0, j1 - j0) >= 4) {
        i0 /= 2;
        j0 /= 2;
        i1 /= 2;
        j1 /= 2;
        ++level;
    }
    for (int j = j0; j <= j1; ++j) {
        for (int i = i0; i <= i1; ++i) {
            range.lo = std::min(range.lo, lo[level].values[At2(i, j, lo[level].side)]);
            range.hi = std::max(range.hi, hi[level].values[At2(i, j, hi[level].side)]);
        }
    }
    return range;
}

// The mean over a part around p: as if the nearest edge were straight.
double StopCells::SharpAt(const Vec2d& p, const Vec2d& right, const Vec2d& down,
                          const Vec2d& smear) const {
    const double reach = 0.5 * (right.length() + down.length() + smear.length());
    const double at = DistanceAt(p);
    double cover = at < 0.0 ? 1.0 : 0.0;
    if (std::abs(at) < reach) {
        // The edge's normal, over about a cell.
        const Vec2d slope(DistanceAt(p + Vec2d(0.5, 0.0)) - DistanceAt(p - Vec2d(0.5, 0.0)),
                          DistanceAt(p + Vec2d(0.0, 0.5)) - DistanceAt(p - Vec2d(0.0, 0.5)));
        const double steep = slope.length();
        const Vec2d normal = steep > 0.3 ? slope / steep : Vec2d(0.7, 0.7);
        const double width =
            std::hypot(std::abs(normal.dot(right)) + std::abs(normal.dot(down)), normal.dot(smear));
        cover = std::clamp(0.5 - at / std::max(width, 1e-12), 0.0, 1.0);
    }
    double sum = 0.0;
    if (cover > 0.0) sum += cover * ShadeAt(light_shade, p, 1.0);
    if (cover < 1.0 && dark_shade.side > 0) sum += (1.0 - cover) * ShadeAt(dark_shade, p, 0.0);
    return sum;
}

}  // namespace flare
