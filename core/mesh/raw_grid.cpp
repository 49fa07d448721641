// SPDX-License-Identifier: Apache-2.0
//
// Where the plane of light and axis is one of symmetry the main grid is traced for v >= 0 and
// mirrored.
#include "core/mesh/raw_grid.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/mesh/transmission.h"

namespace flare {

namespace {

// Cells beyond the pass region on each side, so that the masks' edges lie inside the grid with
// neighbours for cubic interpolation.
constexpr double kGuardCells = 1.5;

}  // namespace

GridTracer::GridTracer(const Lens& lens, const MeshSpec& spec)
    : spec_(spec),
      bundle_(lens, spec.field_rad, spec.inverse_distance, spec.azimuth_rad),
      absorbing_(AbsorbingSteps(lens, spec.sequence)) {
    for (const double wavelength : spec.wavelengths_nm) {
        lists_.push_back(WriteOut(lens, spec.sequence, wavelength));
        lists_.back().sensor_z_mm = lens.surfaces().back().vertex_z_mm;
    }
}

RawGrid GridTracer::MainGrid(const Rect& rect) {
    const int cells = spec_.cells;
    RawGrid raw;
    raw.grid.nu = raw.grid.nv = cells + 1;
    const double inner = cells - 2.0 * kGuardCells;
    raw.grid.du = (rect.u1 - rect.u0) / inner;
    raw.grid.dv = (rect.v1 - rect.v0) / inner;
    raw.grid.u0 = rect.u0 - kGuardCells * raw.grid.du;
    const bool mirrored = bundle_.mirror_symmetric();
    raw.grid.v0 = mirrored ? -0.5 * cells * raw.grid.dv : rect.v0 - kGuardCells * raw.grid.dv;
    Allocate(raw);
    FLARE_CHECK(cells % 2 == 0);
    for (int j = mirrored ? cells / 2 : 0; j <= cells; ++j) {
        for (int i = 0; i <= cells; ++i) {
            TraceVertex(raw, i, j);
            if (mirrored && j > cells / 2)
                MirrorVertex(raw, raw.grid.Vertex(i, j), raw.grid.Vertex(i, cells - j));
        }
    }
    return raw;
}

RawGrid GridTracer::Patch(const MeshGrid& main, int ci, int cj) {
    RawGrid raw;
    raw.grid.nu = raw.grid.nv = spec_.patch_cells + 1;
    raw.grid.du = main.du / spec_.patch_cells;
    raw.grid.dv = main.dv / spec_.patch_cells;
    raw.grid.u0 = main.u0 + ci * main.du;
    raw.grid.v0 = main.v0 + cj * main.dv;
    Allocate(raw);
    for (int j = 0; j <= spec_.patch_cells; ++j) {
        for (int i = 0; i <= spec_.patch_cells; ++i) TraceVertex(raw, i, j);
    }
    raw.grid.smooth = std::all_of(raw.state.begin(), raw.state.end(),
                                  [](VertexState s) { return s == VertexState::kAlive; });
    for (int j = 0; j < spec_.patch_cells; ++j) {
        for (int i = 0; i < spec_.patch_cells; ++i) {
            int living = 0;
            for (const std::size_t v : CornersOf(raw.grid, i, j)) {
                living += raw.state[v] == VertexState::kAlive ? 1 : 0;
            }
            raw.grid.cells[raw.grid.Cell(i, j)] = living == 4   ? CellUse::kUsed
                                                  : living == 3 ? CellUse::kTriangle
                                                                : CellUse::kOutside;
        }
    }
    return raw;
}

void GridTracer::Allocate(RawGrid& raw) const {
    const auto vertices =
        static_cast<std::size_t>(raw.grid.nu) * static_cast<std::size_t>(raw.grid.nv);
    raw.grid.cells.assign(
        static_cast<std::size_t>(raw.grid.nu - 1) * static_cast<std::size_t>(raw.grid.nv - 1),
        CellUse::kOutside);
    raw.state.assign(vertices, VertexState::kAlive);
    raw.smallest_rim.assign(vertices, 0.0F);
    for (std::size_t k = 0; k < lists_.size(); ++k) {
        RawNode node;
        node.exit.assign(vertices * 4, 0.0F);
        node.stops.assign(vertices * 2 * crossings(), 0.0F);
        node.rims.assign(vertices * steps(), 0.0F);
        node.passage.assign(vertices * passage_count(), 0.0F);
        raw.nodes.push_back(std::move(node));
    }
}

void GridTracer::TraceVertex(RawGrid& raw, int i, int j) {
    const std::size_t vertex = raw.grid.Vertex(i, j);
    const Ray ray = bundle_.At(raw.grid.u0 + i * raw.grid.du, raw.grid.v0 + j * raw.grid.dv);
    TraceOptions options;
    options.clip = false;
    double smallest = 1e30;
    for (std::size_t k = 0; k < lists_.size(); ++k) {
        const TraceResult result = TraceRay(lists_[k], ray, options, &record_);
        ++rays_;
        ray_surfaces_ += record_.rim_ratio2.size();
        const double largest =
            record_.rim_ratio2.empty()
                ? 0.0
                : *std::max_element(record_.rim_ratio2.begin(), record_.rim_ratio2.end());
        smallest = std::min(smallest, largest);
        if (result.fate != RayFate::kArrived || result.out_of_order_inside) {
            // A ray that left the rims before it died would not have passed anyway.
            const VertexState now = largest > 1.0 ? VertexState::kDeadOutside : VertexState::kDead;
            if (raw.state[vertex] != VertexState::kDead) raw.state[vertex] = now;
            continue;
        }
        Store(raw.nodes[k], lists_[k], vertex, result);
    }
    raw.smallest_rim[vertex] = static_cast<float>(std::min(smallest, 1e30));
}

void GridTracer::Store(RawNode& node, const InteractionList& list, std::size_t vertex,
                       const TraceResult& result) const {
    const Vec3d& d = result.exit_direction;
    const double slope_x = d.x / d.z;
    const double slope_y = d.y / d.z;
    float* const exit = &node.exit[vertex * 4];
    exit[0] = static_cast<float>(result.sensor_mm.x);
    exit[1] = static_cast<float>(result.sensor_mm.y);
    exit[2] = static_cast<float>(slope_x);
    exit[3] = static_cast<float>(slope_y);
    for (std::size_t c = 0; c < record_.stop_mm.size(); ++c) {
        float* const stop = &node.stops[(vertex * record_.stop_mm.size() + c) * 2];
        stop[0] = static_cast<float>(record_.stop_mm[c].x);
        stop[1] = static_cast<float>(record_.stop_mm[c].y);
    }
    for (std::size_t s = 0; s < steps(); ++s) {
        const Interaction& step = list.steps[s];
        const double cos_in = record_.cos_in[s];
        const double eta = step.n_in / step.n_out;
        const double rare =
            eta <= 1.0 ? cos_in * cos_in : 1.0 - eta * eta * (1.0 - cos_in * cos_in);
        const double r2 = record_.rim_ratio2[s];
        node.rims[vertex * steps() + s] = static_cast<float>((r2 - 1.0) / (r2 + 1.0));
        node.passage[vertex * passage_count() + s] = static_cast<float>(rare);
    }
    for (std::size_t a = 0; a < absorbing_.size(); ++a) {
        node.passage[vertex * passage_count() + steps() + a] =
            static_cast<float>(record_.segment_mm[static_cast<std::size_t>(absorbing_[a])]);
    }
}

void GridTracer::MirrorVertex(RawGrid& raw, std::size_t from, std::size_t to) const {
    raw.state[to] = raw.state[from];
    raw.smallest_rim[to] = raw.smallest_rim[from];
    for (RawNode& node : raw.nodes) {
        for (std::size_t pair = 0; pair < 2; ++pair) {
            MirrorPair(&node.exit[from * 4 + 2 * pair], &node.exit[to * 4 + 2 * pair]);
        }
        for (std::size_t c = 0; c < crossings(); ++c) {
            MirrorPair(&node.stops[(from * crossings() + c) * 2],
                       &node.stops[(to * crossings() + c) * 2]);
        }
        const auto copy = [&](std::vector<float>& values, std::size_t stride) {
            std::copy_n(&values[from * stride], stride, &values[to * stride]);
        };
        copy(node.rims, steps());
        copy(node.passage, passage_count());
    }
}

// Mirrors x, y in the plane of light and axis: the x-z plane or, for an anamorphic lens lit
// from there, the y-z plane.
void GridTracer::MirrorPair(const float* from, float* to) const {
    const bool in_y = spec_.azimuth_rad != 0.0;
    to[0] = in_y ? -from[0] : from[0];
    to[1] = in_y ? from[1] : -from[1];
}

}  // namespace flare
