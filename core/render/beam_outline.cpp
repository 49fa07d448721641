// SPDX-License-Identifier: Apache-2.0
#include "core/render/beam_outline.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/tracing/chief_ray.h"
#include "core/wave/coverage.h"

namespace flare {
namespace {

constexpr int kDirections = 256;
constexpr int kRoughDirections = 48;
constexpr int kSearch = 64;  // rays a side, where the chief ray does not pass
constexpr int kDead = -1;    // what bounds the beam where rays miss a surface

// How far outside (positive) or inside all apertures a ray is, and which of them is the tightest.
struct Clearance {
    double mm = 1e9;
    int aperture = kDead;
};

class Apertures {
  public:
    Apertures(const Lens& lens, const LightBundle& bundle, const CanonicalPose& pose,
              const Iris& iris, double wavelength_nm)
        : bundle_(bundle), pose_(pose), iris_(iris), list_(WriteOut(lens, {}, wavelength_nm)) {}

    Clearance At(Vec2d p) const {
        RayRecord record;
        TraceOptions options;
        options.clip = false;
        const TraceResult result = TraceRay(list_, bundle_.At(p.x, p.y), options, &record);
        Clearance worst;
        if (result.fate != RayFate::kArrived || result.out_of_order_inside) return worst;
        worst.mm = -1e300;
        for (std::size_t i = 0; i < list_.steps.size(); ++i) {
            const Interaction& step = list_.steps[i];
            if (step.kind == InteractionKind::kStop) continue;
            Tighten(worst, (std::sqrt(record.rim_ratio2[i]) - 1.0) * step.semi_diameter_mm,
                    static_cast<int>(i));
        }
        const Vec2d at_stop = pose_.LensSpace(record.stop_mm.front());
        for (int k = 0; k < iris_.edge_count(); ++k) {
            Tighten(worst, iris_.EdgeDistance(k, at_stop), 1000 + k);
        }
        return worst;
    }

  private:
    static void Tighten(Clearance& worst, double mm, int aperture) {
        if (mm > worst.mm) worst = {mm, aperture};
    }

    const LightBundle& bundle_;
    const CanonicalPose& pose_;
    const Iris& iris_;
    InteractionList list_;
};

struct EdgePoint {
    double angle = 0.0, radius = 0.0;
    int aperture = kDead;
};

// Looks for the edge from `middle` on.
class EdgeSearch {
  public:
    EdgeSearch(const Apertures& apertures, Vec2d middle, double reach)
        : apertures_(apertures), middle_(middle), reach_(reach) {}

    Vec2d Place(double angle, double radius) const {
        return middle_ + Vec2d(std::cos(angle), std::sin(angle)) * radius;
    }

    // The first crossing, from inside: marched over, then closed in on (Illinois).
    EdgePoint At(double angle) const {
        constexpr int kSteps = 24;
        double lo = 0.0, hi = 0.0;
        double f_lo = apertures_.At(middle_).mm;
        Clearance outside;
        for (int i = 1; i <= kSteps; ++i) {
            hi = reach_ * i / kSteps;
            outside = apertures_.At(Place(angle, hi));
            if (outside.mm > 0.0) break;
            lo = hi;
            f_lo = outside.mm;
        }
        double f_hi = std::max(outside.mm, 0.0);
        // The aperture that bounds the beam is the tightest one at the edge, not farther out.
        EdgePoint edge{angle, hi, outside.aperture};
        int side = 0;
        for (int i = 0; i < 60 && hi - lo > 1e-12 * reach_; ++i) {
            const bool dead = outside.aperture == kDead;
            const double at =
                dead || i > 30 ? 0.5 * (lo + hi) : (lo * f_hi - hi * f_lo) / (f_hi - f_lo);
            const Clearance c = apertures_.At(Place(angle, at));
            const int past = c.mm > 0.0 ? 1 : -1;
            if (past > 0) {
                hi = at;
                f_hi = c.mm;
                outside = c;
                if (side == past) f_lo *= 0.5;
            } else {
                lo = at;
                f_lo = c.mm;
                if (side == past) f_hi *= 0.5;
            }
            side = past;
            edge.radius = at;
            edge.aperture = outside.aperture == kDead ? kDead : c.aperture;
            if (std::abs(c.mm) < 1e-11) break;
        }
        return edge;
    }

