// SPDX-License-Identifier: Apache-2.0
#include "core/render/fringe_plan.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/tracing/ghost_ringing.h"
#include "core/tracing/paraxial_ghost.h"
#include "core/tracing/stop_jacobian.h"
#include "core/wave/edge_profile.h"

namespace flare {
namespace {

constexpr double kWavelength_nm = 550.0;
// How far a profile goes, in t: fringes of one wavelength go on where those of a band have faded.
constexpr double kDark_t = 3.5, kLit_t = 5.5, kLitOfOneWavelength_t = 16.0;

constexpr double kStep_t = 0.03;

double Fade(double x, double none, double all) {
    const double s = std::clamp((x - none) / (all - none), 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s);
}

double Median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

// Where in a bundle's plane the iris lets rays pass, and a little more.
struct PupilBox {
    Vec2d lo{1e300, 1e300}, hi{-1e300, -1e300};
    int inside = 0;  // of the places that were looked at
    double nearest = 1e300;
    Vec2d nearest_place{0.0, 0.0};

    // A ray whose largest distance from the axis at the stop is `radius`, in radii of the iris.
    void Look(Vec2d place, double radius) {
        constexpr double kRoom = 1.5;
        if (radius < nearest) {
            nearest = radius;
            nearest_place = place;
        }
        if (radius > kRoom) return;
        ++inside;
        lo = {std::min(lo.x, place.x), std::min(lo.y, place.y)};
        hi = {std::max(hi.x, place.x), std::max(hi.y, place.y)};
    }
    // The edge may lie between two places.
    void Grow(Vec2d by) {
        if (inside == 0) lo = hi = nearest_place;
        lo -= by;
        hi += by;
    }
};

PupilBox BoxOfVertices(const GhostMesh& mesh, double radius_mm) {
    PupilBox box;
    const MeshGrid& grid = mesh.grids.front();
    const MeshNode& node = grid.nodes[grid.nodes.size() / 2];
    const auto stored = static_cast<std::size_t>(mesh.stored_count());
    for (int j = 0; j < grid.nv; ++j) {
        for (int i = 0; i < grid.nu; ++i) {
            const std::size_t vertex = grid.Vertex(i, j);
            if (grid.alive[vertex] == 0) continue;
            double radius = 0.0;
            for (int c = 0; c < mesh.stop_crossings; ++c) {
                const float* const at =
                    &node.fields[vertex * stored + static_cast<std::size_t>(mesh.stop_field(c))];
                radius = std::max(radius, static_cast<double>(std::hypot(at[0], at[1])));
            }
            box.Look({grid.u0 + i * grid.du, grid.v0 + j * grid.dv}, radius / radius_mm);
        }
    }
    box.Grow(Vec2d(grid.du, grid.dv) * 0.5);
    return box;
}

template <class Use>
void ForLattice(const PupilBox& box, int side, Use use) {
    for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
            use(Vec2d(box.lo.x + (box.hi.x - box.lo.x) * i / (side - 1),
                      box.lo.y + (box.hi.y - box.lo.y) * j / (side - 1)));
        }
    }
}

// A closer look into a box that few vertices stand in.
PupilBox Closer(const PupilBox& box, const InteractionList& list, const LightBundle& bundle,
                double radius_mm) {
    constexpr int kSide = 9;
    PupilBox out;
    TraceOptions options;
    options.clip = false;
    RayRecord record;
    ForLattice(box, kSide, [&](Vec2d place) {
        if (TraceRay(list, bundle.At(place.x, place.y), options, &record).fate != RayFate::kArrived)
            return;
        double radius = 0.0;
        for (const Vec2d& stop : record.stop_mm) radius = std::max(radius, stop.length());
        out.Look(place, radius / radius_mm);
    });
    out.Grow((box.hi - box.lo) * (0.5 / (kSide - 1)));
    return out;
}

std::vector<Vec2d> PupilPlaces(const GhostMesh& mesh, const InteractionList& list,
                               const LightBundle& bundle, double radius_mm) {
    constexpr int kSide = 5;
    constexpr int kEnough = 12;
    std::vector<Vec2d> places;
    if (mesh.grids.empty()) return places;
    PupilBox box = BoxOfVertices(mesh, radius_mm);
    for (int look = 0; look < 3 && box.inside < kEnough && box.nearest < 1e299; ++look)
        box = Closer(box, list, bundle, radius_mm);
    if (box.nearest > 1e299) return places;
    ForLattice(box, kSide, [&](Vec2d place) { places.push_back(place); });
    return places;
}

