// SPDX-License-Identifier: Apache-2.0
#include "core/render/ghost_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "core/tracing/trace_columns.h"

namespace flare {
namespace {

constexpr int kCells = 12;  // along a side of the traced rectangle
constexpr int kSide = kCells + 1;
constexpr std::size_t kTurns = 5;            // not at all, and to both sides along u and along v
constexpr double kTurnShare = 0.7;           // of the source's radius
constexpr double kLeastTurn_rad = 1e-4;      // floats show no smaller one well
constexpr double kFlat = 0.05;               // of the mean area of a cell: less counts as a fold
constexpr double kInnerWeight = 0.01;        // of a ray that stands on no edge, for what edges lack
constexpr double kMeanDistance = 0.4244132;  // 4 / (3 pi): of a disc's points from its diameter
constexpr double kSkew = 0.15;               // of edges whose speed changes within the source

struct Matrix {
    Vec2d u{0.0, 0.0}, v{0.0, 0.0};  // columns
    double Determinant() const { return u.x * v.y - u.y * v.x; }
};

// How the masks and the place of a ray change around it: a cell, and the turns, as units.
struct Rates {
    Matrix place;  // pixels a cell
    Vec2d mask{0.0, 0.0};
    std::array<Vec2d, 2> turned_place{Vec2d(0.0), Vec2d(0.0)};  // pixels a turn, along u and v
    std::array<double, 2> turned_mask{};
    std::array<Vec2d, 2> bent_place{Vec2d(0.0), Vec2d(0.0)};  // second differences
    std::array<double, 2> bent_mask{};
};

Rates Mixed(const Rates& a, const Rates& b, double t) {
    const auto mix = [t](const auto& x, const auto& y) { return x * (1.0 - t) + y * t; };
    Rates out;
    out.place = {mix(a.place.u, b.place.u), mix(a.place.v, b.place.v)};
    out.mask = mix(a.mask, b.mask);
    for (std::size_t k = 0; k < 2; ++k) {
        out.turned_place[k] = mix(a.turned_place[k], b.turned_place[k]);
        out.turned_mask[k] = mix(a.turned_mask[k], b.turned_mask[k]);
        out.bent_place[k] = mix(a.bent_place[k], b.bent_place[k]);
        out.bent_mask[k] = mix(a.bent_mask[k], b.bent_mask[k]);
    }
    return out;
}

// A part of the ghost's outline: it moves across itself by `speed` pixels a turn.
struct EdgePart {
    Vec2d normal{1.0, 0.0};
    std::array<double, 2> speed{}, bend{};
    double light = 0.0;  // cells of the pupil a pixel of motion
};

class Tracker {
  public:
    Tracker(const SampleScene& scene, const BounceSequence& sequence, const Rect& region,
            double radius_rad)
        : scene_(scene),
          list_(WriteOut(scene.lens, sequence, scene.tables.wavelengths_nm().front())),
          region_(region),
          radius_(radius_rad),
          turn_(std::max(kTurnShare * radius_rad, kLeastTurn_rad)) {
        needs_.passage = false;
    }

    GhostMotion Run() {
        for (std::size_t t = 0; t < kTurns; ++t) Trace(t);
        Measure();
        if (passing_ == 0) return motion_;
        for (int j = 0; j < kSide; ++j) {
            for (int i = 0; i < kSide; ++i) {
                AddPair(i, j, 1, 0);
                AddPair(i, j, 0, 1);
                AddInner(i, j);
            }
        }
        Fit();
        return motion_;
    }

  private:
    static std::size_t Index(int i, int j) { return static_cast<std::size_t>(j * kSide + i); }

    void Trace(std::size_t t) {
        static constexpr std::array<std::array<double, 2>, kTurns> kLean{
            {{0.0, 0.0}, {1.0, 0.0}, {-1.0, 0.0}, {0.0, 1.0}, {0.0, -1.0}}};
        const Vec2d turn(kLean[t][0] * turn_, kLean[t][1] * turn_);
        const double du = (region_.u1 - region_.u0) / kCells;
        const double dv = (region_.v1 - region_.v0) / kCells;
        rays_.Resize(Index(0, kSide));
        for (int j = 0; j < kSide; ++j) {
            for (int i = 0; i < kSide; ++i) {
                const Ray ray =
                    scene_.bundle.TurnedAtFront(region_.u0 + i * du, region_.v0 + j * dv, turn);
                rays_.Set(Index(i, j), ray.origin, ray.direction);
            }
        }
        TraceInColumns(list_, rays_, needs_, traced_[t]);
        motion_.rays += rays_.size();
    }

