// SPDX-License-Identifier: Apache-2.0
//
// A grid is traced raw, with the rim ratio of every interaction; then the rims that cut the ghost
// are found and only those are kept. The light lies in the meridional plane, so the main grid is
// traced for v >= 0 and mirrored.
#include "core/mesh/mesh_builder.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/check.h"
#include "core/mesh/pass_region.h"
#include "core/mesh/transmission.h"

namespace flare {
namespace {

constexpr int kTracerVersion = 3;  // part of every key: raise when traced values change

// Cells beyond the pass region on each side, so that the masks' edges lie inside the grid with
// neighbours for cubic interpolation.
constexpr double kGuardCells = 1.5;

// Bounds the memory of a mesh that hardly any ray survives; past it cells that have four living
// corners stay as they are and others are left out.
constexpr std::size_t kMostPatches = 4096;

// Squared cosines below this are near total reflection.
constexpr double kNearCritical = 0.1;

// Cells whose best corner has a larger (distance / semi-diameter)^2 than this at some rim do not
// pass.
constexpr double kNearlyPasses = 1.05;

struct RawNode {
    std::vector<float> exit;     // [vertex][x, y, dx/dz, dy/dz] at the last vertex
    std::vector<float> stops;    // [vertex][2 * crossings]
    std::vector<float> rims;     // [vertex][interaction], see GhostMesh
    std::vector<float> passage;  // [vertex][passage], see transmission.h
};

// How a vertex counts for the masks at all wavelengths.
enum class VertexState : std::uint8_t { kAlive, kDead, kDeadOutside };

struct RawGrid {
    MeshGrid grid;
    std::vector<RawNode> nodes;
    std::vector<VertexState> state;
    std::vector<float>
        smallest_rim;  // [vertex] over wavelengths: largest rim ratio^2 met (rims, stop)
};

using CellCorners = std::array<std::size_t, 4>;

CellCorners CornersOf(const MeshGrid& grid, int i, int j) {
    return {grid.Vertex(i, j), grid.Vertex(i + 1, j), grid.Vertex(i, j + 1),
            grid.Vertex(i + 1, j + 1)};
}

class Builder {
  public:
    Builder(const Lens& lens, const MeshSpec& spec)
        : spec_(spec),
          bundle_(lens, spec.field_rad, spec.inverse_distance, spec.azimuth_rad),
          sensor_gap_mm_(lens.nominal_sensor_gap_mm()) {
        for (const double wavelength : spec.wavelengths_nm) {
            lists_.push_back(WriteOut(lens, spec.sequence, wavelength));
            // Traced to the last vertex, wherever the sensor stands: not even the last bit may
            // depend on the focus.
            lists_.back().sensor_z_mm = lens.surfaces().back().vertex_z_mm;
        }
        mesh_.sequence = spec.sequence;
        mesh_.field_rad = spec.field_rad;
        mesh_.azimuth_rad = spec.azimuth_rad;
        mesh_.inverse_distance = spec.inverse_distance;
        mesh_.absorbing = AbsorbingSteps(lens, spec.sequence);
        mesh_.stop_crossings = lists_.front().stop_crossings;
        mesh_.interactions = static_cast<int>(lists_.front().steps.size());
        stop_semi_diameter_mm_ =
            lens.surfaces()[static_cast<std::size_t>(lens.stop_index())].semi_diameter_mm;
    }

    GhostMesh Build() {
        const PassRegion region = FindPassRegion(lists_, bundle_);
        mesh_.rays_traced += region.rays;
        mesh_.ray_surfaces += region.ray_surfaces;
        if (!region.rect) return std::move(mesh_);

        std::vector<RawGrid> raw;
        raw.push_back(MainGrid(*region.rect));
        UseMainCells(raw);
        ChooseRims(raw);
        for (RawGrid& r : raw) mesh_.grids.push_back(Pack(std::move(r)));
        return std::move(mesh_);
    }

