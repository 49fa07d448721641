// SPDX-License-Identifier: Apache-2.0
#include "core/render/ghost_sample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/image/stop_pass.h"
#include "core/tracing/paraxial_ghost.h"
#include "core/tracing/trace_columns.h"

namespace flare {
namespace {

constexpr int kCells = 12;        // along a side of the sampled rectangle
constexpr double kWiden = 1.25;   // of rims, for what first order does not know
constexpr int kMostRounds = 8;    // of moving the rectangle to where rays pass
constexpr int kBlindRounds = 2;   // of these before the search
constexpr int kNarrow = 5;        // steps; fewer that pass want a closer look
constexpr double kGrazing = 0.1;  // cosine to the axis: nothing first-order beyond
constexpr double kDead = 1e9;     // mask of a vertex that no ray came from

// Where a ray meets the plane of vertex 0, and its slopes.
struct FrontPlace {
    Vec2d place{0.0, 0.0}, slope{0.0, 0.0};
};

std::optional<FrontPlace> FrontPlaceOf(const LightBundle& bundle, double u, double v) {
    const Ray ray = bundle.At(u, v);
    if (ray.direction.z < kGrazing) return std::nullopt;
    FrontPlace front;
    front.slope = Vec2d(ray.direction.x, ray.direction.y) / ray.direction.z;
    front.place = Vec2d(ray.origin.x, ray.origin.y) - front.slope * ray.origin.z;
    return front;
}

void Narrow(double middle, double half, double& lo, double& hi) {
    lo = std::max(lo, middle - half);
    hi = std::min(hi, middle + half);
}

// The rectangle of the bundle that all rims and the iris let pass by first-order optics.
std::optional<Rect> PredictRegion(const SampleScene& scene, const InteractionList& list) {
    const LightBundle& bundle = scene.bundle;
    const double half = bundle.half_width();
    const double uc = bundle.centre_u();
    const double step = 0.01 * half;
    const std::optional<FrontPlace> at = FrontPlaceOf(bundle, uc, 0.0);
    const std::optional<FrontPlace> at_u = FrontPlaceOf(bundle, uc + step, 0.0);
    const std::optional<FrontPlace> at_v = FrontPlaceOf(bundle, uc, step);
    if (!at || !at_u || !at_v) return std::nullopt;
    const Vec2d place_u = (at_u->place - at->place) / step;
    const Vec2d slope_u = (at_u->slope - at->slope) / step;
    const Vec2d place_v = (at_v->place - at->place) / step;
    const Vec2d slope_v = (at_v->slope - at->slope) / step;

    Rect box{uc - half, uc + half, -half, half};
    Abcd x, y;
    double z = 0.0;
    for (const Interaction& interaction : list.steps) {
        const Abcd drift = Drift(interaction.vertex_z_mm - z);
        x = Then(x, drift);
        y = Then(y, drift);
        z = interaction.vertex_z_mm;
        const double rim =
            kWiden * (interaction.kind == InteractionKind::kStop
                          ? std::min(scene.iris.outer_radius(), interaction.semi_diameter_mm)
                          : interaction.semi_diameter_mm);
        // (x, y) there = c + J (u - uc, v); the disc of the rim taken back to (u, v).
        const Vec2d c(x.a * at->place.x + x.b * at->slope.x, y.a * at->place.y + y.b * at->slope.y);
        const double xu = x.a * place_u.x + x.b * slope_u.x;
        const double xv = x.a * place_v.x + x.b * slope_v.x;
        const double yu = y.a * place_u.y + y.b * slope_u.y;
        const double yv = y.a * place_v.y + y.b * slope_v.y;
        const double det = xu * yv - xv * yu;
        if (std::abs(det) > 1e-12) {
            Narrow(uc - (yv * c.x - xv * c.y) / det, rim * std::hypot(yv, xv) / std::abs(det),
                   box.u0, box.u1);
            Narrow(-(xu * c.y - yu * c.x) / det, rim * std::hypot(xu, yu) / std::abs(det), box.v0,
                   box.v1);
        }
        x = Then(x, StepMatrix(interaction, Section::kX));
        y = Then(y, StepMatrix(interaction, Section::kY));
    }
    if (!(box.u0 < box.u1 && box.v0 < box.v1)) return std::nullopt;
    return box;
}

class Sampler {
  public:
    Sampler(const SampleScene& scene, const BounceSequence& sequence)
        : scene_(scene),
          list_(WriteOut(scene.lens, sequence, scene.tables.wavelengths_nm().front())),
          path_(scene.tables.PathOf(scene.lens, sequence)),
          half_(scene.bundle.mirror_symmetric()) {
        needs_.segments = AbsorbingSteps(scene.lens, sequence);
        pixel_mm2_ = 1.0 / std::abs(scene.map.px_per_x.x * scene.map.px_per_y.y -
                                    scene.map.px_per_x.y * scene.map.px_per_y.x);
    }