    bool Alive(std::size_t t, std::size_t k) const {
        return traced_[t].ended_at[k] == TraceColumns::kArrived && traced_[t].disorder[k] < 2;
    }

    Vec2d Place(std::size_t t, std::size_t k) const {
        const TraceColumns& at = traced_[t];
        const double gap = list_.sensor_z_mm - list_.steps.back().vertex_z_mm;
        return scene_.map.Pixel(
            static_cast<double>(at.exit_x[k]) + gap * static_cast<double>(at.slope_x[k]),
            static_cast<double>(at.exit_y[k]) + gap * static_cast<double>(at.slope_y[k]));
    }

    // Masks are numbered: the rims of all interactions, then the iris at each crossing.
    std::size_t mask_count() const {
        return list_.steps.size() + static_cast<std::size_t>(list_.stop_crossings);
    }

    // Positive outside.
    double Mask(std::size_t t, std::size_t k, std::size_t mask) const {
        const TraceColumns& at = traced_[t];
        const std::size_t rims = list_.steps.size();
        if (mask < rims) {
            return std::sqrt(static_cast<double>(at.rim_ratio2[mask * at.stride + k])) - 1.0;
        }
        const std::size_t place = (mask - rims) * at.stride + k;
        const Vec2d stop = scene_.pose.LensSpace(
            {static_cast<double>(at.stop_x[place]), static_cast<double>(at.stop_y[place])});
        return scene_.iris.Distance(stop) / scene_.iris.outer_radius();
    }

    bool Passes(std::size_t k) const { return passes_[k]; }

    // Which rays pass, and the mean area of a cell.
    void Measure() {
        passes_.assign(Index(0, kSide), false);
        for (std::size_t k = 0; k < passes_.size(); ++k) {
            if (!Alive(0, k)) continue;
            bool passes = true;
            for (std::size_t m = 0; passes && m < mask_count(); ++m) passes = Mask(0, k, m) < 0.0;
            passes_[k] = passes;
            passing_ += passes ? 1 : 0;
        }
        double area = 0.0;
        int counted = 0;
        for (int j = 0; j + 1 < kSide; ++j) {
            for (int i = 0; i + 1 < kSide; ++i) {
                if (!Passes(Index(i, j)) || !Alive(0, Index(i + 1, j)) ||
                    !Alive(0, Index(i, j + 1)))
                    continue;
                const Vec2d at = Place(0, Index(i, j));
                const Matrix cell{Place(0, Index(i + 1, j)) - at, Place(0, Index(i, j + 1)) - at};
                area += std::abs(cell.Determinant());
                ++counted;
            }
        }
        mean_area_ = counted > 0 ? std::max(area / counted, 1e-12) : 1e-12;
    }

    std::optional<Rates> RatesAt(int i, int j, std::size_t mask) const {
        if (i < 1 || j < 1 || i + 1 >= kSide || j + 1 >= kSide) return std::nullopt;
        const std::size_t k = Index(i, j);
        const std::array<std::size_t, 4> around{Index(i + 1, j), Index(i - 1, j), Index(i, j + 1),
                                                Index(i, j - 1)};
        for (const std::size_t n : around) {
            if (!Alive(0, n)) return std::nullopt;
        }
        for (std::size_t t = 0; t < kTurns; ++t) {
            if (!Alive(t, k)) return std::nullopt;
        }
        Rates r;
        r.place = {(Place(0, around[0]) - Place(0, around[1])) * 0.5,
                   (Place(0, around[2]) - Place(0, around[3])) * 0.5};
        r.mask = {0.5 * (Mask(0, around[0], mask) - Mask(0, around[1], mask)),
                  0.5 * (Mask(0, around[2], mask) - Mask(0, around[3], mask))};
        const Vec2d place = Place(0, k);
        const double at = Mask(0, k, mask);
        for (std::size_t a = 0; a < 2; ++a) {
            const Vec2d ahead = Place(1 + 2 * a, k);
            const Vec2d behind = Place(2 + 2 * a, k);
            const double mask_ahead = Mask(1 + 2 * a, k, mask);
            const double mask_behind = Mask(2 + 2 * a, k, mask);
            r.turned_place[a] = (ahead - behind) * 0.5;
            r.turned_mask[a] = 0.5 * (mask_ahead - mask_behind);
            r.bent_place[a] = ahead + behind - place * 2.0;
            r.bent_mask[a] = mask_ahead + mask_behind - 2.0 * at;
        }
        return r;
    }

