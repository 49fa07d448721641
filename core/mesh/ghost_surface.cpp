// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/ghost_surface.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace flare {
namespace {

// The slope at one sample of a line, per step: weights of the samples two before it to two behind
// it.
using Stencil = std::array<float, 5>;

// With the widest centred stencil whose samples are alive: fourth order, second order, one-sided
// second order, first order, none.
template <class Alive>
Stencil StencilAt(int i, int count, Alive alive) {
    const auto lives = [&](int k) { return k >= 0 && k < count && alive(k); };
    const bool m1 = lives(i - 1);
    const bool p1 = lives(i + 1);
    if (m1 && p1) {
        if (lives(i - 2) && lives(i + 2)) {
            return {1.0F / 12.0F, -8.0F / 12.0F, 0.0F, 8.0F / 12.0F, -1.0F / 12.0F};
        }
        return {0.0F, -0.5F, 0.0F, 0.5F, 0.0F};
    }
    if (p1) {
        if (lives(i + 2)) return {0.0F, 0.0F, -1.5F, 2.0F, -0.5F};
        return {0.0F, 0.0F, -1.0F, 1.0F, 0.0F};
    }
    if (m1) {
        if (lives(i - 2)) return {0.5F, -2.0F, 1.5F, 0.0F, 0.0F};
        return {0.0F, -1.0F, 1.0F, 0.0F, 0.0F};
    }
    return {};
}

// Adds up samples that lie `step` apart, several fields at once: `at` is the sample in the middle.
void Apply(const Stencil& stencil, const float* at, std::ptrdiff_t step, std::size_t fields,
           float* out) {
    std::fill_n(out, fields, 0.0F);
    for (std::ptrdiff_t k = -2; k <= 2; ++k) {
        const float weight = stencil[static_cast<std::size_t>(k + 2)];
        if (weight == 0.0F) continue;
        const float* const sample = at + k * step;
        for (std::size_t f = 0; f < fields; ++f) out[f] += weight * sample[f];
    }
}

// Which vertices have which derivatives taken: of all corners of cells du and dv; du of their
// neighbours too, whence duv.
enum Wanted : std::uint8_t { kNothing = 0, kDu = 1, kCorner = 2 };

// Bezier control values from values and slopes at the four corners: [corner][value, du, dv, duv].
void NetFromJets(const std::array<std::array<double, 4>, 4>& jets, BezierNet& net) {
    for (int cv = 0; cv < 2; ++cv) {
        for (int cu = 0; cu < 2; ++cu) {
            const auto& [f, du, dv, duv] = jets[static_cast<std::size_t>(2 * cv + cu)];
            const double su = cu == 0 ? 1.0 / 3.0 : -1.0 / 3.0;
            const double sv = cv == 0 ? 1.0 / 3.0 : -1.0 / 3.0;
            const int column = cu == 0 ? 0 : 3;
            const int row = cv == 0 ? 0 : 3;
            const int inner_column = cu == 0 ? 1 : 2;
            const int inner_row = cv == 0 ? 1 : 2;
            const auto at = [&](int r, int c) -> double& {
                return net[static_cast<std::size_t>(4 * r + c)];
            };
            at(row, column) = f;
            at(row, inner_column) = f + su * du;
            at(inner_row, column) = f + sv * dv;
            at(inner_row, inner_column) = f + su * du + sv * dv + su * sv * duv;
        }
    }
}

// The parallelogram rule: the opposite corner mirrored in the middle of the other two.
template <class Real>
void FillDeadCorner(std::size_t dead, std::array<std::array<Real, 4>, 4>& jets) {
    jets[dead][0] = jets[dead ^ 1U][0] + jets[dead ^ 2U][0] - jets[dead ^ 3U][0];
}

// Corner values only: the bilinear surface, written with its own slopes.
template <class Real>
void FillBilinear(std::array<std::array<Real, 4>, 4>& jets) {
    const Real f00 = jets[0][0], f10 = jets[1][0], f01 = jets[2][0], f11 = jets[3][0];
    const Real twist = f11 - f10 - f01 + f00;
    jets[0] = {f00, f10 - f00, f01 - f00, twist};
    jets[1] = {f10, f10 - f00, f11 - f10, twist};
    jets[2] = {f01, f11 - f01, f01 - f00, twist};
    jets[3] = {f11, f11 - f01, f11 - f10, twist};
}

}  // namespace