    GhostSample Run() {
        if (!FindRays()) return sample_;
        for (int j = 0; j < kCells; ++j) {
            for (int i = 0; i < kCells; ++i) AddCell(i, j);
        }
        sample_.box_width_px = std::max(0.0, hi_.x - lo_.x);
        sample_.box_height_px = std::max(0.0, hi_.y - lo_.y);
        sample_.box_lo_px = lo_;
        sample_.box_hi_px = hi_;
        sample_.region = rect_;
        const double gain = ColourGain();
        sample_.frame_light = gain * sample_.frame_flux_mm2;
        sample_.peak = gain * std::min(sample_.peak, sample_.frame_flux_mm2 / pixel_mm2_);
        return sample_;
    }

  private:
    struct Vertex {
        double mask = kDead;  // positive outside the iris or a rim
        Vec2d px{0.0, 0.0};
        double flux = -1.0;  // per du dv at the first wavelength; -1: not yet known
        bool alive = false;
    };

    static std::size_t Index(int i, int j) {
        return static_cast<std::size_t>(j * (kCells + 1) + i);
    }
    // Rows of the traced grid: all, or those with v >= 0.
    int FirstRow() const { return half_ ? kCells / 2 : 0; }
    // The traced row whose mirror image row j is.
    int TracedRow(int j) const { return half_ && j < FirstRow() ? kCells - j : j; }

    // Moves the rectangle until enough rays pass, and all that do lie inside.
    bool FindRays() {
        std::optional<Rect> rect = PredictRegion(scene_, list_);
        bool searched = false;
        const auto search = [&] {
            searched = true;
            const PassRegion region = FindPassRegion({list_}, scene_.bundle);
            sample_.rays += region.rays;
            sample_.ray_surfaces += region.ray_surfaces;
            return region.rect;
        };
        if (!rect) rect = search();
        for (int round = 0; rect && round < kMostRounds; ++round) {
            rect_ = *rect;
            Trace();
            if (passing_ > 0) {
                rect = NextRect();
            } else {
                rect = NearestMiss();
                if (!searched && (!rect || round + 1 >= kBlindRounds)) rect = search();
            }
        }
        return passing_ > 0;
    }

    void Trace() {
        du_ = (rect_.u1 - rect_.u0) / kCells;
        dv_ = (rect_.v1 - rect_.v0) / kCells;
        const int first = FirstRow();
        rays_.Resize(static_cast<std::size_t>((kCells + 1 - first) * (kCells + 1)));
        for (int j = first; j <= kCells; ++j) {
            for (int i = 0; i <= kCells; ++i) {
                const Ray ray = scene_.bundle.AtFront(rect_.u0 + i * du_, rect_.v0 + j * dv_);
                rays_.Set(Index(i, j - first), ray.origin, ray.direction);
            }
        }
        TraceInColumns(list_, rays_, needs_, traced_);
        sample_.rays += rays_.size();
        sample_.ray_surfaces += rays_.size() * list_.steps.size();
        ratio2_.assign(traced_.stride, 0.0F);
        for (std::size_t s = 0; s < list_.steps.size(); ++s) {
            const float* const at = &traced_.rim_ratio2[s * traced_.stride];
            for (std::size_t k = 0; k < traced_.stride; ++k)
                ratio2_[k] = std::max(ratio2_[k], at[k]);
        }
        vertices_.assign(Index(0, kCells + 1), {});
        if (scene_.iris.picture() != nullptr)
            at_stop_.assign(vertices_.size() * static_cast<std::size_t>(list_.stop_crossings),
                            Vec2d(0.0, 0.0));
        passing_ = 0;
        for (int j = 0; j <= kCells; ++j) {
            for (int i = 0; i <= kCells; ++i) SetVertex(i, j);
        }
    }

