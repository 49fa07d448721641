// SPDX-License-Identifier: Apache-2.0
#include "core/render/mask_outline.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/units.h"
#include "core/wave/coverage.h"

namespace flare {
namespace {

constexpr double kStraight = 0.25;  // cells
// So short a stretch between sides that are long is a corner that the cells have rounded, cells.
constexpr double kRounded = 10.0, kLong = 6.0;
constexpr double kCorner_rad = 20.0 * kPi / 180.0;
constexpr int kSidesAcross = 24;  // of the picture: longer sides are cut, since they bend

double Turn(Vec2d a, Vec2d b) {
    return std::atan2(a.cross(b), a.dot(b));
}

// Ramer, Douglas and Peucker: keeps the points between `first` and `last` that stand off.
void Keep(const Loop& loop, std::size_t first, std::size_t last, double tolerance,
          std::vector<bool>& kept) {
    std::vector<std::pair<std::size_t, std::size_t>> spans = {{first, last}};
    while (!spans.empty()) {
        const std::size_t from = spans.back().first;
        const std::size_t to = spans.back().second;
        spans.pop_back();
        const Vec2d a = loop[from];
        const Vec2d along = loop[to % loop.size()] - a;
        const double length = along.length();
        double most = tolerance;
        std::size_t farthest = from;
        for (std::size_t k = from + 1; k < to; ++k) {
            const Vec2d off = loop[k] - a;
            const double distance =
                length > 0.0 ? std::abs(along.cross(off)) / length : off.length();
            if (distance > most) {
                most = distance;
                farthest = k;
            }
        }
        if (farthest == from) continue;
        kept[farthest] = true;
        spans.push_back({from, farthest});
        spans.push_back({farthest, to});
    }
}

Loop Straightened(const Loop& loop, double tolerance) {
    if (loop.size() < 4) return loop;
    const auto farthest_from = [&](std::size_t k) {
        std::size_t best = 0;
        for (std::size_t n = 0; n < loop.size(); ++n) {
            if ((loop[n] - loop[k]).length2() > (loop[best] - loop[k]).length2()) best = n;
        }
        return best;
    };
    // Both ends of about the longest way across stay.
    const std::size_t a = farthest_from(0);
    const std::size_t b = farthest_from(a);
    const std::size_t low = std::min(a, b);
    Loop turned(loop.begin() + static_cast<std::ptrdiff_t>(low), loop.end());
    turned.insert(turned.end(), loop.begin(), loop.begin() + static_cast<std::ptrdiff_t>(low));
    std::vector<bool> kept(turned.size(), false);
    const std::size_t middle = std::max(a, b) - low;
    kept[0] = kept[middle] = true;
    Keep(turned, 0, middle, tolerance, kept);
    Keep(turned, middle, turned.size(), tolerance, kept);
    Loop out;
    for (std::size_t k = 0; k < turned.size(); ++k) {
        if (kept[k]) out.push_back(turned[k]);
    }
    return out;
}

// Puts the corner back where two long sides meet in a few short ones.
Loop Sharpened(const Loop& loop, double cell) {
    const std::size_t n = loop.size();
    const auto at = [&](std::size_t k) { return loop[k % n]; };
    std::vector<std::size_t> longs;  // sides, by their first points
    for (std::size_t k = 0; k < n; ++k) {
        if ((at(k + 1) - at(k)).length() >= kLong * cell) longs.push_back(k);
    }
    if (longs.size() < 2) return loop;
    Loop out;
    for (std::size_t c = 0; c < longs.size(); ++c) {
        // Points a ... b lie between two long sides.
        const std::size_t a = longs[c] + 1;
        const std::size_t b = c + 1 < longs.size() ? longs[c + 1] : longs[0] + n;
        double length = 0.0;
        for (std::size_t k = a; k < b; ++k) length += (at(k + 1) - at(k)).length();
        const Vec2d p = at(a) - at(a - 1);
        const Vec2d q = at(b + 1) - at(b);
        const bool rounded =
            b > a && length <= kRounded * cell && std::abs(Turn(p, q)) > kCorner_rad;
        const Vec2d corner =
            rounded ? at(a) + p * ((at(b) - at(a)).cross(q) / p.cross(q)) : Vec2d(0.0, 0.0);
        if (rounded && (corner - at(a)).length() < kRounded * cell) {
            out.push_back(corner);
            continue;
        }
        for (std::size_t k = a; k <= b; ++k) out.push_back(at(k));
    }
    return out;
}

Loop CutUp(const Loop& loop, double longest) {
    Loop out;
    for (std::size_t k = 0; k < loop.size(); ++k) {
        const Vec2d a = loop[k];
        const Vec2d side = loop[(k + 1) % loop.size()] - a;
        const int parts = std::max(1, static_cast<int>(std::ceil(side.length() / longest)));
        for (int i = 0; i < parts; ++i) out.push_back(a + side * (static_cast<double>(i) / parts));
    }
    return out;
}

// From a place at the stop to that in the bundle's plane.
class BackFromStop {
  public:
    BackFromStop(const Lens& lens, const LightBundle& bundle, const CanonicalPose& pose,
                 const BeamOutline& beam, double wavelength_nm)
        : bundle_(bundle),
          pose_(pose),
          list_(WriteOut(lens, {}, wavelength_nm)),
          middle_(beam.middle) {
        const double step = 0.1 * std::sqrt(beam.area_mm2);
        const auto at = StopAt(middle_);
        const auto u = StopAt(middle_ + Vec2d(step, 0.0));
        const auto u2 = StopAt(middle_ - Vec2d(step, 0.0));
        const auto v = StopAt(middle_ + Vec2d(0.0, step));
        const auto v2 = StopAt(middle_ - Vec2d(0.0, step));
        if (!at || !u || !v || !u2 || !v2) return;
        const Vec2d per_u = (*u - *u2) / (2.0 * step);
        const Vec2d per_v = (*v - *v2) / (2.0 * step);
        const double det = per_u.cross(per_v);
        if (det == 0.0) return;
        stop_ = *at;
        back_x_ = Vec2d(per_v.y, -per_u.y) / det;
        back_y_ = Vec2d(-per_v.x, per_u.x) / det;
        usable_ = true;
    }

