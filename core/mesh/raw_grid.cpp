// SPDX-License-Identifier: Apache-2.0
//
// Where the plane of light and axis is one of symmetry the main grid is traced for v >= 0 only.
#include "core/mesh/raw_grid.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/mesh/transmission.h"

namespace flare {

namespace {

// Cells beyond the pass region on each side, so that the masks' edges lie inside the grid with
// neighbours for cubic interpolation.
constexpr double kGuardCells = 1.5;

constexpr std::size_t kSampledRays = 32;

// Rays with a larger (distance / semi-diameter)^2 than this at some rim are no concern of the
// sample.
constexpr float kSampledRim = 1.1F;

// Interactions that the ray met.
std::size_t MetBy(const TraceColumns& rays, std::size_t ray, std::size_t steps) {
    const std::int32_t ended = rays.ended_at[ray];
    if (ended == TraceColumns::kArrived) return steps;
    // A ray that is totally reflected has met the surface where that happens.
    const bool reflected = rays.fate[ray] == static_cast<std::uint8_t>(RayFate::kTir);
    return static_cast<std::size_t>(ended) + (reflected ? 1 : 0);
}

void Allocate(std::size_t rays, std::size_t steps, std::size_t crossings, std::size_t segments,
              TraceColumns& out) {
    out.rays = out.stride = rays;
    out.ended_at.assign(rays, TraceColumns::kArrived);
    out.fate.assign(rays, 0);
    out.disorder.assign(rays, 0);
    for (std::vector<float>* column : {&out.exit_x, &out.exit_y, &out.slope_x, &out.slope_y}) {
        column->assign(rays, 0.0F);
    }
    out.rim_ratio2.assign(rays * steps, 0.0F);
    out.rare_cos2.assign(rays * steps, 0.0F);
    out.stop_x.assign(rays * crossings, 0.0F);
    out.stop_y.assign(rays * crossings, 0.0F);
    out.segment_mm.assign(rays * segments, 0.0F);
}

// Columns are large and needed again by the thread's next ghost; fresh ones cost as much in pages
// as the tracing itself.
std::vector<TraceColumns>& SpareColumns() {
    thread_local std::vector<TraceColumns> spare;
    return spare;
}

void Recycle(TracedRays* rays) {
    constexpr std::size_t kMostSpare = 12;
    constexpr std::size_t kLargestSpare = std::size_t{1} << 20;  // floats in a column
    for (TraceColumns& node : rays->nodes) {
        if (SpareColumns().size() < kMostSpare && node.rim_ratio2.capacity() < kLargestSpare) {
            SpareColumns().push_back(std::move(node));
        }
    }
    delete rays;
}

}  // namespace

GridTracer::GridTracer(const Lens& lens, const MeshSpec& spec, MeshArithmetic arithmetic)
    : spec_(spec),
      arithmetic_(arithmetic),
      bundle_(lens, spec.field_rad, spec.inverse_distance, spec.azimuth_rad),
      absorbing_(AbsorbingSteps(lens, spec.sequence)) {
    for (const double wavelength : spec.wavelengths_nm) {
        lists_.push_back(WriteOut(lens, spec.sequence, wavelength));
        lists_.back().sensor_z_mm = lens.surfaces().back().vertex_z_mm;
    }
}

RawGrid GridTracer::MainGrid(const Rect& rect, int cells) {
    FLARE_CHECK(cells % 2 == 0);
    const bool mirrored = bundle_.mirror_symmetric();
    RawGrid raw;
    MeshGrid& grid = raw.grid;
    grid.nu = grid.nv = cells + 1;
    const double inner = cells - 2.0 * kGuardCells;
    grid.du = (rect.u1 - rect.u0) / inner;
    grid.dv = (rect.v1 - rect.v0) / inner;
    grid.u0 = rect.u0 - kGuardCells * grid.du;
    grid.v0 = mirrored ? -0.5 * cells * grid.dv : rect.v0 - kGuardCells * grid.dv;
    grid.cells.assign(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells),
                      CellUse::kOutside);
    raw.mirror_row = mirrored ? cells / 2 : 0;
    std::vector<Vec2d> pupil;
    for (int j = raw.mirror_row; j <= cells; ++j) {
        for (int i = 0; i <= cells; ++i) {
            pupil.emplace_back(grid.u0 + i * grid.du, grid.v0 + j * grid.dv);
        }
    }
    raw.rays = Trace(pupil);
    return raw;
}