    void SetVertex(int i, int j) {
        const std::size_t k = Index(i, TracedRow(j) - FirstRow());
        const double side = TracedRow(j) == j ? 1.0 : -1.0;
        if (traced_.ended_at[k] != TraceColumns::kArrived || traced_.disorder[k] >= 2) return;
        Vertex& vertex = vertices_[Index(i, j)];
        vertex.alive = true;
        vertex.mask = std::sqrt(static_cast<double>(ratio2_[k])) - 1.0;
        const double opening = scene_.iris.outer_radius();
        for (std::size_t c = 0; c < static_cast<std::size_t>(list_.stop_crossings); ++c) {
            const Vec2d at = scene_.pose.LensSpace(
                {static_cast<double>(traced_.stop_x[c * traced_.stride + k]),
                 side * static_cast<double>(traced_.stop_y[c * traced_.stride + k])});
            vertex.mask = std::max(vertex.mask, scene_.iris.Distance(at) / opening);
            if (!at_stop_.empty()) at_stop_[c * vertices_.size() + Index(i, j)] = at;
        }
        const double gap = list_.sensor_z_mm - list_.steps.back().vertex_z_mm;
        vertex.px = scene_.map.Pixel(
            static_cast<double>(traced_.exit_x[k]) + gap * static_cast<double>(traced_.slope_x[k]),
            side * (static_cast<double>(traced_.exit_y[k]) +
                    gap * static_cast<double>(traced_.slope_y[k])));
        if (vertex.mask < 0.0) ++passing_;
    }

    // Around the ray that all but passes, where none does; nothing if none arrives.
    std::optional<Rect> NearestMiss() const {
        const auto best =
            std::min_element(vertices_.begin(), vertices_.end(),
                             [](const Vertex& a, const Vertex& b) { return a.mask < b.mask; });
        if (!best->alive) return std::nullopt;
        const int k = static_cast<int>(best - vertices_.begin());
        constexpr int kAround = 2;
        const double u = rect_.u0 + k % (kCells + 1) * du_;
        // Rows are mirror images of each other: the rectangle stays symmetric.
        const double v = rect_.v0 + k / (kCells + 1) * dv_;
        const double v0 = half_ ? -std::abs(v) : v;
        const double v1 = half_ ? std::abs(v) : v;
        return Rect{u - kAround * du_, u + kAround * du_, v0 - kAround * dv_, v1 + kAround * dv_};
    }

    // Where to look next; nothing: the rectangle is right.
    std::optional<Rect> NextRect() const {
        int i0 = kCells, i1 = 0, j0 = kCells, j1 = 0;
        for (int j = 0; j <= kCells; ++j) {
            for (int i = 0; i <= kCells; ++i) {
                if (vertices_[Index(i, j)].mask >= 0.0) continue;
                i0 = std::min(i0, i);
                i1 = std::max(i1, i);
                j0 = std::min(j0, j);
                j1 = std::max(j1, j);
            }
        }
        constexpr int kBeyond = kCells / 4;
        const bool touches = i0 == 0 || j0 == 0 || i1 == kCells || j1 == kCells;
        const bool narrow = i1 - i0 < kNarrow || j1 - j0 < kNarrow;
        if (!touches && !narrow) return std::nullopt;
        const int a0 = i0 == 0 ? -kBeyond : i0 - 1;
        const int a1 = i1 == kCells ? kCells + kBeyond : i1 + 1;
        const int b0 = j0 == 0 ? -kBeyond : j0 - 1;
        const int b1 = j1 == kCells ? kCells + kBeyond : j1 + 1;
        const double half = scene_.bundle.half_width();
        const double uc = scene_.bundle.centre_u();
        const Rect next{std::max(uc - half, rect_.u0 + a0 * du_),
                        std::min(uc + half, rect_.u0 + a1 * du_),
                        std::max(-half, rect_.v0 + b0 * dv_), std::min(half, rect_.v0 + b1 * dv_)};
        if (next == rect_) return std::nullopt;
        return next;
    }

    // Light of the first wavelength per du dv. Transmittance is smooth: of each cell it is looked
    // at in one corner, which four cells share; at another where that one is dead.
    double FluxOf(int i, int j) {
        const int even_i = i + i % 2;
        const int even_j = j + j % 2;
        if (vertices_[Index(even_i, even_j)].alive) return FluxAt(even_i, even_j);
        for (const int b : {j, j + 1}) {
            for (const int a : {i, i + 1}) {
                if (vertices_[Index(a, b)].alive) return FluxAt(a, b);
            }
        }
        return 0.0;
    }

    // A mirror image has the light of its original.
    double FluxAt(int i, int j) {
        const int row = TracedRow(j);
        double& flux = vertices_[Index(i, row)].flux;
        if (flux < 0.0) {
            GatherPassage(i, row);
            flux = std::max(0.0, path_.Weight(0, passage_)) *
                   scene_.bundle.FluxDensity(rect_.u0 + i * du_, rect_.v0 + row * dv_);
        }
        return flux;
    }