    bool usable() const { return usable_; }

    // By Newton's method with the middle's slopes; first order where no ray comes.
    Vec2d operator()(Vec2d at_stop) const {
        constexpr double kNear_mm = 1e-5;
        const Vec2d first = middle_ + Step(at_stop - stop_);
        Vec2d place = first;
        for (int round = 0; round < 25; ++round) {
            const std::optional<Vec2d> at = StopAt(place);
            if (!at) return first;
            const Vec2d miss = at_stop - *at;
            if (miss.length() < kNear_mm) break;
            place += Step(miss);
        }
        return place;
    }

  private:
    Vec2d Step(Vec2d miss) const { return back_x_ * miss.x + back_y_ * miss.y; }

    std::optional<Vec2d> StopAt(Vec2d place) const {
        RayRecord record;
        TraceOptions options;
        options.clip = false;
        const TraceResult ray = TraceRay(list_, bundle_.At(place.x, place.y), options, &record);
        if (ray.fate != RayFate::kArrived || record.stop_mm.empty()) return std::nullopt;
        return pose_.LensSpace(record.stop_mm.front());
    }

    const LightBundle& bundle_;
    const CanonicalPose& pose_;
    InteractionList list_;
    Vec2d middle_;
    Vec2d stop_{0.0, 0.0}, back_x_{0.0, 0.0}, back_y_{0.0, 0.0};
    bool usable_ = false;
};

// Sutherland and Hodgman; the window is convex, or nearly, and anticlockwise.
Loop Clipped(Loop loop, const Loop& window) {
    for (std::size_t k = 0; k < window.size() && !loop.empty(); ++k) {
        const Vec2d& a = window[k];
        const Vec2d side = window[(k + 1) % window.size()] - a;
        const auto inside = [&](const Vec2d& p) { return side.cross(p - a); };
        const bool all =
            std::all_of(loop.begin(), loop.end(), [&](const Vec2d& p) { return inside(p) >= 0.0; });
        if (all) continue;
        Loop next;
        for (std::size_t n = 0; n < loop.size(); ++n) {
            const Vec2d& p = loop[n];
            const Vec2d& q = loop[(n + 1) % loop.size()];
            const double f = inside(p);
            const double g = inside(q);
            if (f >= 0.0) next.push_back(p);
            if ((f >= 0.0) != (g >= 0.0)) next.push_back(p + (q - p) * (f / (f - g)));
        }
        loop = std::move(next);
    }
    return loop;
}

// Points that lie apart, cut into pieces where the loop turns sharply.
std::optional<EdgeLoop> PiecesOf(const Loop& points, double size) {
    Loop loop;
    for (const Vec2d& p : points) {
        if (loop.empty() || (p - loop.back()).length() > 1e-5 * size) loop.push_back(p);
    }
    while (loop.size() > 1 && (loop.front() - loop.back()).length() <= 1e-5 * size) loop.pop_back();
    const std::size_t n = loop.size();
    if (n < 3) return std::nullopt;
    std::vector<std::size_t> corners;
    for (std::size_t k = 0; k < n; ++k) {
        const Vec2d in = loop[k] - loop[(k + n - 1) % n];
        const Vec2d out = loop[(k + 1) % n] - loop[k];
        if (std::abs(Turn(in, out)) > kCorner_rad) corners.push_back(k);
    }
    EdgeLoop edge;
    edge.smooth = corners.empty();
    if (corners.empty()) corners.push_back(0);
    for (std::size_t c = 0; c < corners.size(); ++c) {
        const std::size_t to = c + 1 < corners.size() ? corners[c + 1] : corners[0] + n;
        EdgePiece& piece = edge.pieces.emplace_back();
        for (std::size_t k = corners[c]; k <= to; ++k) piece.push_back(loop[k % n]);
    }
    return edge;
}

Loop PointsOf(const EdgeLoop& edge) {
    Loop points;
    for (const EdgePiece& piece : edge.pieces)
        points.insert(points.end(), piece.begin(), piece.end() - 1);
    return points;
}

}  // namespace

ApertureOutline FindMaskOutline(const Lens& lens, const LightBundle& bundle,
                                const CanonicalPose& pose, const StopPicture& picture,
                                const BeamOutline& beam, double wavelength_nm,
                                ThreadPool& threads) {
    const BackFromStop back(lens, bundle, pose, beam, wavelength_nm);
    if (!back.usable()) return {};
    const double cell = picture.cell_mm();
    std::vector<Loop> loops = picture.Outlines();
    const Loop window = PointsOf(beam.edge);
    threads.For(static_cast<int>(loops.size()), [&](int item) {
        Loop& loop = loops[static_cast<std::size_t>(item)];
        loop = CutUp(Sharpened(Straightened(loop, kStraight * cell), cell),
                     2.0 * picture.outer_radius() / kSidesAcross);
        for (Vec2d& p : loop) p = back(p);
        loop = Clipped(std::move(loop), window);
    });
    ApertureOutline outline;
    const double size = std::sqrt(beam.area_mm2);
    for (const Loop& loop : loops) {
        if (loop.size() < 3 || std::abs(SignedArea(loop)) < 1e-9 * beam.area_mm2) continue;
        if (std::optional<EdgeLoop> edge = PiecesOf(loop, size)) outline.push_back(*edge);
    }
    // The map from stop to bundle may mirror.
    if (AreaOf(outline) < 0.0) {
        for (EdgeLoop& loop : outline) {
            std::reverse(loop.pieces.begin(), loop.pieces.end());
            for (EdgePiece& piece : loop.pieces) std::reverse(piece.begin(), piece.end());
        }
    }
    return outline;
}

double AreaOf(const ApertureOutline& outline) {
    double area = 0.0;
    for (const EdgeLoop& loop : outline) area += SignedArea(PointsOf(loop));
    return area;
}

}  // namespace flare
