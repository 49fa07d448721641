// SPDX-License-Identifier: Apache-2.0
//
// A coarse grid over the front is traced without clipping. A cell may hold passing rays unless, at
// some interaction, the box around its corners' hits, widened for curvature, lies outside that rim.
// The search zooms on the cells that may pass until they fill the grid or nothing is left. Boxes of
// hit points, not rim ratios, since a cell larger than the pass region has every corner outside.
//
// Where rays die at different surfaces nothing can be said of the rays between them, so the search
// may stall on such borders, far from any passing ray (a fisheye's regions are a hundredth of its
// front). Then the light is followed from surface to surface first: the rays that come deepest show
// where those that come deeper still must be.
#include "core/mesh/pass_region.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/tracing/trace_columns.h"

namespace flare {
namespace {

constexpr int kCellsU = 32;
constexpr int kCellsHalf = 16;  // over v >= 0, where the other half is its mirror image
constexpr int kMaxZooms = 8;
constexpr int kMaxFollows = 24;
constexpr int kMaxWidenings = 4;
constexpr int kFew = 9;  // passing corners of a grid that show a region's outline; fewer do not
constexpr double kTight = 0.3;   // of the last grid is filled by the rays that pass
constexpr int kIslandCells = 3;  // a side of a cell that is looked into

struct Corner {
    bool inside = false;     // passes all rims and the stop
    std::size_t met = 0;     // interactions, as far as the ray came
    std::size_t passed = 0;  // of these within their rims before the first one outside
};

struct SearchColumns {
    RayColumns rays;
    TraceColumns traced;
};

SearchColumns& Columns() {
    thread_local SearchColumns columns;
    return columns;
}

class Search {
  public:
    Search(const InteractionList& list, const LightBundle& bundle, PassRegion& tally)
        : list_(list),
          bundle_(bundle),
          tally_(tally),
          cells_v_(bundle.mirror_symmetric() ? kCellsHalf : 2 * kCellsHalf) {}

    // The box of all cells that may pass, within `area`; where the bundle is symmetric in v both
    // start at v = 0.
    std::optional<Rect> Run(Rect area) {
        for (int zoom = 0; zoom < kMaxZooms; ++zoom) {
            TraceCorners(area);
            passing_ = BoxOf(area, 0, [&](int i, int j) { return At(i, j).inside; });
            // Where enough rays pass, they and not what is kept show the way (Tighten).
            if (!stalled()) break;
            const std::optional<Rect> kept = KeptCells(area);
            if (!kept) return std::nullopt;
            const double share = Share(*kept, area);
            area = *kept;
            if (share > 0.5) break;
        }
        return area;
    }

    // After Run, which may have kept cells far from any passing ray, on borders where rays die:
    // looks closely into those and zooms on the rays that pass, so that these fill the rectangle.
    Rect Tighten(Rect area) {
        for (int zoom = 0; zoom < kMaxZooms; ++zoom) {
            AddIslands(area);
            const Rect kept = Wider(passing_, area, 2.0);
            if (Share(kept, area) > kTight) break;
            area = kept;
            TraceCorners(area);
            passing_ = BoxOf(area, 0, [&](int i, int j) { return At(i, j).inside; });
        }
        return Wider(passing_, area, 1.0);
    }

    // After Run: next to no ray of the last grid passes.
    bool stalled() const { return CountPassing(list_.steps.size()) < kFew; }

    // The box of the passing corners of Run's last grid; where there are none it is inside out.
    const Rect& passing() const { return passing_; }

    // Zooms on the corners that come deepest, as long as there are enough of them.
    Rect Follow(Rect area) {
        for (int follow = 0; follow < kMaxFollows; ++follow) {
            TraceCorners(area);
            std::size_t depth = list_.steps.size();
            while (depth > 0 && CountPassing(depth) < kFew) --depth;
            if (depth == list_.steps.size()) break;
            Rect kept = BoxOf(area, 2, [&](int i, int j) { return At(i, j).passed >= depth; });
            if (Share(kept, area) > 0.5) {
                // They fill the grid, but the next surface is met by a few corners or between them.
                std::size_t deepest = depth;
                for (const Corner& corner : corners_) deepest = std::max(deepest, corner.passed);
                if (deepest == depth) break;
                kept = BoxOf(area, 2, [&](int i, int j) { return At(i, j).passed == deepest; });
                if (Share(kept, area) > 0.5) break;
            }
            area = kept;
        }
        return area;
    }