GhostSurface::GhostSurface(std::shared_ptr<const GhostMesh> mesh, double sensor_gap_mm,
                           double iris_radius_mm, bool cubic)
    : mesh_(std::move(mesh)), sensor_gap_mm_(sensor_gap_mm), cubic_(cubic) {
    for (std::size_t g = 0; g < mesh_->grids.size(); ++g)
        AddCells(static_cast<int>(g), iris_radius_mm);
    slopes_.resize(mesh_->grids.size());
    std::vector<std::vector<std::uint8_t>> corners = Corners();
    for (std::size_t g = 0; g < mesh_->grids.size(); ++g) {
        if (Smooth(mesh_->grids[g]) && !corners[g].empty())
            AddSlopes(mesh_->grids[g], corners[g], slopes_[g]);
    }
}

std::vector<std::vector<std::uint8_t>> GhostSurface::Corners() const {
    std::vector<std::vector<std::uint8_t>> corners(mesh_->grids.size());
    const auto add = [&](std::size_t g, int i, int j) {
        const MeshGrid& grid = mesh_->grids[g];
        if (corners[g].empty()) corners[g].assign(grid.alive.size(), 0);
        for (int y = std::max(0, j - 1); y <= std::min(grid.nv - 1, j + 2); ++y) {
            for (int x = std::max(0, i - 1); x <= std::min(grid.nu - 1, i + 2); ++x)
                corners[g][grid.Vertex(x, y)] = 1;
        }
    };
    for (const CellPlace& cell : cells_) {
        const auto g = static_cast<std::size_t>(cell.grid);
        if (g == 0) {
            add(0, cell.i, cell.j);
            continue;
        }
        // All of a patch, and around the cell that it stands in.
        if (!corners[g].empty()) continue;
        const MeshGrid& patch = mesh_->grids[g];
        const MeshGrid& grid = mesh_->grids.front();
        corners[g].assign(patch.alive.size(), 1);
        add(0, static_cast<int>(std::lround((patch.u0 - grid.u0) / grid.du)),
            static_cast<int>(std::lround((patch.v0 - grid.v0) / grid.dv)));
    }
    return corners;
}

void GhostSurface::AddCells(int g, double iris_radius_mm) {
    const MeshGrid& grid = mesh_->grids[static_cast<std::size_t>(g)];
    if (g > 0 && GridFarOutside(grid, iris_radius_mm)) return;
    for (int j = 0; j + 1 < grid.nv; ++j) {
        for (int i = 0; i + 1 < grid.nu; ++i) {
            const CellUse use = grid.cells[grid.Cell(i, j)];
            if (use != CellUse::kUsed && use != CellUse::kTriangle) continue;
            if (!FarOutsideStop({g, i, j}, iris_radius_mm)) cells_.push_back({g, i, j});
        }
    }
}

bool GhostSurface::GridFarOutside(const MeshGrid& grid, double radius_mm) const {
    if (!grid.smooth) return false;
    std::vector<std::size_t> vertices(grid.alive.size());
    std::iota(vertices.begin(), vertices.end(), std::size_t{0});
    return FarOutside(grid, vertices, radius_mm);
}

