// SPDX-License-Identifier: Apache-2.0
#include "core/render/cell_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/render/ghost_light.h"
#include "core/spectrum/wavelength_plan.h"

namespace flare {

// Points of a ghost's cells and the light there: transmittance times flux density, many points at
// once.
class LightPoints {
  public:
    LightPoints(const GhostSurface& surface, const LightBundle& bundle)
        : surface_(surface), mesh_(surface.mesh()), bundle_(bundle) {}

    // A corner of the cell, or where the corner is dead what the parallelogram rule makes of it.
    // Returns the point's number.
    std::uint32_t AddCorner(const CellPlace& place, int i, int j) {
        return AddBilinear(place, i, j);
    }

    // (a, b) in the cell, 0..1: passages are cubic through the vertices around it, bilinear next to
    // dead ones.
    std::uint32_t Add(const CellPlace& place, double a, double b) {
        const MeshGrid& grid = mesh_.grids[static_cast<std::size_t>(place.grid)];
        if (!HasNeighbours(place, grid)) return AddBilinear(place, a, b);
        Point& point = NewPoint(place, a, b);
        const std::array<double, 4> across = CubicShares(a);
        const std::array<double, 4> up = CubicShares(b);
        for (std::size_t k = 0; k < 16; ++k) {
            point.vertices[k] = grid.Vertex(place.i - 1 + static_cast<int>(k % 4),
                                            place.j - 1 + static_cast<int>(k / 4));
            point.shares[k] = static_cast<float>(across[k % 4] * up[k / 4]);
        }
        point.count = 16;
        return static_cast<std::uint32_t>(points_.size() - 1);
    }

    // [point][which of `bands`]
    std::vector<float> LightIn(const PathInColumns& path, const std::vector<std::size_t>& bands) {
        // So many that their passages stay in the second-level cache.
        constexpr std::size_t kAtOnce = 1024;
        std::vector<float> light(points_.size() * bands.size());
        std::vector<float> weights;
        for (std::size_t first = 0; first < points_.size(); first += kAtOnce) {
            const std::size_t count = std::min(kAtOnce, points_.size() - first);
            Gather(first, count);
            for (std::size_t b = 0; b < bands.size(); ++b) {
                path.Weights(bands[b], columns_, weights);
                for (std::size_t k = 0; k < count; ++k) {
                    light[(first + k) * bands.size() + b] =
                        static_cast<float>(points_[first + k].density) * weights[k];
                }
            }
        }
        return light;
    }

  private:
    struct Point {
        const MeshGrid* grid = nullptr;
        std::array<std::size_t, 16> vertices{};
        std::array<float, 16> shares{};
        std::size_t count = 0;
        double density = 1.0;
    };

