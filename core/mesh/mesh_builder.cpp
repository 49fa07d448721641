// SPDX-License-Identifier: Apache-2.0
//
// Grids are traced raw, with the rim ratio of every interaction (raw_grid.h). Here is decided which
// of their cells light can use, which need a finer patch, and which rims cut the ghost: only those
// are kept.
#include "core/mesh/mesh_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/mesh/grid_roughness.h"
#include "core/mesh/pass_region.h"
#include "core/mesh/raw_grid.h"

namespace flare {
namespace {

constexpr int kTracerVersion = 4;  // part of every key: raise when traced values change

// Bounds the memory of a mesh that hardly any ray survives; past it cells that have four living
// corners stay as they are and others are left out.
constexpr std::size_t kMostPatches = 4096;

// Cells whose best corner has a larger (distance / semi-diameter)^2 than this at some rim do not
// pass.
constexpr double kNearlyPasses = 1.05;

// The part of the position tolerance that floats may take up.
constexpr double kFloatShare = 0.02;

class Builder {
  public:
    Builder(const Lens& lens, const MeshSpec& spec, MeshArithmetic arithmetic)
        : spec_(spec),
          lens_(lens),
          tracer_(lens, spec, arithmetic),
          sensor_gap_mm_(lens.nominal_sensor_gap_mm()) {
        mesh_.sequence = spec.sequence;
        mesh_.field_rad = spec.field_rad;
        mesh_.azimuth_rad = spec.azimuth_rad;
        mesh_.inverse_distance = spec.inverse_distance;
        mesh_.absorbing = tracer_.absorbing();
        mesh_.stop_crossings = static_cast<int>(tracer_.crossings());
        mesh_.interactions = static_cast<int>(tracer_.steps());
        mesh_.in_doubles = arithmetic == MeshArithmetic::kDouble;
    }

    PassRegion Region() const { return FindPassRegion(tracer_.lists(), tracer_.bundle()); }

    // False if floats are not good enough for this ghost.
    bool Build(const PassRegion& region) {
        mesh_.rays_traced = region.rays;
        mesh_.ray_surfaces = region.ray_surfaces;
        if (!region.rect) return true;
        raw_.push_back(tracer_.MainGrid(*region.rect, spec_.cells));
        if (!mesh_.in_doubles && tracer_.SampledMiss_mm(raw_.front(), sensor_gap_mm_) >
                                     kFloatShare * spec_.position_tolerance_mm) {
            return false;
        }
        UseMainCells();
        ChooseRims();
        for (const RawGrid& raw : raw_) PackGrid(raw);
        return true;
    }

    // After Build.
    GhostMesh Take() {
        mesh_.rays_traced += tracer_.rays();
        mesh_.ray_surfaces += tracer_.ray_surfaces();
        return std::move(mesh_);
    }

  private:
    // Decides the use of each main cell and adds a patch where a cell that may pass has a dead
    // corner or is rough. A mirrored grid's lower half follows its upper one.
    void UseMainCells() {
        RawGrid& main = raw_.front();
        const int cells = main.grid.nu - 1;
        GridRoughness roughness(tracer_, spec_, lens_, main);
        std::vector<PatchedCell> patched;
        for (int j = main.mirror_row; j < cells; ++j) {
            for (int i = 0; i < cells; ++i) {
                CellUse use = UseOf(main, i, j, roughness);
                if (use == CellUse::kPatched) {
                    if (spec_.patch_cells > 0 && patched.size() < kMostPatches) {
                        patched.push_back({i, j, PatchCells(main, i, j, roughness)});
                    } else {
                        use = LeftAsItIs(main, i, j);
                    }
                }
                main.grid.cells[main.grid.Cell(i, j)] = use;
                if (main.mirror_row > 0) {
                    main.grid.cells[main.grid.Cell(i, cells - 1 - j)] = use;
                }
            }
        }
        for (RawGrid& patch : tracer_.Patches(main.grid, patched)) {
            MeshGrid& grid = patch.grid;
            for (int j = 0; j + 1 < grid.nv; ++j) {
                for (int i = 0; i + 1 < grid.nu; ++i) {
                    CellUse& use = grid.cells[grid.Cell(i, j)];
                    if (use == CellUse::kUsed) use = LeftAsItIs(patch, i, j);
                }
            }
            const bool any = std::any_of(grid.cells.begin(), grid.cells.end(),
                                         [](CellUse use) { return use != CellUse::kOutside; });
            if (any) raw_.push_back(std::move(patch));
        }
    }

    // Half as many a side where the cell is but a little too rough.
    int PatchCells(const RawGrid& main, int i, int j, GridRoughness& roughness) const {
        for (const std::size_t ray : main.CornersOf(i, j)) {
            if (main.rays->state[ray] != VertexState::kAlive) return spec_.patch_cells;
        }
        const bool half = spec_.patch_cells % 2 == 0 && spec_.patch_cells >= 8 &&
                          roughness.Worst(i, j) < Roughness::kVery;
        return half ? spec_.patch_cells / 2 : spec_.patch_cells;
    }