  private:
    RawGrid MainGrid(const Rect& rect) {
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

    RawGrid Patch(const MeshGrid& main, int ci, int cj) {
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

    void Allocate(RawGrid& raw) const {
        const auto vertices =
            static_cast<std::size_t>(raw.grid.nu) * static_cast<std::size_t>(raw.grid.nv);
        const auto steps = static_cast<std::size_t>(mesh_.interactions);
        raw.grid.cells.assign(
            static_cast<std::size_t>(raw.grid.nu - 1) * static_cast<std::size_t>(raw.grid.nv - 1),
            CellUse::kOutside);
        raw.state.assign(vertices, VertexState::kAlive);
        raw.smallest_rim.assign(vertices, 0.0F);
        for (std::size_t k = 0; k < lists_.size(); ++k) {
            RawNode node;
            node.exit.assign(vertices * 4, 0.0F);
            node.stops.assign(vertices * 2 * static_cast<std::size_t>(mesh_.stop_crossings), 0.0F);
            node.rims.assign(vertices * steps, 0.0F);
            node.passage.assign(vertices * PassageCount(), 0.0F);
            raw.nodes.push_back(std::move(node));
        }
    }

    void TraceVertex(RawGrid& raw, int i, int j) {
        const std::size_t vertex = raw.grid.Vertex(i, j);
        const Ray ray = bundle_.At(raw.grid.u0 + i * raw.grid.du, raw.grid.v0 + j * raw.grid.dv);
        TraceOptions options;
        options.clip = false;
        double smallest = 1e30;
        for (std::size_t k = 0; k < lists_.size(); ++k) {
            const TraceResult result = TraceRay(lists_[k], ray, options, &record_);
            ++mesh_.rays_traced;
            mesh_.ray_surfaces += record_.rim_ratio2.size();
            const double largest =
                record_.rim_ratio2.empty()
                    ? 0.0
                    : *std::max_element(record_.rim_ratio2.begin(), record_.rim_ratio2.end());
            smallest = std::min(smallest, largest);
            if (result.fate != RayFate::kArrived || result.out_of_order_inside) {
                // A ray that left the rims before it died would not have passed anyway.
                const VertexState now =
                    largest > 1.0 ? VertexState::kDeadOutside : VertexState::kDead;
                if (raw.state[vertex] != VertexState::kDead) raw.state[vertex] = now;
                continue;
            }
            Store(raw.nodes[k], lists_[k], vertex, result);
        }
        raw.smallest_rim[vertex] = static_cast<float>(std::min(smallest, 1e30));
    }

    void Store(RawNode& node, const InteractionList& list, std::size_t vertex,
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
        const auto steps = static_cast<std::size_t>(mesh_.interactions);
        for (std::size_t s = 0; s < steps; ++s) {
            const Interaction& step = list.steps[s];
            const double cos_in = record_.cos_in[s];
            const double eta = step.n_in / step.n_out;
            const double rare =
                eta <= 1.0 ? cos_in * cos_in : 1.0 - eta * eta * (1.0 - cos_in * cos_in);
            const double r2 = record_.rim_ratio2[s];
            node.rims[vertex * steps + s] = static_cast<float>((r2 - 1.0) / (r2 + 1.0));
            node.passage[vertex * PassageCount() + s] = static_cast<float>(rare);
        }
        for (std::size_t a = 0; a < mesh_.absorbing.size(); ++a) {
            node.passage[vertex * PassageCount() + steps + a] = static_cast<float>(
                record_.segment_mm[static_cast<std::size_t>(mesh_.absorbing[a])]);
        }
    }

    void MirrorVertex(RawGrid& raw, std::size_t from, std::size_t to) const {
        raw.state[to] = raw.state[from];
        raw.smallest_rim[to] = raw.smallest_rim[from];
        const auto steps = static_cast<std::size_t>(mesh_.interactions);
        const auto crossings = static_cast<std::size_t>(mesh_.stop_crossings);
        for (RawNode& node : raw.nodes) {
            for (std::size_t pair = 0; pair < 2; ++pair) {
                MirrorPair(&node.exit[from * 4 + 2 * pair], &node.exit[to * 4 + 2 * pair]);
            }
            for (std::size_t c = 0; c < crossings; ++c) {
                MirrorPair(&node.stops[(from * crossings + c) * 2],
                           &node.stops[(to * crossings + c) * 2]);
            }
            const auto copy = [&](std::vector<float>& values, std::size_t stride) {
                std::copy_n(&values[from * stride], stride, &values[to * stride]);
            };
            copy(node.rims, steps);
            copy(node.passage, PassageCount());
        }
    }

    // Mirrors x, y in the plane of light and axis: the x-z plane or, for an anamorphic lens lit
    // from there, the y-z plane.
    void MirrorPair(const float* from, float* to) const {
        const bool in_y = spec_.azimuth_rad != 0.0;
        to[0] = in_y ? -from[0] : from[0];
        to[1] = in_y ? from[1] : -from[1];
    }

    std::size_t PassageCount() const { return static_cast<std::size_t>(mesh_.passage_count()); }

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
                    raw.push_back(Patch(raw.front().grid, i, j));
                } else if (living == 4) {
                    use = OutsideARim(main, corners) ? CellUse::kOutside : CellUse::kUsed;
                }
            }
        }
    }

    // All four corners beyond one rim, and so far beyond that the cell's middle is too.
    bool OutsideARim(const RawGrid& raw, const CellCorners& corners) const {
        const auto steps = static_cast<std::size_t>(mesh_.interactions);
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
        const auto stop_values = 2 * static_cast<std::size_t>(mesh_.stop_crossings);
        for (std::size_t s = 0; s < stop_values; ++s) {
            if (miss(node.stops, stop_values, s) > spec_.mask_tolerance * stop_semi_diameter_mm_)
                return true;
        }
        const auto steps = static_cast<std::size_t>(mesh_.interactions);
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
                return static_cast<double>(node.passage[v[k] * PassageCount() + s]);
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
        const auto steps = static_cast<std::size_t>(mesh_.interactions);
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
            if (active[s] && lists_.front().steps[s].kind != InteractionKind::kStop) {
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
        const auto steps = static_cast<std::size_t>(mesh_.interactions);
        const auto fields = static_cast<std::size_t>(mesh_.stored_count());
        const auto stop_values = 2 * static_cast<std::size_t>(mesh_.stop_crossings);
        const std::size_t vertices = raw.state.size();
        grid.alive.resize(vertices);
        for (std::size_t v = 0; v < vertices; ++v)
            grid.alive[v] = raw.state[v] == VertexState::kAlive;
        for (std::size_t k = 0; k < raw.nodes.size(); ++k) {
            RawNode& from = raw.nodes[k];
            MeshNode node;
            node.wavelength_nm = lists_[k].wavelength_nm;
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
    LightBundle bundle_;
    std::vector<InteractionList> lists_;
    double stop_semi_diameter_mm_ = 0.0;
    double sensor_gap_mm_;
    RayRecord record_;
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