    // The values of a cubic through -1, 0, 1 and 2 that count at t.
    static std::array<double, 4> CubicShares(double t) {
        return {-t * (t - 1.0) * (t - 2.0) / 6.0, (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
                -(t + 1.0) * t * (t - 2.0) / 2.0, (t + 1.0) * t * (t - 1.0) / 6.0};
    }

    static bool HasNeighbours(const CellPlace& place, const MeshGrid& grid) {
        if (!grid.smooth || place.i < 1 || place.j < 1 || place.i + 2 >= grid.nu ||
            place.j + 2 >= grid.nv) {
            return false;
        }
        for (int j = -1; j <= 2; ++j) {
            for (int i = -1; i <= 2; ++i) {
                if (grid.alive[grid.Vertex(place.i + i, place.j + j)] == 0) return false;
            }
        }
        return true;
    }

    Point& NewPoint(const CellPlace& place, double a, double b) {
        const MeshGrid& grid = mesh_.grids[static_cast<std::size_t>(place.grid)];
        Point& point = points_.emplace_back();
        point.grid = &grid;
        point.density = bundle_.FluxDensity(grid.u0 + (place.i + a) * grid.du,
                                            grid.v0 + (place.j + b) * grid.dv);
        return point;
    }

    std::uint32_t AddBilinear(const CellPlace& place, double a, double b) {
        const MeshGrid& grid = mesh_.grids[static_cast<std::size_t>(place.grid)];
        Point& point = NewPoint(place, a, b);
        std::array<double, 4> shares = {(1.0 - a) * (1.0 - b), a * (1.0 - b), (1.0 - a) * b, a * b};
        if (surface_.UseOf(place) == CellUse::kTriangle) {
            const auto dead = static_cast<std::size_t>(surface_.DeadCorner(place));
            const double share = std::exchange(shares[dead], 0.0);
            shares[dead ^ 1U] += share;
            shares[dead ^ 2U] += share;
            shares[dead ^ 3U] -= share;
        }
        for (std::size_t k = 0; k < 4; ++k) {
            if (shares[k] == 0.0) continue;
            point.vertices[point.count] =
                grid.Vertex(place.i + static_cast<int>(k % 2), place.j + static_cast<int>(k / 2));
            point.shares[point.count] = static_cast<float>(shares[k]);
            ++point.count;
        }
        return static_cast<std::uint32_t>(points_.size() - 1);
    }

    // A few points at a time side by side, or every number would be written to a line of its own.
    void Gather(std::size_t first, std::size_t count) {
        constexpr std::size_t kBeside = 16;
        const auto passages = static_cast<std::size_t>(mesh_.passage_count());
        const std::size_t nodes = mesh_.grids.front().nodes.size();
        columns_.Resize(nodes, passages, count);
        sums_.resize(passages);
        beside_.resize(passages * kBeside);
        for (std::size_t n = 0; n < nodes; ++n) {
            for (std::size_t start = 0; start < columns_.stride; start += kBeside) {
                for (std::size_t k = 0; k < kBeside; ++k) {
                    // The last columns are filled up with the last point.
                    if (start + k < count) Mix(points_[first + start + k], n);
                    for (std::size_t s = 0; s < passages; ++s) beside_[s * kBeside + k] = sums_[s];
                }
                float* const out = &columns_.values[n * passages * columns_.stride + start];
                for (std::size_t s = 0; s < passages; ++s)
                    std::copy_n(&beside_[s * kBeside], kBeside, out + s * columns_.stride);
            }
        }
    }

    // A point's passages at one node, to sums_.
    void Mix(const Point& point, std::size_t node) {
        const float* const all = point.grid->nodes[node].passage.data();
        const std::size_t passages = sums_.size();
        float* const sums = sums_.data();
        std::fill_n(sums, passages, 0.0F);
        for (std::size_t c = 0; c < point.count; ++c) {
            const float share = point.shares[c];
            const float* const at = all + point.vertices[c] * passages;
            for (std::size_t s = 0; s < passages; ++s) sums[s] += share * at[s];
        }
    }

    const GhostSurface& surface_;
    const GhostMesh& mesh_;
    const LightBundle& bundle_;
    std::vector<Point> points_;
    PassageColumns columns_;
    std::vector<float> sums_, beside_;  // scratch of Gather
};

namespace {

// Passages at all corners of the surface's cells, whatever window is drawn.
PassageRange RangeOfPassages(const GhostSurface& surface) {
    const GhostMesh& mesh = surface.mesh();
    const auto passages = static_cast<std::size_t>(mesh.passage_count());
    PassageRange range(passages);
    std::vector<const float*> nodes;
    std::vector<std::uint8_t> seen;
    int grid_seen = -1;
    for (const CellPlace& cell : surface.cells()) {
        const MeshGrid& grid = mesh.grids[static_cast<std::size_t>(cell.grid)];
        if (cell.grid != grid_seen) seen.assign(grid.alive.size(), 0);
        grid_seen = cell.grid;
        for (int corner = 0; corner < 4; ++corner) {
            const std::size_t v = grid.Vertex(cell.i + corner % 2, cell.j + corner / 2);
            if (grid.alive[v] == 0 || std::exchange(seen[v], std::uint8_t{1}) != 0) continue;
            nodes.clear();
            for (const MeshNode& node : grid.nodes) nodes.push_back(&node.passage[v * passages]);
            range.Add(nodes);
        }
    }
    return range;
}

std::vector<std::vector<double>> WeightsOf(const GhostMesh& mesh,
                                           const TransmissionTables& tables) {
    const std::vector<double> traced = TracedWavelengths(mesh);
    std::vector<std::vector<double>> weights;
    for (const double wavelength : tables.wavelengths_nm())
        weights.push_back(NodeWeights(traced, wavelength));
    return weights;
}

}  // namespace

// Which point stands for a vertex: it serves four cells.
struct VertexPoints {
    static constexpr auto kNone = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::vector<std::uint32_t>> of_grid;