    // Where the edge changes from `a`'s aperture to another one, between a and b: the last point
    // of the first.
    EdgePoint Corner(EdgePoint a, EdgePoint b) const {
        for (int i = 0; i < 36; ++i) {
            const EdgePoint middle = At(0.5 * (a.angle + b.angle));
            (middle.aperture == a.aperture ? a : b) = middle;
        }
        return a;
    }

  private:
    const Apertures& apertures_;
    Vec2d middle_;
    double reach_;
};

std::vector<EdgePoint> Around(const EdgeSearch& search, int directions, ThreadPool& threads) {
    std::vector<EdgePoint> edge(static_cast<std::size_t>(directions));
    threads.For(directions, [&](int i) {
        edge[static_cast<std::size_t>(i)] = search.At(2.0 * kPi * i / directions);
    });
    return edge;
}

Vec2d Centroid(const std::vector<Vec2d>& loop) {
    Vec2d sum(0.0, 0.0);
    double area = 0.0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const Vec2d a = loop[i] - loop[0], b = loop[(i + 1) % loop.size()] - loop[0];
        const double cross = a.x * b.y - a.y * b.x;
        sum += (a + b) * (cross / 3.0);
        area += cross;
    }
    return area != 0.0 ? loop[0] + sum / area : loop[0];
}

// A place that passes: the chief ray's, or the middlemost of a search.
std::optional<Vec2d> AnyPlace(const Lens& lens, const LightBundle& bundle,
                              const Apertures& apertures, double wavelength_nm,
                              ThreadPool& threads) {
    if (const std::optional<ChiefRay> chief = FindChiefRay(lens, bundle, wavelength_nm)) {
        if (apertures.At({chief->u, chief->v}).mm < 0.0) return Vec2d(chief->u, chief->v);
    }
    std::vector<Clearance> grid(kSearch * kSearch);
    const auto place = [&](int k) {
        return Vec2d(
            bundle.centre_u() + bundle.half_width() * ((k % kSearch + 0.5) * 2.0 / kSearch - 1.0),
            bundle.half_width() * ((k / kSearch + 0.5) * 2.0 / kSearch - 1.0));
    };
    threads.For(kSearch, [&](int row) {
        for (int k = row * kSearch; k < (row + 1) * kSearch; ++k) {
            grid[static_cast<std::size_t>(k)] = apertures.At(place(k));
        }
    });
    const auto best = std::min_element(grid.begin(), grid.end(),
                                       [](const auto& a, const auto& b) { return a.mm < b.mm; });
    if (best->mm >= 0.0) return std::nullopt;
    return place(static_cast<int>(best - grid.begin()));
}

// Cuts the points around into smooth pieces.
EdgeLoop Pieces(const EdgeSearch& search, const std::vector<EdgePoint>& edge) {
    const std::size_t n = edge.size();
    const auto place = [&](const EdgePoint& p) { return search.Place(p.angle, p.radius); };
    std::size_t first = n;  // the first point behind a corner
    for (std::size_t i = 0; i < n && first == n; ++i) {
        if (edge[i].aperture != edge[(i + n - 1) % n].aperture) first = i;
    }
    EdgeLoop loop;
    if (first == n) {
        loop.smooth = true;
        EdgePiece& piece = loop.pieces.emplace_back();
        for (std::size_t i = 0; i <= n; ++i) piece.push_back(place(edge[i % n]));
        return loop;
    }
    EdgePiece piece;
    for (std::size_t i = 0; i <= n; ++i) {
        const EdgePoint& point = edge[(first + i) % n];
        EdgePoint before = edge[(first + i + n - 1) % n];
        if (before.angle > point.angle) before.angle -= 2.0 * kPi;
        if (before.aperture != point.aperture) {
            const Vec2d corner = place(search.Corner(before, point));
            if (!piece.empty()) {
                piece.push_back(corner);
                loop.pieces.push_back(piece);
            }
            piece = {corner};
        }
        if (i < n) piece.push_back(place(point));
    }
    loop.pieces.back().back() = loop.pieces.front().front();
    return loop;
}

// Points so close that their direction is rounding.
void DropTinySides(EdgeLoop& loop, double size) {
    for (EdgePiece& piece : loop.pieces) {
        EdgePiece kept = {piece.front()};
        for (std::size_t i = 1; i < piece.size(); ++i) {
            const bool last = i + 1 == piece.size();
            if ((piece[i] - kept.back()).length() > 1e-5 * size) {
                kept.push_back(piece[i]);
            } else if (last && kept.size() > 1) {
                kept.back() = piece[i];
            } else if (last) {
                kept.push_back(piece[i]);
            }
        }
        piece = kept;
    }
}

}  // namespace