    // Between two neighbours: the edge of a mask, or a fold.
    void AddPair(int i, int j, int di, int dj) {
        if (i + di >= kSide || j + dj >= kSide) return;
        const std::size_t a = Index(i, j);
        const std::size_t b = Index(i + di, j + dj);
        if (Passes(a) && Passes(b)) {
            AddFold(i, j, di, dj);
        } else if (Passes(a) && Alive(0, b)) {
            AddEdge(i, j, i + di, j + dj);
        } else if (Passes(b) && Alive(0, a)) {
            AddEdge(i + di, j + dj, i, j);
        }
    }

    // From a ray that passes to one that does not.
    void AddEdge(int i, int j, int to_i, int to_j) {
        const std::size_t in = Index(i, j);
        const std::size_t out = Index(to_i, to_j);
        double nearest = 2.0;
        std::size_t mask = 0;
        for (std::size_t m = 0; m < mask_count(); ++m) {
            const double outside = Mask(0, out, m);
            if (outside < 0.0) continue;
            const double inside = Mask(0, in, m);
            const double t = inside / (inside - outside);
            if (t < nearest) {
                nearest = t;
                mask = m;
            }
        }
        const std::optional<Rates> here = RatesAt(i, j, mask);
        const std::optional<Rates> there = RatesAt(to_i, to_j, mask);
        if (!here && !there) return;
        const Rates r = here && there ? Mixed(*here, *there, nearest) : (here ? *here : *there);
        AddEdgePart(r);
    }

    // An edge stays where its mask is zero: with g the mask, x the place, n the edge's normal on
    // the picture, n dx/du = l dg/du; it moves along n by n dx/da - l dg/da.
    void AddEdgePart(const Rates& r) {
        const double steep = r.mask.length();
        const double det = r.place.Determinant();
        const Vec2d a(r.mask.x * r.place.v.y - r.mask.y * r.place.u.y,
                      r.mask.y * r.place.u.x - r.mask.x * r.place.v.x);
        const double size = a.length();
        if (!(steep > 0.0) || !(size > 0.0)) return;
        EdgePart part;
        part.normal = a / size;
        const double l = det / size;
        for (std::size_t k = 0; k < 2; ++k) {
            part.speed[k] = part.normal.dot(r.turned_place[k]) - l * r.turned_mask[k];
            part.bend[k] = part.normal.dot(r.bent_place[k]) - l * r.bent_mask[k];
        }
        // The pairs of neighbours along an edge lie this far apart on it.
        const double length = steep / (std::abs(r.mask.x) + std::abs(r.mask.y));
        part.light = length * size / (steep * std::max(std::abs(det), kFlat * mean_area_));
        parts_.push_back(part);
    }

    void AddFold(int i, int j, int di, int dj) {
        const std::optional<Rates> here = RatesAt(i, j, 0);
        const std::optional<Rates> there = RatesAt(i + di, j + dj, 0);
        if (!here || !there) return;
        const double det = here->place.Determinant();
        const double det_there = there->place.Determinant();
        if ((det > 0.0) == (det_there > 0.0)) return;
        const Rates r = Mixed(*here, *there, det / (det - det_there));
        // At the fold all of the pupil moves along it.
        const Vec2d along = r.place.u.length() > r.place.v.length() ? r.place.u : r.place.v;
        if (!(along.length() > 0.0)) return;
        EdgePart part;
        part.normal = Vec2d(-along.y, along.x) / along.length();
        for (std::size_t k = 0; k < 2; ++k) {
            part.speed[k] = part.normal.dot(r.turned_place[k]);
            part.bend[k] = part.normal.dot(r.bent_place[k]);
        }
        const double depth = std::abs(part.normal.dot(here->place.u + here->place.v)) +
                             std::abs(part.normal.dot(there->place.u + there->place.v));
        const double reach =
            std::hypot(part.speed[0], part.speed[1]) * radius_ / turn_ + 0.5 + depth;
        part.light = 1.0 / reach;
        parts_.push_back(part);
    }

