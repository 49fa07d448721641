// SPDX-License-Identifier: Apache-2.0
//
// A coarse grid over the front is traced without clipping. A cell may hold passing rays unless, at
// some interaction, the box around its corners' hits, widened for curvature, lies outside that rim.
// The search zooms on the cells that may pass until they fill the grid or nothing is left. Boxes of
// hit points, not rim ratios, since a cell larger than the pass region has every corner outside.
//
// Where rays die at different surfaces nothing can be said of the rays between them, and so a
// search may stall on cells that lie on such borders and hold no passing ray at all (a fisheye's
// ghosts, whose regions are a hundredth of its front). Those cells are then searched one by one,
// ever finer.
#include "core/mesh/pass_region.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace flare {
namespace {

constexpr int kCellsU = 32;
constexpr int kCellsV = 16;  // the half v >= 0; the other half is its mirror image
constexpr int kMaxZooms = 8;
constexpr int kCuts = 4;   // a cell that is searched is cut into 4 x 4
constexpr int kDepth = 2;  // ... twice
constexpr double kSparse =
    0.005;  // share of passing corners below which a stalled search does that

struct Corner {
    bool inside = false;      // passes all rims and the stop
    std::vector<Vec2d> hits;  // as far as the ray came
};

using Corners = std::array<const Corner*, 4>;

class Search {
  public:
    Search(const InteractionList& list, const LightBundle& bundle, PassRegion& tally)
        : list_(list), bundle_(bundle), tally_(tally) {}

    std::optional<Rect> Run() {
        Rect area{bundle_.centre_u() - bundle_.half_width(),
                  bundle_.centre_u() + bundle_.half_width(), 0.0, bundle_.half_width()};
        for (int zoom = 0; zoom < kMaxZooms; ++zoom) {
            TraceCorners(area);
            const std::optional<Rect> kept = KeptCells(area);
            if (!kept) return std::nullopt;
            const double share = (kept->u1 - kept->u0) * (kept->v1 - kept->v0) /
                                 ((area.u1 - area.u0) * (area.v1 - area.v0));
            area = *kept;
            if (share <= 0.5) continue;
            if (searched_ || PassingShare() > kSparse) break;
            searched_ = true;  // from here on cells are searched, not judged by their corners alone
        }
        return Rect{area.u0, area.u1, -area.v1, area.v1};
    }

  private:
    Corner Trace(double u, double v) {
        TraceOptions options;
        options.clip = false;
        options.record_points = true;
        const TraceResult result = TraceRay(list_, bundle_.At(u, v), options, &record_);
        Corner corner;
        corner.hits.reserve(record_.points.size());
        for (const Vec3d& p : record_.points) corner.hits.emplace_back(p.x, p.y);
        // A ray that misses the first surface has no record at all.
        const bool inside_rims = std::all_of(record_.rim_ratio2.begin(), record_.rim_ratio2.end(),
                                             [](double ratio2) { return ratio2 <= 1.0; });
        corner.inside =
            result.fate == RayFate::kArrived && inside_rims && !result.out_of_order_inside;
        ++tally_.rays;
        tally_.ray_surfaces += record_.points.size();
        return corner;
    }

    void TraceCorners(const Rect& area) {
        corners_.clear();
        for (int j = 0; j <= kCellsV; ++j) {
            for (int i = 0; i <= kCellsU; ++i) {
                corners_.push_back(Trace(area.u0 + (area.u1 - area.u0) * i / kCellsU,
                                         area.v0 + (area.v1 - area.v0) * j / kCellsV));
            }
        }
    }

    double PassingShare() const {
        const auto passing = std::count_if(corners_.begin(), corners_.end(),
                                           [](const Corner& corner) { return corner.inside; });
        return static_cast<double>(passing) / static_cast<double>(corners_.size());
    }