std::optional<BeamOutline> FindBeamOutline(const Lens& lens, const LightBundle& bundle,
                                           const CanonicalPose& pose, const Iris& iris,
                                           double wavelength_nm, ThreadPool& threads) {
    const Apertures apertures(lens, bundle, pose, iris, wavelength_nm);
    std::optional<Vec2d> start = AnyPlace(lens, bundle, apertures, wavelength_nm, threads);
    if (!start) return std::nullopt;
    double reach = 2.0 * bundle.half_width() + (*start - Vec2d(bundle.centre_u(), 0.0)).length();

    // From the beam's own middle its edge is seen most evenly.
    const EdgeSearch rough(apertures, *start, reach);
    Loop loop;
    double farthest = 0.0;
    for (const EdgePoint& p : Around(rough, kRoughDirections, threads)) {
        loop.push_back(rough.Place(p.angle, p.radius));
        farthest = std::max(farthest, p.radius);
    }
    const Vec2d middle = Centroid(loop);
    if (apertures.At(middle).mm < 0.0) start = middle;
    reach = std::min(reach, 2.5 * farthest);

    const EdgeSearch search(apertures, *start, reach);
    const std::vector<EdgePoint> edge = Around(search, kDirections, threads);
    BeamOutline beam;
    beam.middle = *start;
    beam.edge = Pieces(search, edge);
    DropTinySides(beam.edge, farthest);
    Loop outline;
    for (const EdgePiece& piece : beam.edge.pieces) {
        outline.insert(outline.end(), piece.begin(), piece.end() - 1);
    }
    beam.area_mm2 = SignedArea(outline);
    if (!(beam.area_mm2 > 0.0)) return std::nullopt;
    return beam;
}

double BeamTransmittance(const Lens& lens, const LightBundle& bundle, const BeamOutline& beam,
                         double wavelength_nm) {
    const InteractionList list = WriteOut(lens, {}, wavelength_nm);
    TraceOptions options;
    options.clip = false;
    RayRecord record;
    std::vector<Vec2d> edge;
    for (const EdgePiece& piece : beam.edge.pieces) {
        edge.insert(edge.end(), piece.begin(), piece.end() - 1);
    }
    // Two rings of equal areas, each sampled in triangles from the middle to parts of the edge.
    constexpr std::size_t kParts = 8;
    double sum = 0.0, area = 0.0;
    for (std::size_t part = 0; part < kParts; ++part) {
        const std::size_t from = edge.size() * part / kParts;
        const std::size_t to = edge.size() * (part + 1) / kParts;
        double share = 0.0;
        for (std::size_t i = from; i < to; ++i) {
            const Vec2d a = edge[i] - beam.middle;
            const Vec2d b = edge[(i + 1) % edge.size()] - beam.middle;
            share += 0.5 * (a.x * b.y - a.y * b.x);
        }
        const Vec2d out = edge[(from + to) / 2 % edge.size()] - beam.middle;
        for (const double ring : {0.25, 0.75}) {
            const Vec2d p = beam.middle + out * std::sqrt(ring);
            const TraceResult ray = TraceRay(list, bundle.At(p.x, p.y), options, &record);
            if (ray.fate != RayFate::kArrived) continue;
            sum += share * PathWeight(lens, list, record) * bundle.FluxDensity(p.x, p.y);
            area += share;
        }
    }
    return area > 0.0 ? sum / area : 0.0;
}

}  // namespace flare
