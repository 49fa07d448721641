// SPDX-License-Identifier: Apache-2.0
//
// Signed-area accumulation, as in font rasterisers: every edge adds, row by row, how much its rise
// covers of the pixel it passes and of everything to the right of it; a running sum along the row
// then gives each pixel's covered area. Here the edges carry the polygon's density, so the edges of
// many polygons go into one small buffer and are summed up once. The buffer is tens of pixels wide
// and in double precision, so the sums are exact to rounding. A row's values come from the whole
// edge, not from the row before, so they do not depend on where a strip begins.
#include "core/image/polygon_raster.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace flare {
namespace {

// Below this area (in pixels) the density would drown in the rounding of the cover.
constexpr double kSliverArea = 1e-10;

// Polygons wider than this are clipped to the target before they are spread, so that a far-flung
// one costs no more than the window.
constexpr double kWidest = 2048.0;

// Running sums end at zero but for rounding; what is left below this share of the density is
// nothing.
constexpr double kRounding = 1e-13;

// The channels of a pixel as one value. Pairs of doubles are GNU vectors (also known to clang): one
// instruction on every x86-64 and AArch64.
typedef double Pair __attribute__((vector_size(16), aligned(8)));
typedef long long PairMask __attribute__((vector_size(16), aligned(8)));

struct Colour {
    Pair low, high;

    void Add(const Colour& other) {
        low += other.low;
        high += other.high;
    }
    void AddScaled(const Colour& other, double scale) {
        low += other.low * scale;
        high += other.high * scale;
    }
    // Adds `other` where it is larger than `nothing`.
    void AddAbove(const Colour& other, double nothing) {
        low += Above(other.low, nothing);
        high += Above(other.high, nothing);
    }
    static Pair Above(Pair value, double nothing) {
        const PairMask keep = (value > nothing) | (value < -nothing);
        return reinterpret_cast<Pair>(reinterpret_cast<PairMask>(value) & keep);
    }
};

struct Grey {
    double value;

    void Add(const Grey& other) { value += other.value; }
    void AddScaled(const Grey& other, double scale) { value += other.value * scale; }
    void AddAbove(const Grey& other, double nothing) {
        if (std::abs(other.value) > nothing) value += other.value;
    }
};

template <int kChannels>
struct PixelType {
    using Type = Colour;
};
template <>
struct PixelType<1> {
    using Type = Grey;
};

double SignedArea(std::span<const Vec2d> points) {
    double twice = 0.0;
    const Vec2d& origin = points.front();
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
        twice += (points[i] - origin).cross(points[i + 1] - origin);
    }
    return 0.5 * twice;
}

struct Bounds {
    Vec2d lo, hi;
};

Bounds BoundsOf(std::span<const Vec2d> points) {
    Bounds b{points[0], points[0]};
    for (const Vec2d& p : points) {
        b.lo = {std::min(b.lo.x, p.x), std::min(b.lo.y, p.y)};
        b.hi = {std::max(b.hi.x, p.x), std::max(b.hi.y, p.y)};
    }
    return b;
}

// The part of the polygon where sign * (coordinate - bound) <= 0.
std::vector<Vec2d> ClipHalfPlane(const std::vector<Vec2d>& points, int axis, double bound,
                                 double sign) {
    std::vector<Vec2d> kept;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec2d& a = points[i];
        const Vec2d& b = points[(i + 1) % points.size()];
        const double fa = sign * (a[axis] - bound);
        const double fb = sign * (b[axis] - bound);
        if (fa <= 0.0) kept.push_back(a);
        if ((fa <= 0.0) != (fb <= 0.0)) {
            Vec2d cut = a + (b - a) * (fa / (fa - fb));
            cut[axis] = bound;
            kept.push_back(cut);
        }
    }
    return kept;
}

}  // namespace

PolygonRaster::PolygonRaster(const RasterTarget& target, int channels)
    : target_(target), channels_(static_cast<std::size_t>(channels)) {
    FLARE_CHECK(channels == 1 || channels == 3);
}

void PolygonRaster::Add(std::span<const Vec2d> points, std::span<const double> amounts, int layer) {
    const auto [lo, hi] = BoundsOf(points);
    // Also false for NaN, which no finite mesh has.
    if (!(hi.y >= target_.y0 && lo.y < target_.y0 + target_.rows && hi.x >= target_.x0 &&
          lo.x < target_.x0 + target_.width)) {
        return;
    }
    if (hi.x - lo.x > kWidest || hi.y - lo.y > kWidest) {
        CollectClipped(points, amounts.data(), layer);
    } else {
        Collect(points, amounts.data(), layer);
    }
}