void GhostSurface::AddSlopes(const MeshGrid& grid, const std::vector<std::uint8_t>& corners,
                             GridSlopes& out) const {
    const auto fields = static_cast<std::size_t>(mesh_->field_count());
    const std::size_t vertices = grid.alive.size();
    std::vector<std::uint8_t> wanted(vertices, kNothing);
    for (int j = 0; j < grid.nv; ++j) {
        for (int i = 0; i < grid.nu; ++i) {
            if (corners[grid.Vertex(i, j)] == 0) continue;
            wanted[grid.Vertex(i, j)] |= kCorner;
            for (int k = std::max(0, j - 2); k <= std::min(grid.nv - 1, j + 2); ++k) {
                wanted[grid.Vertex(i, k)] |= kDu;
            }
        }
    }
    const auto row = static_cast<std::ptrdiff_t>(static_cast<std::size_t>(grid.nu) * fields);
    const auto stencils_at = [&](int i, int j) {
        return std::array{
            StencilAt(i, grid.nu, [&](int k) { return grid.alive[grid.Vertex(k, j)] != 0; }),
            StencilAt(j, grid.nv, [&](int k) { return grid.alive[grid.Vertex(i, k)] != 0; })};
    };
    std::vector<float> values(vertices * fields), du(vertices * fields), dv(fields), duv(fields);
    for (const MeshNode& node : grid.nodes) {
        for (std::size_t v = 0; v < vertices; ++v) {
            for (std::size_t f = 0; f < fields; ++f)
                values[v * fields + f] = static_cast<float>(Value(node, v, f));
        }
        std::vector<std::array<float, 3>> slopes(vertices * fields, {0.0F, 0.0F, 0.0F});
        // Two passes: du, then dv and with it duv.
        for (int pass = 0; pass < 2; ++pass) {
            for (int j = 0; j < grid.nv; ++j) {
                for (int i = 0; i < grid.nu; ++i) {
                    const std::size_t v = grid.Vertex(i, j);
                    if (grid.alive[v] == 0 || wanted[v] == kNothing) continue;
                    const bool corner = (wanted[v] & kCorner) != 0;
                    if (pass == 1 && !corner) continue;
                    const auto [along_u, along_v] = stencils_at(i, j);
                    const std::size_t at = v * fields;
                    if (pass == 0) {
                        Apply(along_u, &values[at], static_cast<std::ptrdiff_t>(fields), fields,
                              &du[at]);
                        continue;
                    }
                    Apply(along_v, &values[at], row, fields, dv.data());
                    Apply(along_v, &du[at], row, fields, duv.data());
                    for (std::size_t f = 0; f < fields; ++f)
                        slopes[at + f] = {du[at + f], dv[f], duv[f]};
                }
            }
        }
        out.push_back(std::move(slopes));
    }
}

double GhostSurface::Value(const MeshNode& node, std::size_t vertex, std::size_t f) const {
    const auto stored = static_cast<std::size_t>(mesh_->stored_count());
    const float* const at = &node.fields[vertex * stored];
    if (f >= 2) return static_cast<double>(at[f]);
    const Vec2d place = mesh_->SensorPlace(at, sensor_gap_mm_);
    return f == 0 ? place.x : place.y;
}

CellUse GhostSurface::UseOf(const CellPlace& cell) const {
    const MeshGrid& grid = mesh_->grids[static_cast<std::size_t>(cell.grid)];
    return grid.cells[grid.Cell(cell.i, cell.j)];
}

int GhostSurface::DeadCorner(const CellPlace& cell) const {
    const MeshGrid& grid = mesh_->grids[static_cast<std::size_t>(cell.grid)];
    for (int corner = 0; corner < 4; ++corner) {
        if (grid.alive[grid.Vertex(cell.i + corner % 2, cell.j + corner / 2)] == 0) return corner;
    }
    return -1;
}

bool GhostSurface::FarOutsideStop(const CellPlace& cell, double radius_mm) const {
    const MeshGrid& grid = mesh_->grids[static_cast<std::size_t>(cell.grid)];
    if (UseOf(cell) == CellUse::kTriangle) return false;
    return FarOutside(
        grid,
        std::array{grid.Vertex(cell.i, cell.j), grid.Vertex(cell.i + 1, cell.j),
                   grid.Vertex(cell.i, cell.j + 1), grid.Vertex(cell.i + 1, cell.j + 1)},
        radius_mm);
}

bool GhostSurface::FarOutside(const MeshGrid& grid, std::span<const std::size_t> vertices,
                              double radius_mm) const {
    const auto fields = static_cast<std::size_t>(mesh_->stored_count());
    for (int crossing = 0; crossing < mesh_->stop_crossings; ++crossing) {
        const auto stop = static_cast<std::size_t>(mesh_->stop_field(crossing));
        bool outside = true;
        for (const MeshNode& node : grid.nodes) {
            Vec2d lo(1e300), hi(-1e300);
            for (const std::size_t v : vertices) {
                const float* const at = &node.fields[v * fields + stop];
                const Vec2d p(static_cast<double>(at[0]), static_cast<double>(at[1]));
                outside = outside && p.dot(p) > radius_mm * radius_mm;
                lo = {std::min(lo.x, p.x), std::min(lo.y, p.y)};
                hi = {std::max(hi.x, p.x), std::max(hi.y, p.y)};
            }
            if (!outside) break;
            // The surface bulges out of its corners' box by less than the box's size.
            const Vec2d margin = hi - lo;
            const double dx = std::max({lo.x - margin.x, -hi.x - margin.x, 0.0});
            const double dy = std::max({lo.y - margin.y, -hi.y - margin.y, 0.0});
            outside = dx * dx + dy * dy > radius_mm * radius_mm;
            if (!outside) break;
        }
        if (outside) return true;
    }
    return false;
}

