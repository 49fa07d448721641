// SPDX-License-Identifier: Apache-2.0
//
// The grid is eight times as wide as the aperture, so the pattern has eight samples to a fringe of
// the largest extent. Samples become means over cells by second and fourth differences, and sums
// between the corners of cells are read by polynomials through six of them, which keep the
// integral. With half as many samples the first dark ring is misplaced by 3 %.
#include "core/wave/near_pattern.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/units.h"
#include "core/wave/coverage.h"
#include "core/wave/fourier.h"

namespace flare {
namespace {

constexpr double kWidths = 8.0;  // of the grid, in the aperture's larger extent
// Up to this share of the sampling rate aliases of the mask are below about 3 % of the light.
constexpr double kUsable = 0.3;
// First zero of J1(x) / x over pi: D k of the first dark ring of a disc.
constexpr double kFirstZero = 1.2196698912665045;

struct Box {
    Vec2d lo{1e300, 1e300}, hi{-1e300, -1e300};
    void Hold(Vec2d p) {
        lo = {std::min(lo.x, p.x), std::min(lo.y, p.y)};
        hi = {std::max(hi.x, p.x), std::max(hi.y, p.y)};
    }
};

Box BoxOf(const ApertureOutline& outline) {
    Box box;
    for (const EdgeLoop& loop : outline) {
        for (const EdgePiece& piece : loop.pieces) {
            for (const Vec2d& p : piece) box.Hold(p);
        }
    }
    return box;
}

std::vector<Loop> LoopsOf(const ApertureOutline& outline, Vec2d middle) {
    std::vector<Loop> loops;
    for (const EdgeLoop& edge : outline) {
        Loop& loop = loops.emplace_back();
        for (const EdgePiece& piece : edge.pieces) {
            for (std::size_t i = 0; i + 1 < piece.size(); ++i) loop.push_back(piece[i] - middle);
        }
    }
    return loops;
}

// Area and second moments about the centroid of the area inside loops (Green).
struct Moments {
    double area = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
};

Moments MomentsOf(const std::vector<Loop>& loops) {
    Moments m;
    Vec2d first(0.0, 0.0);
    for (const Loop& loop : loops) {
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Vec2d& a = loop[i];
            const Vec2d& b = loop[(i + 1) % loop.size()];
            const double cross = a.x * b.y - a.y * b.x;
            m.area += cross / 2.0;
            first += (a + b) * (cross / 6.0);
            m.xx += cross * (a.x * a.x + a.x * b.x + b.x * b.x) / 12.0;
            m.yy += cross * (a.y * a.y + a.y * b.y + b.y * b.y) / 12.0;
            m.xy += cross * (2.0 * a.x * a.y + a.x * b.y + b.x * a.y + 2.0 * b.x * b.y) / 24.0;
        }
    }
    const Vec2d centroid = first / m.area;
    m.xx = m.xx / m.area - centroid.x * centroid.x;
    m.yy = m.yy / m.area - centroid.y * centroid.y;
    m.xy = m.xy / m.area - centroid.x * centroid.y;
    return m;
}

double Sinc(double x) {
    return x == 0.0 ? 1.0 : std::sin(kPi * x) / (kPi * x);
}

}  // namespace

NearPattern::NearPattern(const std::vector<ApertureOutline>& outlines, int side, bool without_core,
                         ThreadPool& threads)
    : side_(side) {
    FLARE_CHECK(!outlines.empty());
    double extent = 0.0;
    for (const ApertureOutline& outline : outlines) {
        const Box box = BoxOf(outline);
        extent = std::max({extent, box.hi.x - box.lo.x, box.hi.y - box.lo.y});
    }
    FLARE_CHECK(extent > 0.0);
    const double width = kWidths * extent;
    const double pitch = width / side;
    cell_ = 1.0 / width;
    limit_ = kUsable * side * cell_;

    const auto n = static_cast<std::size_t>(side);
    cells_.assign(n * n, 0.0);
    const SquareFourier fourier(side);
    double area = 0.0;
    for (const ApertureOutline& outline : outlines) {
        const Box box = BoxOf(outline);
        const std::vector<double> mask =
            Coverage(LoopsOf(outline, (box.lo + box.hi) * 0.5), side, pitch);
        for (const double share : mask) area += share * pitch * pitch;
        std::vector<Complex> field(mask.begin(), mask.end());
        fourier.Forward(field, threads);
        for (std::size_t k = 0; k < field.size(); ++k) cells_[k] += std::norm(field[k]);
    }
    // Transforms have k = 0 first; the averaging of the mask over its cells is undone.
    std::vector<double> density(n * n);
    const double scale = std::pow(pitch, 4) * cell_ * cell_ / area;
    for (std::size_t j = 0; j < n; ++j) {
        const double in_y = Sinc((static_cast<double>(j) - side / 2) / side);
        for (std::size_t i = 0; i < n; ++i) {
            const double in_x = Sinc((static_cast<double>(i) - side / 2) / side);
            density[j * n + i] =
                cells_[(j + n / 2) % n * n + (i + n / 2) % n] * scale / (in_x * in_x * in_y * in_y);
        }
    }
    cells_ = std::move(density);
    for (const std::size_t step : {std::size_t{1}, n}) ToCellMeans(step);
    RemoveCore(outlines, without_core);
    SumUp();
}