std::vector<RawGrid> GridTracer::Patches(const MeshGrid& main,
                                         const std::vector<PatchedCell>& cells) {
    std::vector<RawGrid> patches;
    std::vector<Vec2d> pupil;
    for (const PatchedCell& cell : cells) {
        const int n = cell.cells;
        RawGrid& raw = patches.emplace_back();
        raw.first = pupil.size();
        MeshGrid& grid = raw.grid;
        grid.nu = grid.nv = n + 1;
        grid.du = main.du / n;
        grid.dv = main.dv / n;
        grid.u0 = main.u0 + cell.i * main.du;
        grid.v0 = main.v0 + cell.j * main.dv;
        for (int j = 0; j <= n; ++j) {
            for (int i = 0; i <= n; ++i) {
                pupil.emplace_back(grid.u0 + i * grid.du, grid.v0 + j * grid.dv);
            }
        }
    }
    if (patches.empty()) return patches;
    const std::shared_ptr<const TracedRays> rays = Trace(pupil);
    for (RawGrid& raw : patches) {
        raw.rays = rays;
        const int n = raw.grid.nu - 1;
        int dead = 0;
        for (int j = 0; j < n; ++j) {
            for (int i = 0; i < n; ++i) {
                int living = 0;
                for (const std::size_t ray : raw.CornersOf(i, j)) {
                    living += rays->state[ray] == VertexState::kAlive ? 1 : 0;
                }
                dead += 4 - living;
                raw.grid.cells.push_back(living == 4   ? CellUse::kUsed
                                         : living == 3 ? CellUse::kTriangle
                                                       : CellUse::kOutside);
            }
        }
        raw.grid.smooth = dead == 0;
    }
    return patches;
}

std::shared_ptr<const TracedRays> GridTracer::Trace(const std::vector<Vec2d>& pupil) {
    const std::shared_ptr<TracedRays> rays(new TracedRays, Recycle);
    rays->nodes.resize(lists_.size());
    for (TraceColumns& node : rays->nodes) {
        if (SpareColumns().empty()) break;
        node = std::move(SpareColumns().back());
        SpareColumns().pop_back();
    }
    if (arithmetic_ == MeshArithmetic::kDouble) {
        for (std::size_t k = 0; k < lists_.size(); ++k) TraceOneByOne(k, pupil, rays->nodes[k]);
    } else {
        RayColumns columns;
        columns.Resize(pupil.size());
        for (std::size_t k = 0; k < pupil.size(); ++k) {
            const Ray ray = bundle_.AtFront(pupil[k].x, pupil[k].y);
            columns.Set(k, ray.origin, ray.direction);
        }
        ColumnNeeds needs;
        needs.segments = absorbing_;
        for (std::size_t k = 0; k < lists_.size(); ++k) {
            TraceInColumns(lists_[k], columns, needs, rays->nodes[k]);
        }
    }
    Judge(*rays);
    return rays;
}

void GridTracer::TraceOneByOne(std::size_t node, const std::vector<Vec2d>& pupil,
                               TraceColumns& out) {
    Allocate(pupil.size(), steps(), crossings(), absorbing_.size(), out);
    TraceOptions options;
    options.clip = false;
    for (std::size_t k = 0; k < pupil.size(); ++k) {
        const TraceResult result =
            TraceRay(lists_[node], bundle_.At(pupil[k].x, pupil[k].y), options, &record_);
        Store(lists_[node], k, result, out);
    }
}

void GridTracer::Store(const InteractionList& list, std::size_t ray, const TraceResult& result,
                       TraceColumns& out) const {
    out.ended_at[ray] = result.ended_at;
    out.fate[ray] = static_cast<std::uint8_t>(result.fate);
    out.disorder[ray] = result.out_of_order_inside ? 2 : result.out_of_order ? 1 : 0;
    for (std::size_t s = 0; s < record_.rim_ratio2.size(); ++s) {
        const Interaction& step = list.steps[s];
        const double cos_in = record_.cos_in[s];
        const double eta = step.n_in / step.n_out;
        const double rare =
            eta <= 1.0 ? cos_in * cos_in : 1.0 - eta * eta * (1.0 - cos_in * cos_in);
        out.rim_ratio2[s * out.stride + ray] = static_cast<float>(record_.rim_ratio2[s]);
        out.rare_cos2[s * out.stride + ray] = static_cast<float>(rare);
    }
    if (result.fate != RayFate::kArrived) return;
    const Vec3d& d = result.exit_direction;
    out.exit_x[ray] = static_cast<float>(result.sensor_mm.x);
    out.exit_y[ray] = static_cast<float>(result.sensor_mm.y);
    out.slope_x[ray] = static_cast<float>(d.x / d.z);
    out.slope_y[ray] = static_cast<float>(d.y / d.z);
    for (std::size_t c = 0; c < record_.stop_mm.size(); ++c) {
        out.stop_x[c * out.stride + ray] = static_cast<float>(record_.stop_mm[c].x);
        out.stop_y[c * out.stride + ray] = static_cast<float>(record_.stop_mm[c].y);
    }
    for (std::size_t a = 0; a < absorbing_.size(); ++a) {
        out.segment_mm[a * out.stride + ray] =
            static_cast<float>(record_.segment_mm[static_cast<std::size_t>(absorbing_[a])]);
    }
}