// Least squares of values over the powers 1, x, y, x^2, x y, y^2; a little is taken off the higher
// ones so that few points will do.
class PolynomialFit {
  public:
    void Add(Vec2d p, const std::array<double, 4>& values) {
        const std::array<double, 6> powers = {1.0, p.x, p.y, p.x * p.x, p.x * p.y, p.y * p.y};
        for (std::size_t i = 0; i < 6; ++i) {
            for (std::size_t k = 0; k < 6; ++k) rows_[i][k] += powers[i] * powers[k];
            for (std::size_t k = 0; k < 4; ++k) rows_[i][6 + k] += powers[i] * values[k];
        }
    }

    std::array<std::array<double, 4>, 6> Solve() {
        for (std::size_t i = 1; i < 6; ++i) rows_[i][i] += 1e-4 * rows_[0][0];
        for (std::size_t i = 0; i < 6; ++i) {
            for (std::size_t r = 0; r < 6; ++r) {
                if (r == i) continue;
                const double factor = rows_[r][i] / rows_[i][i];
                for (std::size_t k = i; k < 10; ++k) rows_[r][k] -= factor * rows_[i][k];
            }
        }
        std::array<std::array<double, 4>, 6> out{};
        for (std::size_t i = 0; i < 6; ++i) {
            for (std::size_t k = 0; k < 4; ++k) out[i][k] = rows_[i][6 + k] / rows_[i][i];
        }
        return out;
    }

  private:
    std::array<std::array<double, 10>, 6> rows_{};
};

class CrossingPlanner {
  public:
    CrossingPlanner(const Iris& iris, const PictureMap& map, double source_rad)
        : iris_(iris), map_(map), source_rad_(source_rad) {}

    struct Outcome {
        GhostFringes::Crossing crossing;
        RingingFacts facts;
        double source_t = 0.0;
    };

    // `a1`: of the front in first order, height in the stop for height at the front.
    Outcome Plan(const std::vector<StopJacobian>& rays, double a1) {
        Outcome out;
        out.crossing.unit_mm = iris_.outer_radius();
        out.facts.reason = "not_traced";
        constexpr std::size_t kFewest = 6;
        if (rays.size() < kFewest) return out;
        Measure(rays);
        if (distances_.size() < kFewest) return out;
        SetDistances(rays, out.crossing);
        Decide(a1, out);
        return out;
    }

  private:
    Vec2d Camera(Vec2d v) const { return map_.stop_per_x * v.x + map_.stop_per_y * v.y; }
    Vec2d Canonical(Vec2d v) const { return {map_.stop_per_x.dot(v), map_.stop_per_y.dot(v)}; }
    Vec2d Picture(Vec2d v) const { return map_.px_per_x * v.x + map_.px_per_y * v.y; }

    // Distances across the edge, towards the axis, and how far apart places in the stop land.
    void Measure(const std::vector<StopJacobian>& rays) {
        for (const StopJacobian& ray : rays) {
            const double radius = ray.stop_mm.length();
            if (radius < 0.5 * iris_.outer_radius() || radius > 1.5 * iris_.outer_radius())
                continue;
            const Vec2d n = ray.stop_mm / radius;
            const std::optional<double> z = ray.Distance(n);
            if (!z || !std::isfinite(*z)) continue;
            distances_.push_back(std::abs(*z));
            scales_.push_back(Picture(ray.sensor_per_stop * n).length());
        }
    }

