// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/mesh_packer.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/mesh/grid_roughness.h"

namespace flare {
namespace {

// Cells beyond those in use that a mesh keeps: slopes of fourth order look two vertices far.
constexpr int kKeptAround = 2;

class Packer {
  public:
    Packer(const GridTracer& tracer, GhostMesh& mesh) : tracer_(tracer), mesh_(mesh) {}

    void Pack(const std::vector<RawGrid>& raws) {
        ChooseRims(raws);
        for (const RawGrid& raw : raws) PackGrid(raw, raws.front().mirror_row > 0);
    }

  private:
    // A rim is kept if it cuts a used cell: some corner passes, or nearly does, another is beyond
    // the rim.
    void ChooseRims(const std::vector<RawGrid>& raws) {
        const std::size_t steps = tracer_.steps();
        std::vector<bool> active(steps, false);
        // Grids that were traced together lie together.
        for (auto raw = raws.cbegin(); raw != raws.cend();) {
            const TracedRays& rays = *raw->rays;
            std::vector<std::uint8_t> looked_at(rays.state.size(), 0);
            for (; raw != raws.cend() && raw->rays.get() == &rays; ++raw)
                MarkCorners(*raw, looked_at);
            MarkRims(rays, looked_at, active);
        }
        for (std::size_t s = 0; s < steps; ++s) {
            // The stop is the iris's affair.
            if (active[s] && tracer_.lists().front().steps[s].kind != InteractionKind::kStop) {
                mesh_.rims.push_back(static_cast<int>(s));
            }
        }
    }

    static void MarkCorners(const RawGrid& raw, std::vector<std::uint8_t>& rays) {
        for (int j = raw.mirror_row; j + 1 < raw.grid.nv; ++j) {
            for (int i = 0; i + 1 < raw.grid.nu; ++i) {
                const CellUse use = raw.grid.cells[raw.grid.Cell(i, j)];
                if (use != CellUse::kUsed && use != CellUse::kTriangle) continue;
                const CellCorners corners = raw.CornersOf(i, j);
                if (raw.NearestRatio2(corners) > kNearlyPasses) continue;
                for (const std::size_t ray : corners)
                    rays[ray] = raw.rays->state[ray] == VertexState::kAlive;
            }
        }
    }

    static void MarkRims(const TracedRays& rays, const std::vector<std::uint8_t>& looked_at,
                         std::vector<bool>& active) {
        for (const TraceColumns& node : rays.nodes) {
            for (std::size_t s = 0; s < active.size(); ++s) {
                if (active[s]) continue;
                const float* const row = &node.rim_ratio2[s * node.stride];
                unsigned beyond = 0;
                for (std::size_t k = 0; k < looked_at.size(); ++k)
                    beyond |= row[k] > 1.0F ? looked_at[k] : 0U;
                active[s] = beyond != 0;
            }
        }
    }

    // The vertices i0 <= i < i1, j0 <= j < j1 of a grid.
    struct Window {
        int i0 = 0, i1 = 0, j0 = 0, j1 = 0;
    };

    // Those of the cells in use and of the ones around, from which they have their slopes.
    static Window UsedWindow(const MeshGrid& grid) {
        Window window{grid.nu, 0, grid.nv, 0};
        for (int j = 0; j + 1 < grid.nv; ++j) {
            for (int i = 0; i + 1 < grid.nu; ++i) {
                if (grid.cells[grid.Cell(i, j)] == CellUse::kOutside) continue;
                window.i0 = std::min(window.i0, i);
                window.i1 = std::max(window.i1, i + 2);
                window.j0 = std::min(window.j0, j);
                window.j1 = std::max(window.j1, j + 2);
            }
        }
        return {std::max(0, window.i0 - kKeptAround), std::min(grid.nu, window.i1 + kKeptAround),
                std::max(0, window.j0 - kKeptAround), std::min(grid.nv, window.j1 + kKeptAround)};
    }

    // The part of the grid that is kept; vertices are not filled in.
    static MeshGrid Cut(const MeshGrid& from, const Window& window) {
        MeshGrid grid;
        grid.u0 = from.u0 + window.i0 * from.du;
        grid.v0 = from.v0 + window.j0 * from.dv;
        grid.du = from.du;
        grid.dv = from.dv;
        grid.nu = window.i1 - window.i0;
        grid.nv = window.j1 - window.j0;
        grid.smooth = from.smooth;
        for (int j = window.j0; j + 1 < window.j1; ++j) {
            for (int i = window.i0; i + 1 < window.i1; ++i)
                grid.cells.push_back(from.cells[from.Cell(i, j)]);
        }
        return grid;
    }