// Rows of a column first, then the lost rays, whose columns end where they were lost.
void GridTracer::Judge(TracedRays& rays) {
    const std::size_t count = rays.nodes.front().rays;
    rays.state.assign(count, VertexState::kAlive);
    rays.smallest_rim.assign(count, 1e30F);
    std::vector<float> largest;
    for (const TraceColumns& node : rays.nodes) {
        largest.assign(count, 0.0F);
        for (std::size_t s = 0; s < steps(); ++s) {
            const float* const row = &node.rim_ratio2[s * node.stride];
            for (std::size_t k = 0; k < count; ++k) {
                largest[k] = largest[k] < row[k] ? row[k] : largest[k];
            }
        }
        for (std::size_t k = 0; k < count; ++k) {
            const std::size_t met = MetBy(node, k, steps());
            ray_surfaces_ += met;
            const bool arrived = node.fate[k] == static_cast<std::uint8_t>(RayFate::kArrived);
            if (!arrived) {
                largest[k] = 0.0F;
                for (std::size_t s = 0; s < met; ++s) {
                    largest[k] = std::max(largest[k], node.rim_ratio2[s * node.stride + k]);
                }
            }
            if (!arrived || node.disorder[k] == 2) {
                // A ray that left the rims before it died would not have passed anyway.
                if (rays.state[k] != VertexState::kDead) {
                    rays.state[k] =
                        largest[k] > 1.0F ? VertexState::kDeadOutside : VertexState::kDead;
                }
            }
            rays.smallest_rim[k] = std::min(rays.smallest_rim[k], largest[k]);
        }
        rays_ += count;
    }
}

double GridTracer::SampledMiss_mm(const RawGrid& main, double sensor_gap_mm) {
    const MeshGrid& grid = main.grid;
    std::vector<CellIndex> passing;
    for (int j = main.mirror_row; j < grid.nv; ++j) {
        for (int i = 0; i < grid.nu; ++i) {
            const std::size_t ray = main.Ray(i, j);
            if (main.rays->state[ray] == VertexState::kAlive &&
                main.rays->smallest_rim[ray] < kSampledRim) {
                passing.push_back({i, j});
            }
        }
    }
    const TraceColumns& floats = main.rays->nodes[lists_.size() / 2];
    const InteractionList& list = lists_[lists_.size() / 2];
    TraceOptions options;
    options.clip = false;
    double largest = 0.0;
    const std::size_t samples = std::min(kSampledRays, passing.size());
    for (std::size_t k = 0; k < samples; ++k) {
        const CellIndex at = passing[k * passing.size() / samples];
        const Ray ray = bundle_.At(grid.u0 + at.i * grid.du, grid.v0 + at.j * grid.dv);
        const TraceResult exact = TraceRay(list, ray, options, nullptr);
        ++rays_;
        ray_surfaces_ += steps();
        // Rays may end either way next to where they cannot pass.
        if (exact.fate != RayFate::kArrived) continue;
        const std::size_t n = main.Ray(at.i, at.j);
        const Vec3d& d = exact.exit_direction;
        const Vec2d place = exact.sensor_mm + Vec2d(d.x / d.z, d.y / d.z) * sensor_gap_mm;
        const Vec2d found =
            Vec2d(static_cast<double>(floats.exit_x[n]), static_cast<double>(floats.exit_y[n])) +
            Vec2d(static_cast<double>(floats.slope_x[n]), static_cast<double>(floats.slope_y[n])) *
                sensor_gap_mm;
        largest = std::max(largest, (found - place).length() / FarScale(place.length()));
    }
    return largest;
}

}  // namespace flare