    explicit VertexPoints(const GhostMesh& mesh) : of_grid(mesh.grids.size()) {}
    std::uint32_t& At(const GhostMesh& mesh, int g, int i, int j) {
        const MeshGrid& grid = mesh.grids[static_cast<std::size_t>(g)];
        std::vector<std::uint32_t>& of = of_grid[static_cast<std::size_t>(g)];
        if (of.empty()) of.assign(grid.alive.size(), kNone);
        return of[grid.Vertex(i, j)];
    }
};

CellLight::CellLight(const GhostSurface& surface, const LightBundle& bundle,
                     const TransmissionTables& tables, const TransmissionTables::Path& path)
    : surface_(surface),
      mesh_(surface.mesh()),
      bundle_(bundle),
      path_(path, WeightsOf(mesh_, tables), RangeOfPassages(surface)) {}

std::vector<LightLift> CellLight::ChooseCuts(std::vector<GhostLight::Cell>& cells,
                                             double tolerance) const {
    const double brightest = Brightest();
    const std::size_t last = path_.bands() - 1;
    const std::vector<std::size_t> bands = {0, last / 2, last};
    std::vector<LightLift> lifts(cells.size());
    LightPoints samples(surface_, bundle_);
    VertexPoints vertices(mesh_);
    std::vector<std::array<std::uint32_t, kSamples>> at(cells.size());
    std::vector<std::uint8_t> critical(cells.size());
    for (std::size_t c = 0; c < cells.size(); ++c) {
        critical[c] = NearCriticalAngle(cells[c].place) ? 1 : 0;
        AddSamples(cells[c].place, critical[c] != 0, samples, vertices, at[c]);
    }
    const std::vector<float> light = samples.LightIn(path_, bands);
    for (std::size_t c = 0; c < cells.size(); ++c) {
        std::array<std::array<double, kSamples>, 3> values{};
        for (std::size_t b = 0; b < bands.size(); ++b) {
            for (std::size_t k = 0; k < kSamples; ++k)
                values[b][k] = static_cast<double>(light[at[c][k] * bands.size() + b]);
        }
        cells[c].light_cuts = CutsOf(values, brightest, tolerance, critical[c] != 0);
        if (cells[c].light_cuts > 1 || surface_.UseOf(cells[c].place) == CellUse::kTriangle)
            continue;
        for (std::size_t b = 0; b < bands.size(); ++b)
            lifts[c].factor[b] = LiftOf(values[b], brightest);
    }
    return lifts;
}

// Light that bends like a parabola has between its corners a mean that is off by two thirds of what
// the middle is off by.
float CellLight::LiftOf(const std::array<double, kSamples>& light, double brightest) {
    constexpr double kMost = 0.1;
    const double mean = 0.25 * (light[1] + light[2] + light[3] + light[4]);
    if (!(mean > kDim * kDim * brightest)) return 1.0F;
    const double lift = 2.0 / 3.0 * (light[0] - mean) / mean;
    return static_cast<float>(1.0 + std::clamp(lift, -kMost, kMost));
}

float LightLift::At(double share) const {
    const auto t = static_cast<float>(std::clamp(2.0 * share, 0.0, 2.0));
    return t < 1.0F ? factor[0] + t * (factor[1] - factor[0])
                    : factor[1] + (t - 1.0F) * (factor[2] - factor[1]);
}

std::vector<float> CellLight::Light(const std::vector<GhostLight::Cell>& cells,
                                    std::vector<std::uint32_t>& point_of) const {
    LightPoints points(surface_, bundle_);
    VertexPoints vertices(mesh_);
    for (const GhostLight::Cell& cell : cells) {
        const int cuts = cell.light_cuts;
        for (int j = 0; j <= cuts; ++j) {
            for (int i = 0; i <= cuts; ++i) {
                point_of.push_back(cuts == 1 ? AddCorner(cell.place, i, j, points, vertices)
                                             : points.Add(cell.place, static_cast<double>(i) / cuts,
                                                          static_cast<double>(j) / cuts));
            }
        }
    }
    std::vector<std::size_t> bands(path_.bands());
    std::iota(bands.begin(), bands.end(), std::size_t{0});
    return points.LightIn(path_, bands);
}

// Light at the middle of the brightest cell, at the middle wavelength, over the whole ghost: a
// crop is drawn as the frame is.
double CellLight::Brightest() const {
    LightPoints middles(surface_, bundle_);
    for (std::size_t k = 0; k < surface_.cells().size(); k += 3)
        middles.Add(surface_.cells()[k], 0.5, 0.5);
    const std::vector<float> light = middles.LightIn(path_, {(path_.bands() - 1) / 2});
    return static_cast<double>(*std::max_element(light.begin(), light.end()));
}

std::uint32_t CellLight::AddCorner(const CellPlace& place, int i, int j, LightPoints& points,
                                   VertexPoints& vertices) const {
    if (surface_.UseOf(place) == CellUse::kTriangle) return points.AddCorner(place, i, j);
    std::uint32_t& known = vertices.At(mesh_, place.grid, place.i + i, place.j + j);
    if (known == VertexPoints::kNone) known = points.AddCorner(place, i, j);
    return known;
}

void CellLight::AddSamples(const CellPlace& place, bool critical, LightPoints& points,
                           VertexPoints& vertices, std::array<std::uint32_t, kSamples>& at) const {
    at.fill(points.Add(place, 0.5, 0.5));
    for (std::size_t k = 0; k < 4; ++k) {
        at[1 + k] =
            AddCorner(place, static_cast<int>(k % 2), static_cast<int>(k / 2), points, vertices);
        if (critical) at[5 + k] = points.Add(place, k % 2 == 0 ? 0.25 : 0.75, k < 2 ? 0.25 : 0.75);
    }
}

// `light` is [band][sample].
int CellLight::CutsOf(const std::array<std::array<double, kSamples>, 3>& light, double brightest,
                      double tolerance, bool critical) {
    double miss = 0.0;
    double most = 0.0;
    for (const std::array<double, kSamples>& at : light) {
        const double mean = 0.25 * (at[1] + at[2] + at[3] + at[4]);
        const double scale = std::max({mean, kDim * brightest, 1e-300});
        most = std::max({most, mean, at[0]});
        miss = std::max(miss, std::abs(at[0] - mean) / scale);
        if (!critical) continue;
        // R has a square-root edge at the critical angle, which the middle alone may not show.
        for (std::size_t quarter = 0; quarter < 4; ++quarter) {
            const double a = quarter % 2 == 0 ? 0.25 : 0.75;
            const double b = quarter < 2 ? 0.25 : 0.75;
            const double there =
                (1.0 - b) * ((1.0 - a) * at[1] + a * at[2]) + b * ((1.0 - a) * at[3] + a * at[4]);
            miss = std::max(miss, std::abs(at[5 + quarter] - there) / scale);
        }
    }
    if (critical && most > 0.02 * brightest && miss > tolerance) {
        return miss > 25.0 * tolerance ? 16 : 8;
    }
    return miss > 25.0 * tolerance ? 8 : miss > tolerance ? 4 : 1;
}

// R and T go with the square root of the squared cosine. That bends sharply where the squared
// cosine comes near 0 within the cell, not where it is small all over it.
bool CellLight::NearCriticalAngle(const CellPlace& place) const {
    const MeshGrid& grid = mesh_.grids[static_cast<std::size_t>(place.grid)];
    const auto steps = static_cast<std::size_t>(mesh_.interactions);
    const auto stride = static_cast<std::size_t>(mesh_.passage_count());
    const int dead = surface_.UseOf(place) == CellUse::kTriangle ? surface_.DeadCorner(place) : -1;
    for (const MeshNode& node : grid.nodes) {
        std::array<const float*, 4> corners{};
        for (int k = 0; k < 4; ++k) {
            // A dead corner counts as one of its neighbours.
            const int corner = k == dead ? k ^ 1 : k;
            corners[static_cast<std::size_t>(k)] =
                &node.passage[grid.Vertex(place.i + corner % 2, place.j + corner / 2) * stride];
        }
        for (std::size_t s = 0; s < steps; ++s) {
            const auto [lo, hi] =
                std::minmax({corners[0][s], corners[1][s], corners[2][s], corners[3][s]});
            if (lo < 0.04F && hi > -0.04F && hi > 2.0F * lo) return true;
        }
    }
    return false;
}

}  // namespace flare
