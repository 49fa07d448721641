// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/ghost_surface.h"

#include <algorithm>

namespace flare {
namespace {

// Slope at index i of samples f along a line, per step, with the widest centred stencil whose
// samples are alive: fourth order, second order, one-sided second order, first order, none.
template <class Value, class Alive>
double SlopeAt(int i, int count, Value f, Alive alive) {
    const auto lives = [&](int k) { return k >= 0 && k < count && alive(k); };
    const bool m1 = lives(i - 1);
    const bool p1 = lives(i + 1);
    if (m1 && p1) {
        if (lives(i - 2) && lives(i + 2)) {
            return (8.0 * (f(i + 1) - f(i - 1)) - (f(i + 2) - f(i - 2))) / 12.0;
        }
        return 0.5 * (f(i + 1) - f(i - 1));
    }
    if (p1) {
        if (lives(i + 2)) return -1.5 * f(i) + 2.0 * f(i + 1) - 0.5 * f(i + 2);
        return f(i + 1) - f(i);
    }
    if (m1) {
        if (lives(i - 2)) return 1.5 * f(i) - 2.0 * f(i - 1) + 0.5 * f(i - 2);
        return f(i) - f(i - 1);
    }
    return 0.0;
}

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

// Corner values only: the bilinear surface, written with its own slopes.
void FillBilinear(std::array<std::array<double, 4>, 4>& jets) {
    const double f00 = jets[0][0], f10 = jets[1][0], f01 = jets[2][0], f11 = jets[3][0];
    const double twist = f11 - f10 - f01 + f00;
    jets[0] = {f00, f10 - f00, f01 - f00, twist};
    jets[1] = {f10, f10 - f00, f11 - f10, twist};
    jets[2] = {f01, f11 - f01, f01 - f00, twist};
    jets[3] = {f11, f11 - f01, f11 - f10, twist};
}

}  // namespace

GhostSurface::GhostSurface(std::shared_ptr<const GhostMesh> mesh, double sensor_gap_mm)
    : mesh_(std::move(mesh)), sensor_gap_mm_(sensor_gap_mm) {
    for (std::size_t g = 0; g < mesh_->grids.size(); ++g) {
        const MeshGrid& grid = mesh_->grids[g];
        for (int j = 0; j + 1 < grid.nv; ++j) {
            for (int i = 0; i + 1 < grid.nu; ++i) {
                const CellUse use = grid.cells[grid.Cell(i, j)];
                if (use == CellUse::kUsed || use == CellUse::kTriangle) {
                    cells_.push_back({static_cast<int>(g), i, j});
                }
            }
        }
    }
    slopes_.resize(mesh_->grids.size());
    for (std::size_t g = 0; g < mesh_->grids.size(); ++g) {
        if (mesh_->grids[g].smooth) AddSlopes(mesh_->grids[g], slopes_[g]);
    }
}

void GhostSurface::AddSlopes(const MeshGrid& grid, GridSlopes& out) const {
    const auto fields = static_cast<std::size_t>(mesh_->field_count());
    const std::size_t vertices = grid.alive.size();
    for (const MeshNode& node : grid.nodes) {
        std::vector<std::array<float, 3>> slopes(vertices * fields, {0.0F, 0.0F, 0.0F});
        // Two passes: du and dv of the values, then dv of du.
        for (int pass = 0; pass < 2; ++pass) {
            for (int j = 0; j < grid.nv; ++j) {
                for (int i = 0; i < grid.nu; ++i) {
                    if (grid.alive[grid.Vertex(i, j)] == 0) continue;
                    const auto alive_u = [&](int k) { return grid.alive[grid.Vertex(k, j)] != 0; };
                    const auto alive_v = [&](int k) { return grid.alive[grid.Vertex(i, k)] != 0; };
                    for (std::size_t f = 0; f < fields; ++f) {
                        auto& slope = slopes[grid.Vertex(i, j) * fields + f];
                        const auto along_u = [&](int k) {
                            return Value(node, grid.Vertex(k, j), f);
                        };
                        const auto along_v = [&](int k) {
                            return Value(node, grid.Vertex(i, k), f);
                        };
                        const auto du_along_v = [&](int k) {
                            return static_cast<double>(slopes[grid.Vertex(i, k) * fields + f][0]);
                        };
                        if (pass == 0) {
                            slope[0] = static_cast<float>(SlopeAt(i, grid.nu, along_u, alive_u));
                            slope[1] = static_cast<float>(SlopeAt(j, grid.nv, along_v, alive_v));
                        } else {
                            slope[2] = static_cast<float>(SlopeAt(j, grid.nv, du_along_v, alive_v));
                        }
                    }
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
    const auto fields = static_cast<std::size_t>(mesh_->stored_count());
    for (int crossing = 0; crossing < mesh_->stop_crossings; ++crossing) {
        bool outside = true;
        for (const MeshNode& node : grid.nodes) {
            double lo[2] = {1e30, 1e30};
            double hi[2] = {-1e30, -1e30};
            for (int corner = 0; corner < 4; ++corner) {
                const std::size_t v = grid.Vertex(cell.i + corner % 2, cell.j + corner / 2);
                for (std::size_t axis = 0; axis < 2; ++axis) {
                    const double p = static_cast<double>(
                        node.fields[v * fields +
                                    static_cast<std::size_t>(mesh_->stop_field(crossing)) + axis]);
                    lo[axis] = std::min(lo[axis], p);
                    hi[axis] = std::max(hi[axis], p);
                }
            }
            // The surface bulges out of its corners' box by less than the box's size.
            const double mx = hi[0] - lo[0];
            const double my = hi[1] - lo[1];
            const double dx = std::max({lo[0] - mx, -hi[0] - mx, 0.0});
            const double dy = std::max({lo[1] - my, -hi[1] - my, 0.0});
            outside = outside && dx * dx + dy * dy > radius_mm * radius_mm;
        }
        if (outside) return true;
    }
    return false;
}

void GhostSurface::Evaluate(const CellPlace& cell, const std::vector<double>& node_weights,
                            int first, int end, CellSurface& out) const {
    const MeshGrid& grid = mesh_->grids[static_cast<std::size_t>(cell.grid)];
    const auto fields = static_cast<std::size_t>(mesh_->field_count());
    const int dead = UseOf(cell) == CellUse::kTriangle ? DeadCorner(cell) : -1;
    out.nets.resize(fields);
    for (auto f = static_cast<std::size_t>(first); f < static_cast<std::size_t>(end); ++f) {
        std::array<std::array<double, 4>, 4> jets{};
        for (std::size_t corner = 0; corner < 4; ++corner) {
            const std::size_t vertex = grid.Vertex(cell.i + static_cast<int>(corner % 2),
                                                   cell.j + static_cast<int>(corner / 2));
            for (std::size_t k = 0; k < grid.nodes.size(); ++k) {
                const double w = node_weights[k];
                jets[corner][0] += w * Value(grid.nodes[k], vertex, f);
                if (!grid.smooth) continue;
                const auto& slope =
                    slopes_[static_cast<std::size_t>(cell.grid)][k][vertex * fields + f];
                for (std::size_t d = 0; d < 3; ++d)
                    jets[corner][d + 1] += w * static_cast<double>(slope[d]);
            }
        }
        if (!grid.smooth) {
            if (dead >= 0) {
                // The parallelogram rule: opposite corner mirrored in the middle of the other two.
                const auto d = static_cast<std::size_t>(dead);
                jets[d][0] = jets[d ^ 1U][0] + jets[d ^ 2U][0] - jets[d ^ 3U][0];
            }
            FillBilinear(jets);
        }
        NetFromJets(jets, out.nets[f]);
    }
}

}  // namespace flare