    // Adds the grid to the mesh, and the mirror image of a patch of a mirrored main grid.
    void PackGrid(const RawGrid& raw, bool main_mirrored) {
        const Window window = UsedWindow(raw.grid);
        if (window.i1 <= window.i0) return;  // nothing of the main grid
        MeshGrid grid = Cut(raw.grid, window);
        const std::size_t vertices = grid.Vertex(0, grid.nv);
        grid.alive.resize(vertices);
        for (int j = 0; j < grid.nv; ++j) {
            for (int i = 0; i < grid.nu; ++i) {
                grid.alive[grid.Vertex(i, j)] =
                    raw.rays->state[raw.Ray(i + window.i0, j + window.j0)] == VertexState::kAlive;
            }
        }
        for (std::size_t k = 0; k < raw.rays->nodes.size(); ++k) {
            MeshNode node;
            node.wavelength_nm = tracer_.lists()[k].wavelength_nm;
            node.fields.resize(vertices * static_cast<std::size_t>(mesh_.stored_count()));
            node.passage.resize(vertices * tracer_.passage_count());
            for (int j = 0; j < grid.nv; ++j) {
                const float turned = j + window.j0 < raw.mirror_row ? -1.0F : 1.0F;
                PackRow(raw.rays->nodes[k], raw.Ray(window.i0, j + window.j0), turned, grid,
                        grid.Vertex(0, j), node);
            }
            grid.nodes.push_back(std::move(node));
        }
        const bool mirrored = main_mirrored && raw.mirror_row == 0;
        if (mirrored) {
            MeshGrid image = MirrorImage(grid);
            mesh_.grids.push_back(std::move(grid));
            mesh_.grids.push_back(std::move(image));
        } else {
            mesh_.grids.push_back(std::move(grid));
        }
    }

    // One row of vertices, column by column: a row's columns stay in the first-level cache, and
    // all of a vertex's do not. `turned` is -1 for a mirror image, else 1. Dead vertices are zero.
    void PackRow(const TraceColumns& from, std::size_t ray, float turned, const MeshGrid& grid,
                 std::size_t vertex, MeshNode& node) const {
        const auto count = static_cast<std::size_t>(grid.nu);
        const std::uint8_t* const alive = &grid.alive[vertex];
        const auto stored = static_cast<std::size_t>(mesh_.stored_count());
        float* field = &node.fields[vertex * stored];
        const auto pack = [&](const float* column, float factor) {
            for (std::size_t i = 0; i < count; ++i) field[i * stored] = factor * column[ray + i];
            ++field;
        };
        const float x = tracer_.mirrored_axis() == 0 ? turned : 1.0F;
        const float y = tracer_.mirrored_axis() == 0 ? 1.0F : turned;
        pack(from.exit_x.data(), x);
        pack(from.exit_y.data(), y);
        for (std::size_t c = 0; c < tracer_.crossings(); ++c) {
            pack(&from.stop_x[c * from.stride], x);
            pack(&from.stop_y[c * from.stride], y);
        }
        for (const int rim : mesh_.rims) {
            const float* const r2 = &from.rim_ratio2[static_cast<std::size_t>(rim) * from.stride];
            for (std::size_t i = 0; i < count; ++i) {
                field[i * stored] = static_cast<float>(RimField(static_cast<double>(r2[ray + i])));
            }
            ++field;
        }
        pack(from.slope_x.data(), x);
        pack(from.slope_y.data(), y);
        const std::size_t passages = tracer_.passage_count();
        for (std::size_t p = 0; p < passages; ++p) {
            const float* const column = p < tracer_.steps()
                                            ? &from.rare_cos2[p * from.stride]
                                            : &from.segment_mm[(p - tracer_.steps()) * from.stride];
            float* const passage = &node.passage[vertex * passages + p];
            for (std::size_t i = 0; i < count; ++i) passage[i * passages] = column[ray + i];
        }
        for (std::size_t i = 0; i < count; ++i) {
            if (alive[i] != 0) continue;
            std::fill_n(&node.fields[(vertex + i) * stored], stored, 0.0F);
            std::fill_n(&node.passage[(vertex + i) * passages], passages, 0.0F);
        }
    }

    // Rows in reverse, v and the mirrored axis turned round.
    MeshGrid MirrorImage(const MeshGrid& from) const {
        MeshGrid image = from;
        image.v0 = -(from.v0 + (from.nv - 1) * from.dv);
        const auto reverse_rows = [&](auto& values, int rows) {
            const auto row = static_cast<std::ptrdiff_t>(values.size()) / rows;
            for (int j = 0; j < rows / 2; ++j) {
                std::swap_ranges(values.begin() + j * row, values.begin() + (j + 1) * row,
                                 values.begin() + (rows - 1 - j) * row);
            }
        };
        reverse_rows(image.alive, image.nv);
        reverse_rows(image.cells, image.nv - 1);
        const std::size_t axis = tracer_.mirrored_axis();
        const auto stored = static_cast<std::size_t>(mesh_.stored_count());
        for (MeshNode& node : image.nodes) {
            reverse_rows(node.fields, image.nv);
            reverse_rows(node.passage, image.nv);
            for (std::size_t v = 0; v < image.alive.size(); ++v) {
                float* const at = &node.fields[v * stored];
                for (std::size_t pair = 0; pair <= tracer_.crossings(); ++pair) {
                    at[2 * pair + axis] = -at[2 * pair + axis];
                }
                at[stored - 2 + axis] = -at[stored - 2 + axis];
            }
        }
        return image;
    }

    const GridTracer& tracer_;
    GhostMesh& mesh_;
};

}  // namespace

void PackGrids(const GridTracer& tracer, const std::vector<RawGrid>& raws, GhostMesh& mesh) {
    Packer(tracer, mesh).Pack(raws);
}

}  // namespace flare