    void SetDistances(const std::vector<StopJacobian>& rays, GhostFringes::Crossing& crossing) {
        constexpr double kSpread = 4.0;
        PolynomialFit fit;
        for (const StopJacobian& ray : rays) {
            const Vec2d place = Camera(ray.stop_mm) / crossing.unit_mm;
            if (place.length() > 1.6) continue;
            if (ray.sensor_per_angle.determinant() == 0.0) continue;
            // B^-1 m, in camera coordinates.
            const Matrix2 angle = ray.sensor_per_angle.Inverse();
            const auto bend = [&](Vec2d along) {
                return Camera(angle * (ray.sensor_per_stop * Canonical(along)));
            };
            const Vec2d x = bend({1.0, 0.0});
            const Vec2d y = bend({0.0, 1.0});
            fit.Add(place, {x.x, y.x, x.y, y.y});
        }
        crossing.bend = fit.Solve();
        crossing.usual_mm = Median(distances_);
        const double most = *std::max_element(distances_.begin(), distances_.end());
        crossing.most_mm = std::min(most * 1.2, kSpread * crossing.usual_mm);
        crossing.least_mm = 1e-3 * crossing.usual_mm;
    }

    void Decide(double a1, Outcome& out) {
        RingingFacts& facts = out.facts;
        const double lambda = kWavelength_nm * 1e-6;
        const double z = out.crossing.usual_mm;
        const double a = iris_.outer_radius();
        facts.z_mm = z;
        facts.fresnel_number = z > 0.0 ? a * a / (lambda * z) : 1e300;
        const double fringe_mm = kFirstFringe * std::sqrt(0.5 * lambda * z);
        facts.fringe_px = fringe_mm * Median(scales_);
        const double disc_mm = source_rad_ * z / std::max(std::abs(a1), 1e-9);
        out.crossing.fringe_px = facts.fringe_px;
        out.source_t = 0.5 * disc_mm * std::sqrt(2.0 / (lambda * std::max(z, 1e-9)));

        const bool round = iris_.edge_count() == 1;
        const double pattern =
            round ? Fade(facts.fresnel_number, 0.12, 0.25) : Fade(facts.fresnel_number, 4.0, 8.0);
        const double pixel = Fade(facts.fringe_px, 0.5, 1.0);
        const double source = 1.0 - Fade(disc_mm, 0.5 * fringe_mm, fringe_mm);
        facts.weight = pattern * pixel * source;
        const bool profile = !round || facts.fresnel_number > kManyFresnelZones;
        facts.model = profile ? "edge_profile" : "propagation";
        facts.reason = "visible";
        if (facts.weight > 0.0) return;
        facts.model = "geometric";
        facts.reason = pixel == 0.0 ? "pixel" : source == 0.0 ? "source" : "focus";
    }

    const Iris& iris_;
    const PictureMap& map_;
    double source_rad_;
    std::vector<double> distances_, scales_;
};

// How far inside an edge, in t.
double LitReach(const Iris& iris, bool spectral, double wavelength_mm,
                const GhostFringes::Crossing& crossing) {
    if (crossing.disc_fresnel_number > 0.0)
        return std::sqrt(2.0 * crossing.disc_fresnel_number);  // to the middle
    const double middle_t =
        iris.inner_radius() * std::sqrt(2.0 / (wavelength_mm * crossing.usual_mm));
    return std::min(spectral ? kLitOfOneWavelength_t : kLit_t, middle_t);
}

// How far the fringes go on both sides of the iris's edges.
void SetReach(const Iris& iris, bool spectral, GhostFringes& fringes) {
    double dark_mm = 0.0;
    double lit_mm = 0.0;
    fringes.dark_t = kDark_t;
    fringes.step_t = kStep_t;
    for (const GhostFringes::Crossing& crossing : fringes.crossings) {
        if (!crossing.rings) continue;
        const double mm_per_t = std::sqrt(0.5 * fringes.wavelength_mm * crossing.most_mm);
        dark_mm = std::max(dark_mm, kDark_t * mm_per_t);
        const double lit_t = LitReach(iris, spectral, fringes.wavelength_mm, crossing);
        lit_mm = std::max(lit_mm, lit_t * mm_per_t);
        fringes.lit_t = std::max(fringes.lit_t, lit_t);
        if (crossing.disc_fresnel_number > 0.0) fringes.step_t = 2.0 * kStep_t;
    }
    fringes.entries =
        1 + static_cast<int>(std::ceil((fringes.dark_t + fringes.lit_t) / fringes.step_t));
    fringes.iris = iris.Widened(dark_mm, lit_mm);
}

}  // namespace