void GhostSurface::Jets(const CellPlace& cell, std::size_t node, std::size_t field,
                        CellJets& out) const {
    const MeshGrid& grid = mesh_->grids[static_cast<std::size_t>(cell.grid)];
    const auto fields = static_cast<std::size_t>(mesh_->field_count());
    for (std::size_t corner = 0; corner < 4; ++corner) {
        const std::size_t vertex = grid.Vertex(cell.i + static_cast<int>(corner % 2),
                                               cell.j + static_cast<int>(corner / 2));
        out[corner][0] = static_cast<float>(Value(grid.nodes[node], vertex, field));
        if (!Smooth(grid)) continue;
        const std::array<float, 3>& slope =
            slopes_[static_cast<std::size_t>(cell.grid)][node][vertex * fields + field];
        std::copy(slope.begin(), slope.end(), out[corner].begin() + 1);
    }
    if (Smooth(grid)) return;
    if (UseOf(cell) == CellUse::kTriangle)
        FillDeadCorner(static_cast<std::size_t>(DeadCorner(cell)), out);
    FillBilinear(out);
}

void GhostSurface::Evaluate(const CellPlace& cell, const std::vector<double>& node_weights,
                            int first, int end, CellSurface& out) const {
    const MeshGrid& grid = mesh_->grids[static_cast<std::size_t>(cell.grid)];
    const auto fields = static_cast<std::size_t>(mesh_->field_count());
    const auto stored = static_cast<std::size_t>(mesh_->stored_count());
    const auto from = static_cast<std::size_t>(first);
    const auto count = static_cast<std::size_t>(end) - from;
    const int dead = UseOf(cell) == CellUse::kTriangle ? DeadCorner(cell) : -1;
    out.nets.resize(fields);
    out.jets.assign(16 * count, 0.0);  // [corner][value, du, dv, duv][field]
    for (std::size_t corner = 0; corner < 4; ++corner) {
        const std::size_t vertex = grid.Vertex(cell.i + static_cast<int>(corner % 2),
                                               cell.j + static_cast<int>(corner / 2));
        double* const jet = &out.jets[corner * 4 * count];
        for (std::size_t k = 0; k < grid.nodes.size(); ++k) {
            const double w = node_weights[k];
            const float* const at = &grid.nodes[k].fields[vertex * stored];
            for (std::size_t f = 0; f < count; ++f) jet[f] += w * static_cast<double>(at[from + f]);
            // Those of the sensor taken to where it stands.
            for (std::size_t f = from; f < std::min<std::size_t>(2, from + count); ++f)
                jet[f - from] += w * sensor_gap_mm_ * static_cast<double>(at[fields + f]);
            if (!Smooth(grid)) continue;
            const std::array<float, 3>* const slope =
                &slopes_[static_cast<std::size_t>(cell.grid)][k][vertex * fields + from];
            for (std::size_t f = 0; f < count; ++f) {
                for (std::size_t d = 0; d < 3; ++d)
                    jet[(d + 1) * count + f] += w * static_cast<double>(slope[f][d]);
            }
        }
    }
    for (std::size_t f = 0; f < count; ++f) {
        std::array<std::array<double, 4>, 4> jets{};
        for (std::size_t corner = 0; corner < 4; ++corner) {
            for (std::size_t d = 0; d < 4; ++d)
                jets[corner][d] = out.jets[(corner * 4 + d) * count + f];
        }
        if (!Smooth(grid)) {
            if (dead >= 0) FillDeadCorner(static_cast<std::size_t>(dead), jets);
            FillBilinear(jets);
        }
        NetFromJets(jets, out.nets[from + f]);
    }
}

}  // namespace flare