  private:
    static double Share(const Rect& part, const Rect& area) {
        return (part.u1 - part.u0) * (part.v1 - part.v0) /
               ((area.u1 - area.u0) * (area.v1 - area.v0));
    }

    int CountPassing(std::size_t depth) const {
        return static_cast<int>(
            std::count_if(corners_.begin(), corners_.end(),
                          [&](const Corner& corner) { return corner.passed >= depth; }));
    }

    void TraceCorners(const Rect& area) {
        places_.clear();
        for (int j = 0; j <= cells_v_; ++j) {
            for (int i = 0; i <= kCellsU; ++i) places_.push_back(PlaceOf(area, i, j));
        }
        Trace(places_, corners_);
    }

    // Cells that may pass, away from the rays that do: `passing_` comes to hold the rays that pass
    // there too.
    void AddIslands(const Rect& area) {
        // Next to rays that fill their rectangle, cells have been seen from near enough.
        const Rect near = Thin(area) ? passing_ : Wider(passing_, area, 1.5);
        const double du = (area.u1 - area.u0) / (kCellsU * kIslandCells);
        const double dv = (area.v1 - area.v0) / (cells_v_ * kIslandCells);
        places_.clear();
        for (int j = 0; j < cells_v_; ++j) {
            for (int i = 0; i < kCellsU; ++i) {
                const Vec2d place = PlaceOf(area, i, j);
                const bool away = place.x < near.u0 || place.x + kIslandCells * du > near.u1 ||
                                  place.y < near.v0 || place.y + kIslandCells * dv > near.v1;
                if (!away || !MayPass(i, j)) continue;
                for (int n = 0; n < kIslandCells * kIslandCells; ++n) {
                    places_.push_back(place + Vec2d(du * (n % kIslandCells + 0.5),
                                                    dv * (n / kIslandCells + 0.5)));
                }
            }
        }
        if (places_.empty()) return;
        std::vector<Corner> inner;
        Trace(places_, inner);
        for (std::size_t k = 0; k < inner.size(); ++k) {
            if (!inner[k].inside) continue;
            passing_.u0 = std::min(passing_.u0, places_[k].x);
            passing_.u1 = std::max(passing_.u1, places_[k].x);
            passing_.v0 = std::min(passing_.v0, places_[k].y);
            passing_.v1 = std::max(passing_.v1, places_[k].y);
        }
    }

    // Do the rays that pass leave much of their rectangle empty, as a slanted strip does?
    bool Thin(const Rect& area) const {
        const double whole = kCellsU * cells_v_ * Share(passing_, area);
        return CountPassing(list_.steps.size()) < 0.4 * whole;
    }

    Vec2d PlaceOf(const Rect& area, int i, int j) const {
        return {area.u0 + (area.u1 - area.u0) * i / kCellsU,
                area.v0 + (area.v1 - area.v0) * j / cells_v_};
    }

    void Trace(const std::vector<Vec2d>& places, std::vector<Corner>& corners) {
        rays_.Resize(places.size());
        for (std::size_t k = 0; k < places.size(); ++k) {
            const Ray ray = bundle_.AtFront(places[k].x, places[k].y);
            rays_.Set(k, ray.origin, ray.direction);
        }
        ColumnNeeds needs;
        needs.passage = false;
        needs.hits = true;
        TraceInColumns(list_, rays_, needs, traced_);
        corners.assign(places.size(), {});
        SetCorners(corners);
        tally_.rays += places.size();
    }

    // `part` by so many cells of `area` wider on each side, but within it.
    Rect Wider(const Rect& part, const Rect& area, double cells) const {
        const double du = cells * (area.u1 - area.u0) / kCellsU;
        const double dv = cells * (area.v1 - area.v0) / cells_v_;
        return {std::max(area.u0, part.u0 - du), std::min(area.u1, part.u1 + du),
                std::max(area.v0, part.v0 - dv), std::min(area.v1, part.v1 + dv)};
    }