void PolygonRaster::Collect(std::span<const Vec2d> points, const double* amounts, int layer) {
    const auto [lo, hi] = BoundsOf(points);
    const Box box{static_cast<int>(std::floor(lo.x)), static_cast<int>(std::floor(lo.y)),
                  static_cast<int>(std::floor(hi.x)) + 1, static_cast<int>(std::floor(hi.y)) + 1};
    if (box.x1 - box.x0 == 1 && box.y1 - box.y0 == 1) {
        CollectPixel(box.x0, box.y0, amounts, 1.0, layer);
        return;
    }
    const double area = SignedArea(points);
    if (!(std::abs(area) > kSliverArea)) {
        CollectSliver(points, amounts, layer);
        return;
    }
    Item item;
    item.begin = points_.size();
    points_.insert(points_.end(), points.begin(), points.end());
    item.end = points_.size();
    item.box = box;
    item.layer = layer;
    // With y downwards an edge that goes down covers what lies right of it.
    for (std::size_t c = 0; c < channels_; ++c) item.density[c] = -amounts[c] / area;
    items_.push_back(item);
}

void PolygonRaster::CollectPixel(int x, int y, const double* amounts, double share, int layer) {
    if (x < target_.x0 || x >= target_.x0 + target_.width || y < target_.y0 ||
        y >= target_.y0 + target_.rows) {
        return;
    }
    Item item;
    item.box = {x, y, x + 1, y + 1};
    item.one_pixel = true;
    item.layer = layer;
    for (std::size_t c = 0; c < channels_; ++c) item.density[c] = share * amounts[c];
    items_.push_back(item);
}

void PolygonRaster::CollectSliver(std::span<const Vec2d> points, const double* amounts, int layer) {
    Vec2d a = points[0], b = points[0];
    for (const Vec2d& p : points) {
        for (const Vec2d& q : points) {
            if ((p - q).length2() > (a - b).length2()) {
                a = p;
                b = q;
            }
        }
    }
    const int pieces = 1 + static_cast<int>(4.0 * (a - b).length());
    for (int i = 0; i < pieces; ++i) {
        const Vec2d p = a + (b - a) * ((i + 0.5) / pieces);
        CollectPixel(static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)), amounts,
                     1.0 / pieces, layer);
    }
}

void PolygonRaster::CollectClipped(std::span<const Vec2d> points, const double* amounts,
                                   int layer) {
    const double area = SignedArea(points);
    if (!std::isfinite(area) || area == 0.0) return;
    std::vector<Vec2d> clipped(points.begin(), points.end());
    clipped = ClipHalfPlane(clipped, 0, target_.x0, -1.0);
    if (!clipped.empty()) clipped = ClipHalfPlane(clipped, 0, target_.x0 + target_.width, 1.0);
    if (!clipped.empty()) clipped = ClipHalfPlane(clipped, 1, target_.y0, -1.0);
    if (!clipped.empty()) clipped = ClipHalfPlane(clipped, 1, target_.y0 + target_.rows, 1.0);
    if (clipped.size() < 3) return;
    double part[kColourStride] = {};
    const double share = SignedArea(clipped) / area;
    for (std::size_t c = 0; c < channels_; ++c) part[c] = amounts[c] * share;
    Collect(clipped, part, layer);
}

void PolygonRaster::Flush() {
    // Neighbours in the list that go to the same layer make a group as long as their common box is
    // no larger than their own boxes together.
    const auto area = [](const Box& box) {
        return static_cast<double>(box.x1 - box.x0) * static_cast<double>(box.y1 - box.y0);
    };
    for (std::size_t first = 0; first < items_.size();) {
        Box group = items_[first].box;
        double members = area(group);
        std::size_t last = first + 1;
        for (; last < items_.size(); ++last) {
            const Item& item = items_[last];
            if (item.layer != items_[first].layer) break;
            const Box joined{std::min(group.x0, item.box.x0), std::min(group.y0, item.box.y0),
                             std::max(group.x1, item.box.x1), std::max(group.y1, item.box.y1)};
            members += area(item.box);
            if (area(joined) > members) break;
            group = joined;
        }
        Spread(first, last, group);
        first = last;
    }
    items_.clear();
    points_.clear();
}

void PolygonRaster::Spread(std::size_t first, std::size_t last, const Box& box) {
    const Box inside{box.x0, std::max(box.y0, target_.y0), box.x1,
                     std::min(box.y1, target_.y0 + target_.rows)};
    if (inside.y1 <= inside.y0) return;
    if (channels_ == 3) {
        SpreadItems<kColourStride>(first, last, inside);
    } else {
        SpreadItems<1>(first, last, inside);
    }
}