    CellUse UseOf(const RawGrid& main, int i, int j, GridRoughness& roughness) const {
        const CellCorners corners = main.CornersOf(i, j);
        int living = 0;
        bool dead_inside = false;
        for (const std::size_t ray : corners) {
            living += main.rays->state[ray] == VertexState::kAlive ? 1 : 0;
            dead_inside = dead_inside || main.rays->state[ray] == VertexState::kDead;
        }
        const bool patch = living == 4 ? NearestRatio2(main, corners) < kNearlyPasses &&
                                             roughness.Worst(i, j) > Roughness::kSmooth
                                       : MayPassInPart(main, corners, living, dead_inside);
        return patch ? CellUse::kPatched : LeftAsItIs(main, i, j);
    }

    CellUse LeftAsItIs(const RawGrid& main, int i, int j) const {
        const CellCorners corners = main.CornersOf(i, j);
        for (const std::size_t ray : corners) {
            if (main.rays->state[ray] != VertexState::kAlive) return CellUse::kOutside;
        }
        return OutsideARim(main, corners) ? CellUse::kOutside : CellUse::kUsed;
    }

    // All four corners beyond one rim, and so far beyond that the cell's middle is too.
    bool OutsideARim(const RawGrid& raw, const CellCorners& corners) const {
        const std::size_t steps = tracer_.steps();
        for (std::size_t s = 0; s < steps; ++s) {
            bool outside = true;
            for (std::size_t k = 0; k < raw.rays->nodes.size() && outside; ++k) {
                const TraceColumns& node = raw.rays->nodes[k];
                const float* const ratio2 = &node.rim_ratio2[s * node.stride];
                const auto [lo, hi] = std::minmax({ratio2[corners[0]], ratio2[corners[1]],
                                                   ratio2[corners[2]], ratio2[corners[3]]});
                if (lo <= 1.0F) {
                    outside = false;
                } else {
                    const double near = RimField(static_cast<double>(lo));
                    outside = near - 0.3 * (RimField(static_cast<double>(hi)) - near) > 0.0;
                }
            }
            if (outside) return true;
        }
        return false;
    }

    bool MayPassInPart(const RawGrid& raw, const CellCorners& corners, int living,
                       bool dead_inside) const {
        if (living == 0) return false;
        if (dead_inside) return true;
        // Every dead corner had left the rims; the cell matters only if a living one has not, or
        // nearly has not.
        return NearestRatio2(raw, corners) < kNearlyPasses;
    }

    static double NearestRatio2(const RawGrid& raw, const CellCorners& corners) {
        double nearest = 1e30;
        for (const std::size_t ray : corners) {
            nearest = std::min(nearest, static_cast<double>(raw.rays->smallest_rim[ray]));
        }
        return nearest;
    }

    // A rim is kept if it cuts a used cell: some corner passes, or nearly does, another is beyond
    // the rim.
    void ChooseRims() {
        const std::size_t steps = tracer_.steps();
        std::vector<bool> active(steps, false);
        for (const RawGrid& raw : raw_) {
            std::vector<std::uint8_t> seen(raw.grid.Vertex(0, raw.grid.nv), 0);
            for (int j = raw.mirror_row; j + 1 < raw.grid.nv; ++j) {
                for (int i = 0; i + 1 < raw.grid.nu; ++i) {
                    const CellUse use = raw.grid.cells[raw.grid.Cell(i, j)];
                    if (use != CellUse::kUsed && use != CellUse::kTriangle) continue;
                    const CellCorners corners = raw.CornersOf(i, j);
                    if (NearestRatio2(raw, corners) > kNearlyPasses) continue;
                    for (const std::size_t ray : corners) {
                        if (raw.rays->state[ray] != VertexState::kAlive) continue;
                        if (std::exchange(seen[ray - raw.first], std::uint8_t{1}) == 0) {
                            MarkRims(*raw.rays, ray, active);
                        }
                    }
                }
            }
        }
        for (std::size_t s = 0; s < steps; ++s) {
            // The stop is the iris's affair.
            if (active[s] && tracer_.lists().front().steps[s].kind != InteractionKind::kStop) {
                mesh_.rims.push_back(static_cast<int>(s));
            }
        }
    }

    static void MarkRims(const TracedRays& rays, std::size_t ray, std::vector<bool>& active) {
        for (const TraceColumns& node : rays.nodes) {
            for (std::size_t s = 0; s < active.size(); ++s) {
                if (node.rim_ratio2[s * node.stride + ray] > 1.0F) active[s] = true;
            }
        }
    }

