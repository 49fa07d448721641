// SPDX-License-Identifier: Apache-2.0
//
// Grids are traced raw, with the rim ratio of every interaction (raw_grid.h). Here is decided which
// of their cells light can use and which need a finer patch.
#include "core/mesh/mesh_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/mesh/grid_roughness.h"
#include "core/mesh/mesh_packer.h"
#include "core/mesh/pass_region.h"
#include "core/mesh/raw_grid.h"

namespace flare {
namespace {

constexpr int kTracerVersion = 5;  // part of every key: raise when traced values change

// Bounds the memory of a mesh that hardly any ray survives; past it cells that have four living
// corners stay as they are and others are left out.
constexpr std::size_t kMostPatches = 4096;

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
        AddPatches(UseMainCells());
        PackGrids(tracer_, raw_, mesh_);
        return true;
    }

    // After Build.
    GhostMesh Take() {
        mesh_.rays_traced += tracer_.rays();
        mesh_.ray_surfaces += tracer_.ray_surfaces();
        return std::move(mesh_);
    }

  private:
    // Decides the use of each main cell: that of a patch where a cell that may pass has a dead
    // corner or is rough. A mirrored grid's lower half follows its upper one. The cells to patch.
    std::vector<PatchedCell> UseMainCells() {
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
                SetUse(i, j, use);
            }
        }
        return patched;
    }

    // Cells that ask for a fine patch get one half as fine first: it shows whether any light passes
    // and often is good enough.
    void AddPatches(std::vector<PatchedCell> cells) {
        std::vector<PatchedCell> fine;
        const int half = spec_.patch_cells / 2;
        if (MayHalve()) {
            std::vector<PatchedCell> halved = cells;
            for (PatchedCell& cell : halved) cell.cells = half;
            std::vector<RawGrid> patches = tracer_.Patches(raw_.front().grid, halved);
            for (std::size_t n = 0; n < patches.size(); ++n) {
                if (!UsePatch(patches[n])) {
                    SetUse(cells[n].i, cells[n].j, CellUse::kOutside);
                } else if ((cells[n].cells > half || !patches[n].grid.smooth) &&
                           !GoodEnough(patches[n])) {
                    fine.push_back(cells[n]);
                } else {
                    raw_.push_back(std::move(patches[n]));
                }
            }
        } else {
            fine = std::move(cells);
        }
        std::vector<RawGrid> patches = tracer_.Patches(raw_.front().grid, fine);
        for (std::size_t n = 0; n < patches.size(); ++n) {
            if (UsePatch(patches[n])) {
                raw_.push_back(std::move(patches[n]));
            } else {
                SetUse(fine[n].i, fine[n].j, CellUse::kOutside);
            }
        }
    }

    bool MayHalve() const { return spec_.patch_cells % 2 == 0 && spec_.patch_cells >= 8; }

    // Leaves out the cells of a patch that do not pass; false if none does.
    bool UsePatch(RawGrid& patch) const {
        MeshGrid& grid = patch.grid;
        bool any = false;
        for (int j = 0; j + 1 < grid.nv; ++j) {
            for (int i = 0; i + 1 < grid.nu; ++i) {
                CellUse& use = grid.cells[grid.Cell(i, j)];
                if (use != CellUse::kOutside && OutsideARim(patch, patch.CornersOf(i, j)))
                    use = CellUse::kOutside;
                any = any || use != CellUse::kOutside;
            }
        }
        return any;
    }

    bool GoodEnough(const RawGrid& patch) const {
        if (!patch.grid.smooth) return false;
        GridRoughness roughness(tracer_, spec_, lens_, patch);
        const int cells = patch.grid.nu - 1;
        for (int j = 0; j < cells; ++j) {
            for (int i = 0; i < cells; ++i) {
                if (roughness.Worst(i, j) > Roughness::kSmooth) return false;
            }
        }
        return true;
    }

    // Of a cell of the main grid and of its mirror image.
    void SetUse(int i, int j, CellUse use) {
        RawGrid& main = raw_.front();
        main.grid.cells[main.grid.Cell(i, j)] = use;
        if (main.mirror_row > 0) main.grid.cells[main.grid.Cell(i, main.grid.nv - 2 - j)] = use;
    }

    // Half as many a side where the cell is but a little too rough.
    int PatchCells(const RawGrid& main, int i, int j, GridRoughness& roughness) const {
        for (const std::size_t ray : main.CornersOf(i, j)) {
            if (main.rays->state[ray] != VertexState::kAlive) return spec_.patch_cells;
        }
        const bool half = MayHalve() && roughness.Worst(i, j) < Roughness::kVery;
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
        const bool patch = living == 4 ? main.NearestRatio2(corners) < kNearlyPasses &&
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

    // All living corners beyond one rim, and so far beyond that the cell's middle is too.
    bool OutsideARim(const RawGrid& raw, const CellCorners& corners) const {
        for (const std::size_t ray : corners) {
            // Within all rims at some wavelength.
            if (raw.rays->state[ray] == VertexState::kAlive && raw.rays->smallest_rim[ray] <= 1.0F)
                return false;
        }
        const std::size_t steps = tracer_.steps();
        for (std::size_t s = 0; s < steps; ++s) {
            bool outside = true;
            for (std::size_t k = 0; k < raw.rays->nodes.size() && outside; ++k) {
                const TraceColumns& node = raw.rays->nodes[k];
                const float* const ratio2 = &node.rim_ratio2[s * node.stride];
                float lo = 1e30F, hi = 0.0F;
                for (const std::size_t ray : corners) {
                    if (raw.rays->state[ray] != VertexState::kAlive) continue;
                    lo = std::min(lo, ratio2[ray]);
                    hi = std::max(hi, ratio2[ray]);
                }
                if (lo <= 1.0F) {
                    outside = false;
                } else {
                    const double near = RimField(static_cast<double>(lo));
                    const double far = RimField(static_cast<double>(hi));
                    outside = near - 0.3 * (far - near) > 0.0;
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
        return raw.NearestRatio2(corners) < kNearlyPasses;
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