    void GatherPassage(int i, int row) {
        const std::size_t k = Index(i, row - FirstRow());
        const std::size_t steps = list_.steps.size();
        passage_.resize(steps + needs_.segments.size());
        for (std::size_t s = 0; s < steps; ++s) {
            passage_[s] = static_cast<double>(traced_.rare_cos2[s * traced_.stride + k]);
        }
        for (std::size_t s = 0; s < needs_.segments.size(); ++s) {
            passage_[steps + s] = static_cast<double>(traced_.segment_mm[s * traced_.stride + k]);
        }
    }

    // Weighted light of all wavelengths over the flux of the first, at the ray that is farthest
    // from all masks.
    double ColourGain() {
        int best = -1;
        for (int k = 0; k < static_cast<int>(vertices_.size()); ++k) {
            if (TracedRow(k / (kCells + 1)) != k / (kCells + 1)) continue;
            if (best < 0 || vertices_[static_cast<std::size_t>(k)].mask <
                                vertices_[static_cast<std::size_t>(best)].mask) {
                best = k;
            }
        }
        GatherPassage(best % (kCells + 1), best / (kCells + 1));
        double light = 0.0;
        double first = 0.0;
        for (std::size_t band = 0; band < scene_.weights.size(); ++band) {
            const double passed = std::max(0.0, path_.Weight(static_cast<int>(band), passage_));
            if (band == 0) first = passed;
            light += scene_.weights[band] * passed;
        }
        return first > 0.0 ? light / first : 0.0;
    }

    // How much of a cell passes, were its mask linear along one direction.
    static double Coverage(const std::array<const Vertex*, 4>& corners) {
        double lo = std::numeric_limits<double>::max();
        double hi = std::numeric_limits<double>::lowest();
        for (const Vertex* corner : corners) {
            lo = std::min(lo, corner->mask);
            hi = std::max(hi, corner->alive ? corner->mask : -lo);
        }
        if (lo >= 0.0) return 0.0;
        return hi <= 0.0 ? 1.0 : -lo / (hi - lo);
    }

    void AddCell(int i, int j) {
        // Around the cell.
        const std::array<const Vertex*, 4> corners = {
            &vertices_[Index(i, j)], &vertices_[Index(i + 1, j)], &vertices_[Index(i + 1, j + 1)],
            &vertices_[Index(i, j + 1)]};
        const double coverage = Coverage(corners);
        if (coverage == 0.0) return;
        int living = 0;
        Vec2d lo(std::numeric_limits<double>::max());
        Vec2d hi(std::numeric_limits<double>::lowest());
        for (const Vertex* corner : corners) {
            if (!corner->alive) continue;
            ++living;
            lo = {std::min(lo.x, corner->px.x), std::min(lo.y, corner->px.y)};
            hi = {std::max(hi.x, corner->px.x), std::max(hi.y, corner->px.y)};
        }
        const double passes = living == 4 ? PassMeanOf(i, j) : PassAtCorners(corners);
        const double flux = coverage * passes * du_ * dv_ * FluxOf(i, j);
        const double on_frame =
            Overlap(lo.x, hi.x, scene_.width) * Overlap(lo.y, hi.y, scene_.height);
        AddToBox(corners);
        sample_.flux_mm2 += flux;
        sample_.frame_flux_mm2 += flux * on_frame;
        const auto [area, folded] = living == 4 ? AreaOf(corners) : std::pair(1.0, false);
        sample_.area_px2 += coverage * area;
        if (on_frame > 0.0 && passes > 0.0) {
            // At a fold irradiance goes with one over the square root of the distance to it.
            const double most = folded ? std::sqrt(std::sqrt(area)) : 1.0;
            const double whole = passes < 1.0 ? du_ * dv_ * FluxOf(i, j) : flux / coverage;
            sample_.peak = std::max(sample_.peak, whole / (area * pixel_mm2_) * most);
        }
    }

