// SPDX-License-Identifier: Apache-2.0
//
// Grids are traced raw, with the rim ratio of every interaction (raw_grid.h). Here is decided which
// of their cells light can use, which need a finer patch, and which rims cut the ghost: only those
// are kept.
#include "core/mesh/mesh_builder.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/mesh/pass_region.h"
#include "core/mesh/raw_grid.h"

namespace flare {
namespace {

constexpr int kTracerVersion = 3;  // part of every key: raise when traced values change

// Bounds the memory of a mesh that hardly any ray survives; past it cells that have four living
// corners stay as they are and others are left out.
constexpr std::size_t kMostPatches = 4096;

// Squared cosines below this are near total reflection.
constexpr double kNearCritical = 0.1;

// Cells whose best corner has a larger (distance / semi-diameter)^2 than this at some rim do not
// pass.
constexpr double kNearlyPasses = 1.05;

class Builder {
  public:
    Builder(const Lens& lens, const MeshSpec& spec)
        : spec_(spec), tracer_(lens, spec), sensor_gap_mm_(lens.nominal_sensor_gap_mm()) {
        mesh_.sequence = spec.sequence;
        mesh_.field_rad = spec.field_rad;
        mesh_.azimuth_rad = spec.azimuth_rad;
        mesh_.inverse_distance = spec.inverse_distance;
        mesh_.absorbing = tracer_.absorbing();
        mesh_.stop_crossings = static_cast<int>(tracer_.crossings());
        mesh_.interactions = static_cast<int>(tracer_.steps());
        stop_semi_diameter_mm_ =
            lens.surfaces()[static_cast<std::size_t>(lens.stop_index())].semi_diameter_mm;
    }

    GhostMesh Build() {
        const PassRegion region = FindPassRegion(tracer_.lists(), tracer_.bundle());
        if (region.rect) {
            std::vector<RawGrid> raw;
            raw.push_back(tracer_.MainGrid(*region.rect));
            UseMainCells(raw);
            ChooseRims(raw);
            for (RawGrid& r : raw) mesh_.grids.push_back(Pack(std::move(r)));
        }
        mesh_.rays_traced = region.rays + tracer_.rays();
        mesh_.ray_surfaces = region.ray_surfaces + tracer_.ray_surfaces();
        return std::move(mesh_);
    }

  private:
    // Decides the use of each main cell and adds a patch where a cell that may pass has a dead
    // corner.
    void UseMainCells(std::vector<RawGrid>& raw) {
        const int cells = spec_.cells;
        for (int j = 0; j < cells; ++j) {
            for (int i = 0; i < cells; ++i) {
                RawGrid& main = raw.front();
                const CellCorners corners = CornersOf(main.grid, i, j);
                int living = 0;
                bool dead_inside = false;
                for (const std::size_t v : corners) {
                    living += main.state[v] == VertexState::kAlive ? 1 : 0;
                    dead_inside = dead_inside || main.state[v] == VertexState::kDead;
                }
                CellUse& use = main.grid.cells[main.grid.Cell(i, j)];
                const bool patch = living == 4 ? NearestRatio2(main, corners) < kNearlyPasses &&
                                                     RoughCell(main, i, j)
                                               : MayPassInPart(main, corners, living, dead_inside);
                if (patch && raw.size() <= kMostPatches) {
                    use = CellUse::kPatched;
                    raw.push_back(tracer_.Patch(raw.front().grid, i, j));
                } else if (living == 4) {
                    use = OutsideARim(main, corners) ? CellUse::kOutside : CellUse::kUsed;
                }
            }
        }
    }