    // Row by row, which the compiler turns into vector instructions.
    void SetCorners(std::vector<Corner>& corners) {
        const std::size_t count = corners.size();
        const auto steps = static_cast<std::int32_t>(list_.steps.size());
        met_.resize(count);
        for (std::size_t k = 0; k < count; ++k) {
            const auto fate = static_cast<RayFate>(traced_.fate[k]);
            const std::int32_t ended = traced_.ended_at[k];
            // A ray that is totally reflected has met the surface where that happens.
            met_[k] =
                ended == TraceColumns::kArrived ? steps : ended + (fate == RayFate::kTir ? 1 : 0);
        }
        passed_.assign(count, 0);
        for (std::int32_t s = 0; s < steps; ++s) {
            const float* const row =
                &traced_.rim_ratio2[static_cast<std::size_t>(s) * traced_.stride];
            for (std::size_t k = 0; k < count; ++k) {
                // Ints, so that the compiler need not branch.
                const int came = passed_[k] == s ? 1 : 0;
                const int met = met_[k] > s ? 1 : 0;
                const int within = row[k] <= 1.0F ? 1 : 0;
                passed_[k] += came & met & within;
            }
        }
        for (std::size_t k = 0; k < count; ++k) {
            corners[k].met = static_cast<std::size_t>(met_[k]);
            corners[k].passed = static_cast<std::size_t>(passed_[k]);
            corners[k].inside = traced_.fate[k] == static_cast<std::uint8_t>(RayFate::kArrived) &&
                                passed_[k] == steps && traced_.disorder[k] < 2;
            tally_.ray_surfaces += corners[k].met;
        }
    }

    // The box of the chosen corners, `margin` cells wider on each side.
    template <class Chosen>
    Rect BoxOf(const Rect& area, int margin, Chosen chosen) {
        int i0 = kCellsU, i1 = 0, j0 = cells_v_, j1 = 0;
        for (int j = 0; j <= cells_v_; ++j) {
            for (int i = 0; i <= kCellsU; ++i) {
                if (!chosen(i, j)) continue;
                i0 = std::min(i0, i);
                i1 = std::max(i1, i);
                j0 = std::min(j0, j);
                j1 = std::max(j1, j);
            }
        }
        const double du = (area.u1 - area.u0) / kCellsU;
        const double dv = (area.v1 - area.v0) / cells_v_;
        // A half plane's rectangle always starts at v = 0: the grid covers both halves.
        const double v0 =
            bundle_.mirror_symmetric() ? 0.0 : area.v0 + dv * std::max(0, j0 - margin);
        return Rect{area.u0 + du * std::max(0, i0 - margin),
                    area.u0 + du * std::min(kCellsU, i1 + margin), v0,
                    area.v0 + dv * std::min(cells_v_, j1 + margin)};
    }

    // The box of the cells that may pass, one cell wider on each side.
    std::optional<Rect> KeptCells(const Rect& area) {
        std::vector<std::uint8_t> kept(corners_.size());
        bool any = false;
        for (int j = 0; j < cells_v_; ++j) {
            for (int i = 0; i < kCellsU; ++i) {
                if (!MayPass(i, j)) continue;
                any = true;
                for (int corner = 0; corner < 4; ++corner) {
                    kept[Index(i + corner % 2, j + corner / 2)] = 1;
                }
            }
        }
        if (!any) return std::nullopt;
        return BoxOf(area, 1, [&](int i, int j) { return kept[Index(i, j)] != 0; });
    }

    bool MayPass(int i, int j) {
        const std::array<std::size_t, 4> corners = {Index(i, j), Index(i + 1, j), Index(i, j + 1),
                                                    Index(i + 1, j + 1)};
        std::size_t depth = std::numeric_limits<std::size_t>::max();
        std::size_t deepest = 0;
        for (const std::size_t k : corners) {
            if (corners_[k].inside) return true;
            depth = std::min(depth, corners_[k].met);
            deepest = std::max(deepest, corners_[k].met);
        }
        for (std::size_t step = 0; step < depth; ++step) {
            if (Outside(corners, step)) return false;
        }
        // All corners died at about the same place: nothing in between lives.
        const bool some_alive = deepest == list_.steps.size();
        return some_alive || depth < deepest;
    }