// Along rows (`step` 1) or columns: mean = f + d2 f / 24 - 17 d4 f / 5760 with differences d. The
// outermost cells stay samples.
void NearPattern::ToCellMeans(std::size_t step) {
    const auto n = static_cast<std::size_t>(side_);
    const std::size_t across = step == 1 ? n : 1;
    constexpr double kFourth = 17.0 / 5760.0;
    std::vector<double> line(n);
    for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t i = 0; i < n; ++i) line[i] = cells_[j * across + i * step];
        for (std::size_t i = 2; i + 2 < n; ++i) {
            const double second = line[i - 1] - 2.0 * line[i] + line[i + 1];
            const double fourth =
                line[i - 2] - 4.0 * (line[i - 1] + line[i + 1]) + 6.0 * line[i] + line[i + 2];
            cells_[j * across + i * step] = line[i] + second / 24.0 - kFourth * fourth;
        }
    }
}

void NearPattern::RemoveCore(const std::vector<ApertureOutline>& outlines, bool without_core) {
    // A disc of diameter D has second moments D^2 / 16.
    Moments mean;
    for (const ApertureOutline& outline : outlines) {
        const Moments m = MomentsOf(LoopsOf(outline, {0.0, 0.0}));
        mean.xx += m.xx / static_cast<double>(outlines.size());
        mean.xy += m.xy / static_cast<double>(outlines.size());
        mean.yy += m.yy / static_cast<double>(outlines.size());
    }
    const double edge = kFirstZero * kFirstZero / 16.0;
    const auto inside = [&](double x, double y) {
        return mean.xx * x * x + 2.0 * mean.xy * x * y + mean.yy * y * y < edge;
    };
    constexpr int kParts = 16;
    const double trace = mean.xx + mean.yy;
    const double determinant = mean.xx * mean.yy - mean.xy * mean.xy;
    const double smallest =
        0.5 * trace - std::sqrt(std::max(0.0, 0.25 * trace * trace - determinant));
    const int reach =
        std::min(side_ / 2 - 2, static_cast<int>(std::sqrt(edge / smallest) / cell_) + 2);
    for (int j = -reach; j <= reach; ++j) {
        for (int i = -reach; i <= reach; ++i) {
            int count = 0;
            for (int part = 0; part < kParts * kParts; ++part) {
                const double x = i - 0.5 + (part % kParts + 0.5) / kParts;
                const double y = j - 0.5 + (part / kParts + 0.5) / kParts;
                count += inside(x * cell_, y * cell_) ? 1 : 0;
            }
            double& light =
                cells_[static_cast<std::size_t>(j + side_ / 2) * static_cast<std::size_t>(side_) +
                       static_cast<std::size_t>(i + side_ / 2)];
            const double share = static_cast<double>(count) / (kParts * kParts);
            core_share_ += share * light;
            if (without_core) light *= 1.0 - share;
        }
    }
}

void NearPattern::SumUp() {
    const auto n = static_cast<std::size_t>(side_);
    sums_.assign((n + 1) * (n + 1), 0.0);
    for (std::size_t j = 0; j < n; ++j) {
        double row = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
            row += cells_[j * n + i];
            sums_[(j + 1) * (n + 1) + i + 1] = sums_[j * (n + 1) + i + 1] + row;
        }
    }
    cells_.clear();
    cells_.shrink_to_fit();
}

NearPattern::Line NearPattern::LineAt(double k) const {
    // Corner c of the grid stands at (c - side / 2 - 1/2) cells.
    const double at = std::clamp(k / cell_ + side_ / 2 + 0.5, 2.0, side_ - 2.000001);
    const double whole = std::floor(at);
    const double t = at - whole;
    // Lagrange's polynomials through the corners at -2 ... 3.
    Line line;
    line.first = static_cast<std::size_t>(whole) - 2;
    for (std::size_t own = 0; own < line.weights.size(); ++own) {
        double weight = 1.0;
        for (std::size_t other = 0; other < line.weights.size(); ++other) {
            if (other == own) continue;
            weight *= (t + 2.0 - static_cast<double>(other)) /
                      (static_cast<double>(own) - static_cast<double>(other));
        }
        line.weights[own] = weight;
    }
    return line;
}

double NearPattern::Below(const Line& x, const Line& y) const {
    const auto width = static_cast<std::size_t>(side_) + 1;
    const double* row = sums_.data() + y.first * width + x.first;
    double sum = 0.0;
    for (const double weight : y.weights) {
        double across = 0.0;
        for (std::size_t i = 0; i < x.weights.size(); ++i) across += x.weights[i] * row[i];
        sum += weight * across;
        row += width;
    }
    return sum;
}

}  // namespace flare