    // Looks for a passing ray in a cell, `depth` times finer. What stays open in the finest cells
    // is taken to pass only if rays reach the sensor on all sides of it.
    bool Holds(const Rect& cell, int depth) {
        const double du = (cell.u1 - cell.u0) / kCuts;
        const double dv = (cell.v1 - cell.v0) / kCuts;
        std::vector<Corner> corners;
        for (int j = 0; j <= kCuts; ++j) {
            for (int i = 0; i <= kCuts; ++i) {
                corners.push_back(Trace(cell.u0 + i * du, cell.v0 + j * dv));
                if (corners.back().inside) return true;
            }
        }
        for (int j = 0; j < kCuts; ++j) {
            for (int i = 0; i < kCuts; ++i) {
                const Corner* const at = &corners[static_cast<std::size_t>(j * (kCuts + 1) + i)];
                const Corners around = {at, at + 1, at + kCuts + 1, at + kCuts + 2};
                if (!MayPass(around)) continue;
                const bool all_arrive = std::all_of(
                    around.begin(), around.end(),
                    [&](const Corner* c) { return c->hits.size() == list_.steps.size(); });
                if (all_arrive) return true;
                const Rect part{cell.u0 + i * du, cell.u0 + (i + 1) * du, cell.v0 + j * dv,
                                cell.v0 + (j + 1) * dv};
                if (depth > 1 && Holds(part, depth - 1)) return true;
            }
        }
        return false;
    }

    // The box of the cells that may pass, one cell wider on each side.
    std::optional<Rect> KeptCells(const Rect& area) {
        const double du = (area.u1 - area.u0) / kCellsU;
        const double dv = (area.v1 - area.v0) / kCellsV;
        int i0 = kCellsU, i1 = -1, j0 = kCellsV, j1 = -1;
        for (int j = 0; j < kCellsV; ++j) {
            for (int i = 0; i < kCellsU; ++i) {
                if (!MayPass({&At(i, j), &At(i + 1, j), &At(i, j + 1), &At(i + 1, j + 1)}))
                    continue;
                const Rect cell{area.u0 + du * i, area.u0 + du * (i + 1), area.v0 + dv * j,
                                area.v0 + dv * (j + 1)};
                if (searched_ && !Holds(cell, kDepth)) continue;
                i0 = std::min(i0, i);
                i1 = std::max(i1, i);
                j0 = std::min(j0, j);
                j1 = std::max(j1, j);
            }
        }
        if (i1 < 0) return std::nullopt;
        // The half plane's rectangle always starts at v = 0: the region is symmetric and the grid
        // covers both halves.
        return Rect{area.u0 + du * std::max(0, i0 - 1), area.u0 + du * std::min(kCellsU, i1 + 2),
                    0.0, area.v0 + dv * std::min(kCellsV, j1 + 2)};
    }

    bool MayPass(const Corners& corners) const {
        std::size_t depth = std::numeric_limits<std::size_t>::max();
        std::size_t deepest = 0;
        for (const Corner* corner : corners) {
            if (corner->inside) return true;
            depth = std::min(depth, corner->hits.size());
            deepest = std::max(deepest, corner->hits.size());
        }
        for (std::size_t step = 0; step < depth; ++step) {
            if (Outside(corners, step)) return false;
        }
        // All corners died at about the same place: nothing in between lives.
        const bool some_alive = deepest == list_.steps.size();
        return some_alive || depth < deepest;
    }

    bool Outside(const Corners& corners, std::size_t step) const {
        Vec2d lo(std::numeric_limits<double>::max());
        Vec2d hi(std::numeric_limits<double>::lowest());
        for (const Corner* corner : corners) {
            const Vec2d& p = corner->hits[step];
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

    Corner& At(int i, int j) { return corners_[static_cast<std::size_t>(j * (kCellsU + 1) + i)]; }

    const InteractionList& list_;
    const LightBundle& bundle_;
    PassRegion& tally_;
    std::vector<Corner> corners_;
    bool searched_ = false;
    RayRecord record_;
};

}  // namespace

PassRegion FindPassRegion(const std::vector<InteractionList>& lists, const LightBundle& bundle) {
    PassRegion region;
    for (const InteractionList& list : lists) {
        const std::optional<Rect> rect = Search(list, bundle, region).Run();
        if (!rect) continue;
        if (!region.rect) {
            region.rect = rect;
            continue;
        }
        region.rect->u0 = std::min(region.rect->u0, rect->u0);
        region.rect->u1 = std::max(region.rect->u1, rect->u1);
        region.rect->v0 = std::min(region.rect->v0, rect->v0);
        region.rect->v1 = std::max(region.rect->v1, rect->v1);
    }
    return region;
}

}  // namespace flare