    // Of the iris's picture over a cell, in parts: at every crossing it is met by the same rays.
    double PassMeanOf(int i, int j) const {
        if (at_stop_.empty()) return 1.0;
        constexpr int kParts = 4;
        const auto place = [&](std::size_t first, double a, double b) {
            return (at_stop_[first + Index(i, j)] * (1.0 - a) +
                    at_stop_[first + Index(i + 1, j)] * a) *
                       (1.0 - b) +
                   (at_stop_[first + Index(i, j + 1)] * (1.0 - a) +
                    at_stop_[first + Index(i + 1, j + 1)] * a) *
                       b;
        };
        double sum = 0.0;
        for (int k = 0; k < kParts * kParts; ++k) {
            const double a = static_cast<double>(k % kParts) / kParts;
            const double b = static_cast<double>(k / kParts) / kParts;
            constexpr double kStep = 1.0 / kParts;
            double passes = 1.0;
            for (std::size_t first = 0; first < at_stop_.size() && passes > 0.0;
                 first += vertices_.size()) {
                passes *=
                    PassMean(*scene_.iris.picture(),
                             {place(first, a, b), place(first, a + kStep, b),
                              place(first, a + kStep, b + kStep), place(first, a, b + kStep)});
            }
            sum += passes;
        }
        return sum / (kParts * kParts);
    }

    // The same of a cell of which not all is known.
    double PassAtCorners(const std::array<const Vertex*, 4>& corners) const {
        if (at_stop_.empty()) return 1.0;
        double sum = 0.0;
        int living = 0;
        for (const Vertex* corner : corners) {
            if (!corner->alive) continue;
            const auto n = static_cast<std::size_t>(corner - vertices_.data());
            double passes = 1.0;
            for (std::size_t first = 0; first < at_stop_.size(); first += vertices_.size())
                passes *= scene_.iris.TransmissionAt(at_stop_[first + n]);
            sum += passes;
            ++living;
        }
        return living > 0 ? sum / living : 0.0;
    }

    // The corners that pass, and where an edge of the cell meets the mask.
    void AddToBox(const std::array<const Vertex*, 4>& corners) {
        for (std::size_t k = 0; k < 4; ++k) {
            const Vertex& a = *corners[k];
            const Vertex& b = *corners[(k + 1) % 4];
            if (a.mask < 0.0) AddToBox(a.px);
            if (!a.alive || !b.alive || (a.mask < 0.0) == (b.mask < 0.0)) continue;
            AddToBox(a.px + (b.px - a.px) * (a.mask / (a.mask - b.mask)));
        }
    }

    void AddToBox(Vec2d px) {
        lo_ = {std::min(lo_.x, px.x), std::min(lo_.y, px.y)};
        hi_ = {std::max(hi_.x, px.x), std::max(hi_.y, px.y)};
    }

    // Of the interval lo ... hi, at least a pixel long, the part within 0 ... size.
    static double Overlap(double lo, double hi, double size) {
        const double middle = 0.5 * (lo + hi);
        const double half = std::max(0.5, 0.5 * (hi - lo));
        const double within = std::min(middle + half, size) - std::max(middle - half, 0.0);
        return std::clamp(within / (2.0 * half), 0.0, 1.0);
    }

    // At least a pixel, and whether the cell is turned over within itself.
    static std::pair<double, bool> AreaOf(const std::array<const Vertex*, 4>& corners) {
        double least = std::numeric_limits<double>::max();
        double most = std::numeric_limits<double>::lowest();
        double sum = 0.0;
        for (std::size_t k = 0; k < 4; ++k) {
            const Vec2d a = corners[(k + 1) % 4]->px - corners[k]->px;
            const Vec2d b = corners[(k + 3) % 4]->px - corners[k]->px;
            const double area = a.x * b.y - a.y * b.x;
            least = std::min(least, area);
            most = std::max(most, area);
            sum += 0.25 * std::abs(area);
        }
        return {std::max(1.0, sum), least < 0.0 && most > 0.0};
    }

    const SampleScene& scene_;
    InteractionList list_;
    TransmissionTables::Path path_;
    bool half_;
    ColumnNeeds needs_;
    double pixel_mm2_ = 0.0;
    Rect rect_;
    double du_ = 0.0, dv_ = 0.0;
    RayColumns rays_;
    TraceColumns traced_;
    std::vector<float> ratio2_;  // of each ray, the largest over all rims
    std::vector<Vertex> vertices_;
    std::vector<Vec2d> at_stop_;  // [crossing][vertex], if the iris has a picture
    int passing_ = 0;
    std::vector<double> passage_;
    Vec2d lo_{std::numeric_limits<double>::max()}, hi_{std::numeric_limits<double>::lowest()};
    GhostSample sample_;
};

}  // namespace

GhostSample SampleGhost(const SampleScene& scene, const BounceSequence& sequence) {
    return Sampler(scene, sequence).Run();
}

}  // namespace flare