    // Adds the grid to the mesh, and the mirror image of a patch of a mirrored main grid.
    void PackGrid(const RawGrid& raw) {
        MeshGrid grid = raw.grid;
        const std::size_t vertices = grid.Vertex(0, grid.nv);
        grid.alive.resize(vertices);
        for (int j = 0; j < grid.nv; ++j) {
            for (int i = 0; i < grid.nu; ++i) {
                grid.alive[grid.Vertex(i, j)] =
                    raw.rays->state[raw.Ray(i, j)] == VertexState::kAlive;
            }
        }
        for (std::size_t k = 0; k < raw.rays->nodes.size(); ++k) {
            MeshNode node;
            node.wavelength_nm = tracer_.lists()[k].wavelength_nm;
            node.fields.resize(vertices * static_cast<std::size_t>(mesh_.stored_count()));
            node.passage.resize(vertices * tracer_.passage_count());
            for (int j = 0; j < grid.nv; ++j) {
                const float turned = j < raw.mirror_row ? -1.0F : 1.0F;
                for (int i = 0; i < grid.nu; ++i) {
                    const std::size_t v = grid.Vertex(i, j);
                    if (grid.alive[v] == 0) continue;
                    PackVertex(raw.rays->nodes[k], raw.Ray(i, j), turned, v, node);
                }
            }
            grid.nodes.push_back(std::move(node));
        }
        const bool mirrored = raw_.front().mirror_row > 0 && raw.mirror_row == 0;
        if (mirrored) {
            MeshGrid image = MirrorImage(grid);
            mesh_.grids.push_back(std::move(grid));
            mesh_.grids.push_back(std::move(image));
        } else {
            mesh_.grids.push_back(std::move(grid));
        }
    }

    // `turned` is -1 for a mirror image, else 1.
    void PackVertex(const TraceColumns& from, std::size_t ray, float turned, std::size_t vertex,
                    MeshNode& node) const {
        const float x = tracer_.mirrored_axis() == 0 ? turned : 1.0F;
        const float y = tracer_.mirrored_axis() == 0 ? 1.0F : turned;
        float* out = &node.fields[vertex * static_cast<std::size_t>(mesh_.stored_count())];
        *out++ = x * from.exit_x[ray];
        *out++ = y * from.exit_y[ray];
        for (std::size_t c = 0; c < tracer_.crossings(); ++c) {
            *out++ = x * from.stop_x[c * from.stride + ray];
            *out++ = y * from.stop_y[c * from.stride + ray];
        }
        for (const int rim : mesh_.rims) {
            const float r2 = from.rim_ratio2[static_cast<std::size_t>(rim) * from.stride + ray];
            *out++ = static_cast<float>(RimField(static_cast<double>(r2)));
        }
        *out++ = x * from.slope_x[ray];
        *out++ = y * from.slope_y[ray];
        float* passage = &node.passage[vertex * tracer_.passage_count()];
        for (std::size_t s = 0; s < tracer_.steps(); ++s) {
            *passage++ = from.rare_cos2[s * from.stride + ray];
        }
        for (std::size_t a = 0; a < tracer_.absorbing().size(); ++a) {
            *passage++ = from.segment_mm[a * from.stride + ray];
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

    const MeshSpec& spec_;
    const Lens& lens_;
    GridTracer tracer_;
    double sensor_gap_mm_;
    std::vector<RawGrid> raw_;  // the main grid, then patches
    GhostMesh mesh_;
};

}  // namespace

Fingerprint MeshKey(const Lens& lens, const MeshSpec& spec) {
    Fingerprinter hash;
    hash.Add("ghost mesh").Add(kTracerVersion).Add(lens.geometry_fingerprint());
    hash.Add(static_cast<int>(spec.sequence.size()));
    for (const int surface : spec.sequence) hash.Add(surface);
    hash.Add(spec.field_rad).Add(spec.azimuth_rad).Add(spec.inverse_distance);
    const bool at_sensor = std::find(spec.sequence.begin(), spec.sequence.end(),
                                     lens.sensor_index()) != spec.sequence.end();
    hash.Add(at_sensor ? lens.sensor_z_mm() : 0.0);
    hash.Add(at_sensor ? lens.sensor()->semi_diameter_mm : 0.0);
    hash.Add(static_cast<int>(spec.wavelengths_nm.size()));
    for (const double wavelength : spec.wavelengths_nm) hash.Add(wavelength);
    hash.Add(spec.cells).Add(spec.patch_cells);
    hash.Add(spec.position_tolerance_mm).Add(spec.mask_tolerance).Add(spec.cosine_tolerance);
    // The search for the pass region is in floats whatever the grids are traced in.
    hash.Add(static_cast<int>(spec.arithmetic)).Add(ArithmeticClass());
    return hash.value();
}

GhostMesh BuildMesh(const Lens& lens, const MeshSpec& spec) {
    Builder builder(lens, spec, spec.arithmetic);
    const PassRegion region = builder.Region();
    if (builder.Build(region)) return builder.Take();
    const GhostMesh refused = builder.Take();
    Builder exact(lens, spec, MeshArithmetic::kDouble);
    exact.Build(region);
    GhostMesh mesh = exact.Take();
    mesh.rays_traced += refused.rays_traced - region.rays;
    mesh.ray_surfaces += refused.ray_surfaces - region.ray_surfaces;
    return mesh;
}

}  // namespace flare