void JoinRinging(const RingingFacts& one, RingingFacts& all) {
    if (all.reason.empty() || one.weight > all.weight ||
        (one.weight == all.weight && one.fringe_px > all.fringe_px)) {
        all = one;
    }
}

FringePlan PlanFringes(const Lens& lens, const GhostMesh& mesh, const PlacedLight& light,
                       const Iris& iris, const PictureMap& map, bool spectral) {
    FringePlan plan;
    if (iris.picture() != nullptr) {
        plan.facts.reason = "mask";
        return plan;
    }
    const InteractionList list = WriteOut(lens, mesh.sequence, kWavelength_nm);
    const LightBundle bundle = BundleOf(lens, light);
    const std::vector<Vec2d> places = PupilPlaces(mesh, list, bundle, iris.outer_radius());
    if (places.empty()) return plan;
    const ParaxialPath path = ParaxialPathOf(list);
    auto fringes = std::make_shared<GhostFringes>(iris);
    fringes->wavelength_mm = kWavelength_nm * 1e-6;
    for (int c = 0; c < mesh.stop_crossings; ++c) {
        const auto n = static_cast<std::size_t>(c);
        const StopPassage passage(list, n);
        std::vector<StopJacobian> rays;
        for (const Vec2d& place : places) {
            if (const auto ray = passage.At(bundle, place.x, place.y, 1.6 * iris.outer_radius()))
                rays.push_back(*ray);
        }
        CrossingPlanner planner(iris, map, light.angular_diameter_rad);
        CrossingPlanner::Outcome outcome = planner.Plan(rays, path.front_to_stop[n].a);
        outcome.crossing.rings = outcome.facts.weight > 0.0;
        outcome.crossing.weight = outcome.facts.weight;
        outcome.crossing.source_t = outcome.source_t;
        if (outcome.facts.model == "propagation")
            outcome.crossing.disc_fresnel_number = outcome.facts.fresnel_number;
        fringes->crossings.push_back(outcome.crossing);
        JoinRinging(outcome.facts, plan.facts);
        if (!outcome.crossing.rings) continue;
        plan.fringes = fringes;
    }
    if (plan.fringes) SetReach(iris, spectral, *plan.fringes);
    return plan;
}

void FillTables(const Iris& iris, const GhostLight& ghost, bool spectral, GhostFringes& fringes) {
    fringes.bands = static_cast<int>(ghost.bands.size());
    fringes.tables.clear();
    const double lambda_nm = fringes.wavelength_mm * 1e6;
    const auto entries = static_cast<std::size_t>(fringes.entries);
    for (const GhostFringes::Crossing& crossing : fringes.crossings) {
        for (std::size_t b = 0; b < ghost.bands.size(); ++b) {
            const std::size_t start = fringes.tables.size();
            fringes.tables.resize(start + entries, 0.0F);
            if (!crossing.rings) continue;
            EdgeProfileSpec spec;
            const double here = ghost.bands[b].wavelength_nm;
            spec.wavelength_ratio = lambda_nm / here;
            if (!spectral) {
                const double before = ghost.bands[b > 0 ? b - 1 : 0].wavelength_nm;
                const double after =
                    ghost.bands[std::min(b + 1, ghost.bands.size() - 1)].wavelength_nm;
                const double steps = b > 0 && b + 1 < ghost.bands.size() ? 2.0 : 1.0;
                spec.relative_bandwidth = std::abs(after - before) / (steps * here);
            }
            spec.source_t = crossing.source_t;
            spec.weight = crossing.weight;
            spec.disc_fresnel_number = crossing.disc_fresnel_number;
            spec.dark_t = fringes.dark_t;
            spec.lit_t = LitReach(iris, spectral, fringes.wavelength_mm, crossing);
            spec.step_t = fringes.step_t;
            std::vector<float> sums = EdgeTable(spec);
            sums.resize(entries, 0.0F);
            const auto known =
                static_cast<std::size_t>(std::ceil((spec.dark_t + spec.lit_t) / spec.step_t));
            for (std::size_t i = known + 1; i < entries; ++i) sums[i] = sums[i - 1] + 1.0F;
            std::copy(sums.begin(), sums.end(),
                      fringes.tables.begin() + static_cast<std::ptrdiff_t>(start));
        }
    }
}

}  // namespace flare