    // All four corners beyond one rim, and so far beyond that the cell's middle is too.
    bool OutsideARim(const RawGrid& raw, const CellCorners& corners) const {
        const std::size_t steps = tracer_.steps();
        for (std::size_t s = 0; s < steps; ++s) {
            bool outside = true;
            for (std::size_t k = 0; k < raw.nodes.size() && outside; ++k) {
                double lo = 1.0;
                double hi = -1.0;
                for (const std::size_t v : corners) {
                    const auto rim = static_cast<double>(raw.nodes[k].rims[v * steps + s]);
                    lo = std::min(lo, rim);
                    hi = std::max(hi, rim);
                }
                outside = lo - 0.3 * (hi - lo) > 0.0;
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

    // Is cubic interpolation not good enough at some corner of the cell?
    bool RoughCell(const RawGrid& raw, int i, int j) const {
        for (const int k : {0, 1}) {
            for (const int l : {0, 1}) {
                if (Rough(raw, i + k, j + l, 1, 0) || Rough(raw, i + k, j + l, 0, 1)) return true;
            }
        }
        return false;
    }

    // Predicts the middle one of five values from two neighbours on each side. The miss is h^4
    // f''''/6; a cubic through the values is wrong by at most 3/128 h^4 f'''' between them, 0.14
    // times that.
    template <class Field>
    static double Miss(Field f) {
        constexpr double kShare = 0.14;
        return kShare * std::abs(f(2) - (4.0 * (f(1) + f(3)) - f(0) - f(4)) / 6.0);
    }

    // At a vertex, along one direction.
    bool Rough(const RawGrid& raw, int i, int j, int di, int dj) const {
        const int n = spec_.cells;
        if (i - 2 * di < 0 || j - 2 * dj < 0 || i + 2 * di > n || j + 2 * dj > n) return false;
        std::array<std::size_t, 5> v{};
        for (int k = -2; k <= 2; ++k) {
            v[static_cast<std::size_t>(k + 2)] = raw.grid.Vertex(i + k * di, j + k * dj);
        }
        // Next to dead rays slopes are of lower order; only close to them does that show.
        if (raw.state[v[1]] != VertexState::kAlive || raw.state[v[3]] != VertexState::kAlive)
            return true;
        if (raw.state[v[0]] != VertexState::kAlive || raw.state[v[4]] != VertexState::kAlive)
            return false;
        const RawNode& node = raw.nodes[raw.nodes.size() / 2];
        const auto miss = [&](const std::vector<float>& field, std::size_t stride, std::size_t at) {
            return Miss(
                [&](std::size_t k) { return static_cast<double>(field[v[k] * stride + at]); });
        };
        // On the sensor where it stands at infinity, so that the mesh is the same for every focus.
        for (const std::size_t axis : {0U, 1U}) {
            const auto place = [&](std::size_t k) {
                const float* const exit = &node.exit[v[k] * 4];
                return static_cast<double>(exit[axis]) +
                       sensor_gap_mm_ * static_cast<double>(exit[axis + 2]);
            };
            if (Miss(place) > spec_.position_tolerance_mm) return true;
        }
        const std::size_t stop_values = 2 * tracer_.crossings();
        for (std::size_t s = 0; s < stop_values; ++s) {
            if (miss(node.stops, stop_values, s) > spec_.mask_tolerance * stop_semi_diameter_mm_)
                return true;
        }
        const std::size_t steps = tracer_.steps();
        for (std::size_t s = 0; s < steps; ++s) {
            if (NearRim(node, v[2] * steps + s) &&
                miss(node.rims, steps, s) > spec_.mask_tolerance) {
                return true;
            }
        }
        // Transmittances follow the cosines steeply near the critical angle, and are interpolated
        // linearly.
        for (std::size_t s = 0; s < steps; ++s) {
            const auto c2 = [&](std::size_t k) {
                return static_cast<double>(node.passage[v[k] * tracer_.passage_count() + s]);
            };
            if (std::abs(c2(2)) < kNearCritical &&
                std::abs(c2(1) - 2.0 * c2(2) + c2(3)) > spec_.cosine_tolerance * 8.0) {
                return true;
            }
        }
        return false;
    }

    // Only near the rim does its field matter.
    static bool NearRim(const RawNode& node, std::size_t at) {
        return std::abs(static_cast<double>(node.rims[at])) < 0.5;
    }

    static double NearestRatio2(const RawGrid& raw, const CellCorners& corners) {
        double nearest = 1e30;
        for (const std::size_t v : corners) {
            nearest = std::min(nearest, static_cast<double>(raw.smallest_rim[v]));
        }
        return nearest;
    }

    // A rim is kept if it cuts a used cell: some corner passes, or nearly does, another is beyond
    // the rim.
    void ChooseRims(const std::vector<RawGrid>& raw) {
        const std::size_t steps = tracer_.steps();
        std::vector<bool> active(steps, false);
        for (const RawGrid& r : raw) {
            for (int j = 0; j + 1 < r.grid.nv; ++j) {
                for (int i = 0; i + 1 < r.grid.nu; ++i) {
                    const CellUse use = r.grid.cells[r.grid.Cell(i, j)];
                    if (use != CellUse::kUsed && use != CellUse::kTriangle) continue;
                    const CellCorners corners = CornersOf(r.grid, i, j);
                    if (NearestRatio2(r, corners) > kNearlyPasses) continue;
                    for (const std::size_t v : corners) {
                        if (r.state[v] == VertexState::kAlive) MarkRims(r, v, active);
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

    void MarkRims(const RawGrid& raw, std::size_t vertex, std::vector<bool>& active) const {
        const std::size_t steps = active.size();
        for (const RawNode& node : raw.nodes) {
            for (std::size_t s = 0; s < steps; ++s) {
                if (node.rims[vertex * steps + s] > 0.0F) active[s] = true;
            }
        }
    }

    MeshGrid Pack(RawGrid&& raw) const {
        MeshGrid grid = std::move(raw.grid);
        const std::size_t steps = tracer_.steps();
        const auto fields = static_cast<std::size_t>(mesh_.stored_count());
        const std::size_t stop_values = 2 * tracer_.crossings();
        const std::size_t vertices = raw.state.size();
        grid.alive.resize(vertices);
        for (std::size_t v = 0; v < vertices; ++v)
            grid.alive[v] = raw.state[v] == VertexState::kAlive;
        for (std::size_t k = 0; k < raw.nodes.size(); ++k) {
            RawNode& from = raw.nodes[k];
            MeshNode node;
            node.wavelength_nm = tracer_.lists()[k].wavelength_nm;
            node.fields.resize(vertices * fields);
            for (std::size_t v = 0; v < vertices; ++v) {
                float* out = &node.fields[v * fields];
                *out++ = from.exit[v * 4];
                *out++ = from.exit[v * 4 + 1];
                for (std::size_t s = 0; s < stop_values; ++s)
                    *out++ = from.stops[v * stop_values + s];
                for (const int rim : mesh_.rims) {
                    *out++ = from.rims[v * steps + static_cast<std::size_t>(rim)];
                }
                *out++ = from.exit[v * 4 + 2];
                *out++ = from.exit[v * 4 + 3];
            }
            node.passage = std::move(from.passage);
            grid.nodes.push_back(std::move(node));
        }
        return grid;
    }

    const MeshSpec& spec_;
    GridTracer tracer_;
    double stop_semi_diameter_mm_ = 0.0;
    double sensor_gap_mm_;
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
    return hash.value();
}

GhostMesh BuildMesh(const Lens& lens, const MeshSpec& spec) {
    return Builder(lens, spec).Build();
}

}  // namespace flare