    bool Outside(const std::array<std::size_t, 4>& corners, std::size_t step) const {
        Vec2d lo(std::numeric_limits<double>::max());
        Vec2d hi(std::numeric_limits<double>::lowest());
        for (const std::size_t k : corners) {
            const Vec2d p(static_cast<double>(traced_.hit_x[step * traced_.stride + k]),
                          static_cast<double>(traced_.hit_y[step * traced_.stride + k]));
            lo = {std::min(lo.x, p.x), std::min(lo.y, p.y)};
            hi = {std::max(hi.x, p.x), std::max(hi.y, p.y)};
        }
        const Vec2d margin = (hi - lo) * 0.3;
        lo -= margin;
        hi += margin;
        const double dx = std::max({lo.x, -hi.x, 0.0});
        const double dy = std::max({lo.y, -hi.y, 0.0});
        const double rim = list_.steps[step].semi_diameter_mm;
        return dx * dx + dy * dy > rim * rim;
    }

    static std::size_t Index(int i, int j) {
        return static_cast<std::size_t>(j * (kCellsU + 1) + i);
    }
    Corner& At(int i, int j) { return corners_[Index(i, j)]; }

    const InteractionList& list_;
    const LightBundle& bundle_;
    PassRegion& tally_;
    int cells_v_;
    // Large, and used again by every search of the thread.
    RayColumns& rays_ = Columns().rays;
    TraceColumns& traced_ = Columns().traced;
    std::vector<Vec2d> places_;
    std::vector<Corner> corners_;
    std::vector<std::int32_t> met_, passed_;  // as in Corner
    Rect passing_;
};

// `area`, wider on the sides where the rays that pass reach its border, but within `whole`.
Rect WiderWhereFull(const Rect& area, const Rect& passing, const Rect& whole) {
    const double du = 0.25 * (area.u1 - area.u0);
    const double dv = 0.25 * (area.v1 - area.v0);
    Rect wider = area;
    constexpr double kTouch = 1e-6;  // of a step, against rounding
    if (passing.u0 <= area.u0 + kTouch * du) wider.u0 = std::max(whole.u0, area.u0 - du);
    if (passing.u1 >= area.u1 - kTouch * du) wider.u1 = std::min(whole.u1, area.u1 + du);
    if (passing.v0 <= area.v0 + kTouch * dv) wider.v0 = std::max(whole.v0, area.v0 - dv);
    if (passing.v1 >= area.v1 - kTouch * dv) wider.v1 = std::min(whole.v1, area.v1 + dv);
    return wider;
}

// For v >= 0 only where the bundle is symmetric.
std::optional<Rect> SearchRegion(const InteractionList& list, const LightBundle& bundle,
                                 PassRegion& tally) {
    const double half = bundle.half_width();
    const Rect whole{bundle.centre_u() - half, bundle.centre_u() + half,
                     bundle.mirror_symmetric() ? 0.0 : -half, half};
    Search search(list, bundle, tally);
    std::optional<Rect> found = search.Run(whole);
    if (!found) return found;
    if (!search.stalled()) return search.Tighten(*found);
    Rect followed = search.Follow(whole);
    found = search.Run(followed);
    // The corners that were followed may not have shown all of a region narrower than their steps.
    for (int widened = 0; widened < kMaxWidenings && found; ++widened) {
        const Rect wider = WiderWhereFull(followed, search.passing(), whole);
        if (wider == followed) break;
        followed = wider;
        found = search.Run(followed);
    }
    if (found && !search.stalled()) return search.Tighten(*found);
    return found;
}

}  // namespace

PassRegion FindPassRegion(const std::vector<InteractionList>& lists, const LightBundle& bundle) {
    PassRegion region;
    const std::optional<Rect> found = SearchRegion(lists[lists.size() / 2], bundle, region);
    if (!found) return region;
    region.rect = found;
    if (bundle.mirror_symmetric()) region.rect->v0 = -found->v1;
    if (lists.size() > 1) {
        // Dispersion moves the region's edges by a little.
        constexpr double kWiden = 0.04;
        Rect& rect = *region.rect;
        const double du = kWiden * (rect.u1 - rect.u0);
        const double dv = kWiden * (rect.v1 - rect.v0);
        rect = {rect.u0 - du, rect.u1 + du, rect.v0 - dv, rect.v1 + dv};
    }
    return region;
}

}  // namespace flare