template <int kChannels>
void PolygonRaster::SpreadItems(std::size_t first, std::size_t last, const Box& box) {
    const auto cells =
        static_cast<std::size_t>(box.y1 - box.y0) * static_cast<std::size_t>(box.x1 - box.x0 + 1);
    cover_.assign(cells * kChannels, 0.0);
    touched_.assign(static_cast<std::size_t>(box.y1 - box.y0), {box.x1 - box.x0, 0});
    group_density_ = 0.0;
    for (std::size_t n = first; n < last; ++n) {
        const Item& item = items_[n];
        for (int c = 0; c < kChannels; ++c)
            group_density_ = std::max(group_density_, std::abs(item.density[c]));
        if (item.one_pixel) {
            Touch(item.box.y0 - box.y0, item.box.x0 - box.x0, item.box.x0 - box.x0);
            double* const at = &cover_[(static_cast<std::size_t>(item.box.y0 - box.y0) *
                                            static_cast<std::size_t>(box.x1 - box.x0 + 1) +
                                        static_cast<std::size_t>(item.box.x0 - box.x0)) *
                                       kChannels];
            for (int c = 0; c < kChannels; ++c) {
                at[c] += item.density[c];
                at[c + kChannels] -= item.density[c];
            }
            ++fragments_;
            continue;
        }
        const std::size_t count = item.end - item.begin;
        for (std::size_t k = 0; k < count; ++k) {
            AddEdge<kChannels>(points_[item.begin + k], points_[item.begin + (k + 1) % count],
                               item.density, box);
        }
        const int rows = std::min(item.box.y1, box.y1) - std::max(item.box.y0, box.y0);
        fragments_ += static_cast<std::uint64_t>(std::max(0, rows)) *
                      static_cast<std::uint64_t>(item.box.x1 - item.box.x0);
    }
    AddRows<kChannels>(box, items_[first].layer);
}

template <int kChannels>
void PolygonRaster::AddEdge(const Vec2d& from, const Vec2d& to, const double* density,
                            const Box& box) {
    if (from.y == to.y) return;
    using Pixel = typename PixelType<kChannels>::Type;
    const Pixel light = *reinterpret_cast<const Pixel*>(density);
    const double sign = from.y < to.y ? 1.0 : -1.0;
    const Vec2d& top = from.y < to.y ? from : to;
    const Vec2d& bottom = from.y < to.y ? to : from;
    const double slope = (bottom.x - top.x) / (bottom.y - top.y);
    const int first = std::max(box.y0, static_cast<int>(std::floor(top.y)));
    const int last = std::min(box.y1 - 1, static_cast<int>(std::floor(bottom.y)));
    const double lo_x = std::min(from.x, to.x);
    const double hi_x = std::max(from.x, to.x);
    const int columns = box.x1 - box.x0;
    for (int row = first; row <= last; ++row) {
        const double ya = std::max(top.y, static_cast<double>(row));
        const double yb = std::min(bottom.y, row + 1.0);
        const double rise = yb - ya;
        if (!(rise > 0.0)) continue;
        double* const cover = &cover_[static_cast<std::size_t>(row - box.y0) *
                                      static_cast<std::size_t>(columns + 1) * kChannels];
        const double xa = std::clamp(top.x + (ya - top.y) * slope, lo_x, hi_x) - box.x0;
        const double xb = std::clamp(top.x + (yb - top.y) * slope, lo_x, hi_x) - box.x0;
        const double xl = std::min(xa, xb);
        const double xr = std::max(xa, xb);
        const int cl = std::min(static_cast<int>(xl), columns - 1);
        const int cr = std::min(static_cast<int>(xr), columns - 1);
        const auto put = [&](int column, double risen, double area) {
            auto* const at =
                reinterpret_cast<Pixel*>(cover + static_cast<std::ptrdiff_t>(column) * kChannels);
            at[0].AddScaled(light, area);
            // Columns further right are covered by all of it: the running sum carries it there.
            at[1].AddScaled(light, risen - area);
        };
        Touch(row - box.y0, cl, cr);
        const double d = sign * rise;
        if (cl == cr) {
            // Everything within one pixel column: a trapezium on its right side.
            put(cl, d, d * (1.0 - (0.5 * (xl + xr) - cl)));
            continue;
        }
        // The edge crosses columns cl ... cr, rising by the same amount over each full column.
        const double per_column = d / (xr - xl);
        for (int column = cl; column <= cr; ++column) {
            const double s = std::max(xl, static_cast<double>(column)) - column;
            const double e = std::min(xr, column + 1.0) - column;
            const double risen = per_column * (e - s);
            put(column, risen, risen * (1.0 - 0.5 * (s + e)));
        }
    }
}

template <int kChannels>
void PolygonRaster::AddRows(const Box& box, int layer) {
    using Pixel = typename PixelType<kChannels>::Type;
    const double nothing = kRounding * group_density_;
    for (int row = box.y0; row < box.y1; ++row) {
        const auto [from, to] = touched_[static_cast<std::size_t>(row - box.y0)];
        const int first = std::max(box.x0 + from, target_.x0);
        const int end = std::min(box.x0 + to, target_.x0 + target_.width);
        if (end <= first) continue;
        const auto* cover = reinterpret_cast<const Pixel*>(
            &cover_[static_cast<std::size_t>(row - box.y0) *
                    static_cast<std::size_t>(box.x1 - box.x0 + 1) * kChannels]);
        cover += from;
        Pixel sum{};
        for (int x = box.x0 + from; x < first; ++x) sum.Add(*cover++);
        auto* out = reinterpret_cast<Pixel*>(
            target_.layers[static_cast<std::size_t>(layer)] +
            (static_cast<std::ptrdiff_t>(row - target_.y0) * target_.width + first - target_.x0) *
                kChannels);
        for (int x = first; x < end; ++x) {
            sum.Add(*cover++);
            out->AddAbove(sum, nothing);
            ++out;
        }
    }
}

}  // namespace flare