    // For a ghost whose edges face one way only: the motion at a fixed stop point.
    void AddInner(int i, int j) {
        if (!Passes(Index(i, j)) || list_.stop_crossings == 0) return;
        const std::size_t k = Index(i, j);
        if (!RatesAt(i, j, 0)) return;
        const Rates r = *RatesAt(i, j, 0);
        const auto stop = [&](std::size_t t, std::size_t n) {
            return Vec2d(static_cast<double>(traced_[t].stop_x[n]),
                         static_cast<double>(traced_[t].stop_y[n]));
        };
        const Matrix s{(stop(0, Index(i + 1, j)) - stop(0, Index(i - 1, j))) * 0.5,
                       (stop(0, Index(i, j + 1)) - stop(0, Index(i, j - 1))) * 0.5};
        const double det = s.Determinant();
        if (det == 0.0) return;
        Inner inner;
        for (std::size_t a = 0; a < 2; ++a) {
            const Vec2d moved = (stop(1 + 2 * a, k) - stop(2 + 2 * a, k)) * 0.5;
            const Vec2d back((s.v.y * moved.x - s.v.x * moved.y) / det,
                             (s.u.x * moved.y - s.u.y * moved.x) / det);
            inner.speed[a] = r.turned_place[a] - r.place.u * back.x - r.place.v * back.y;
        }
        inner_.push_back(inner);
    }

    void Fit() {
        double edge_light = 0.0;
        for (const EdgePart& part : parts_) edge_light += part.light;
        double xx = 0.0, xy = 0.0, yy = 0.0;
        std::array<Vec2d, 2> rhs{Vec2d(0.0), Vec2d(0.0)};
        for (const EdgePart& part : parts_) {
            const Vec2d& n = part.normal;
            xx += part.light * n.x * n.x;
            xy += part.light * n.x * n.y;
            yy += part.light * n.y * n.y;
            for (std::size_t a = 0; a < 2; ++a) rhs[a] += n * (part.light * part.speed[a]);
        }
        const double inner_weight = inner_.empty()
                                        ? 0.0
                                        : kInnerWeight * (edge_light > 0.0 ? edge_light : 1.0) /
                                              static_cast<double>(inner_.size());
        for (const Inner& inner : inner_) {
            xx += inner_weight;
            yy += inner_weight;
            for (std::size_t a = 0; a < 2; ++a) rhs[a] += inner.speed[a] * inner_weight;
        }
        const double det = xx * yy - xy * xy;
        if (!(det > 1e-12 * xx * yy)) return;
        motion_.known = true;
        const auto solve = [&](Vec2d r) {
            return Vec2d(yy * r.x - xy * r.y, xx * r.y - xy * r.x) / det;
        };
        const Vec2d along_u = solve(rhs[0]);
        const Vec2d along_v = solve(rhs[1]);
        const double to_edge = radius_ / turn_;
        double misplaced = 0.0;
        for (const EdgePart& part : parts_) {
            const double drawn = std::hypot(part.normal.dot(along_u), part.normal.dot(along_v));
            const double real = std::hypot(part.speed[0], part.speed[1]);
            const double bent = std::hypot(part.bend[0], part.bend[1]) * to_edge * to_edge;
            misplaced +=
                part.light * (kMeanDistance * std::abs(drawn - real) * to_edge + kSkew * bent);
        }
        motion_.error = std::min(1.0, misplaced / passing_);
        motion_.along_u = along_u / turn_;
        motion_.along_v = along_v / turn_;
    }

    struct Inner {
        std::array<Vec2d, 2> speed{Vec2d(0.0), Vec2d(0.0)};
    };

    const SampleScene& scene_;
    InteractionList list_;
    Rect region_;
    double radius_, turn_;
    ColumnNeeds needs_;
    RayColumns rays_;
    std::array<TraceColumns, kTurns> traced_;
    std::vector<bool> passes_;
    int passing_ = 0;
    double mean_area_ = 0.0;  // px^2 a cell
    std::vector<EdgePart> parts_;
    std::vector<Inner> inner_;
    GhostMotion motion_;
};

}  // namespace

GhostMotion MotionOf(const SampleScene& scene, const BounceSequence& sequence, const Rect& region,
                     double radius_rad) {
    return Tracker(scene, sequence, region, radius_rad).Run();
}

}  // namespace flare
