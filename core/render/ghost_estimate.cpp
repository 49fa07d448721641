// SPDX-License-Identifier: Apache-2.0
//
// A cell's light is the mean of its corners', unless these differ by much, as near total
// reflection: then it is the mean over a lattice of points. Of a cell whose corners all pass the
// masks all of it passes, of one whose corners all fail one mask nothing; any other is looked at on
// a lattice of its smooth surface.
#include "core/render/ghost_estimate.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/image/net_shape.h"
#include "core/image/stop_pass.h"
#include "core/render/ghost_light.h"
#include "core/spectrum/wavelength_plan.h"

namespace flare {

namespace {

constexpr int kLattice = 6;      // points along a side of a cell that is looked at closely
constexpr double kUneven = 2.0;  // between the light of a cell's corners

class Estimator {
  public:
    Estimator(const GhostSurface& surface, const LightBundle& bundle, const Lens& lens,
              const TransmissionTables& tables, const Iris& iris, const CanonicalPose& pose)
        : surface_(surface),
          mesh_(surface.mesh()),
          bundle_(bundle),
          path_(tables.PathOf(lens, mesh_.sequence)),
          iris_(iris),
          pose_(pose) {
        weights_ = NodeWeights(TracedWavelengths(mesh_), tables.wavelengths_nm().front());
    }

    GhostEstimate Run() {
        for (const MeshGrid& grid : mesh_.grids) light_.emplace_back(grid.alive.size(), -1.0);
        for (const CellPlace& cell : surface_.cells()) AddCell(cell);
        if (estimate_.flux_mm2 > 0.0) estimate_.centroid_mm /= estimate_.flux_mm2;
        // However sharply it is focused, no more light falls on a pixel than there is.
        const double pixel = kPeakPixel_mm * kPeakPixel_mm;
        estimate_.peak_irradiance = std::min(estimate_.peak_irradiance, estimate_.flux_mm2 / pixel);
        return estimate_;
    }

  private:
    void AddCell(const CellPlace& cell) {
        const MeshGrid& grid = mesh_.grids[static_cast<std::size_t>(cell.grid)];
        if (surface_.UseOf(cell) != CellUse::kUsed) return;
        const double share = PassingShare(cell, grid);
        if (share == 0.0) return;
        // Around the cell.
        const std::array<std::size_t, 4> corner = {
            grid.Vertex(cell.i, cell.j), grid.Vertex(cell.i + 1, cell.j),
            grid.Vertex(cell.i + 1, cell.j + 1), grid.Vertex(cell.i, cell.j + 1)};
        std::array<double, 4> light{};
        std::array<Vec2d, 4> place;
        for (std::size_t k = 0; k < 4; ++k) {
            light[k] = LightAt(cell.grid, corner[k]);
            place[k] = {Field(grid, corner[k], 0), Field(grid, corner[k], 1)};
        }
        const auto [least, most] = std::minmax_element(light.begin(), light.end());
        const double mean = *most > kUneven * *least
                                ? SampledLight(cell)
                                : 0.25 * (light[0] + light[1] + light[2] + light[3]);
        const double flux = mean * grid.du * grid.dv;
        estimate_.flux_mm2 += share * flux;
        estimate_.centroid_mm +=
            (place[0] + place[1] + place[2] + place[3]) * (0.25 * share * flux);
        const Vec2d p = place[2] - place[0];
        const Vec2d q = place[3] - place[1];
        const double area = 0.5 * std::abs(p.x * q.y - p.y * q.x);
        if (area > 0.0) {
            estimate_.peak_irradiance = std::max(estimate_.peak_irradiance, flux / area);
        }
    }

    // Of a vertex at the wavelength asked for; fields 0 and 1 on the sensor.
    double Field(const MeshGrid& grid, std::size_t vertex, std::size_t f) const {
        const auto stored = static_cast<std::size_t>(mesh_.stored_count());
        double value = 0.0;
        for (std::size_t k = 0; k < grid.nodes.size(); ++k) {
            const float* const at = &grid.nodes[k].fields[vertex * stored];
            if (f < 2) {
                const Vec2d place = mesh_.SensorPlace(at, surface_.sensor_gap_mm());
                value += weights_[k] * (f == 0 ? place.x : place.y);
            } else {
                value += weights_[k] * static_cast<double>(at[f]);
            }
        }
        return value;
    }

    // Positive outside the mask: of a stop crossing (mm) or a rim.
    double StopMask(double x, double y) const {
        const Vec2d p = pose_.LensSpace({x, y});
        const double radius = p.length();
        if (radius > iris_.outer_radius()) return radius - iris_.outer_radius();
        return radius < iris_.edges_inner_radius() ? -1.0 : iris_.Distance(p);
    }

    // Is the iris's picture clear all over a cell, as far as its corners tell?
    bool Clear(const CellPlace& cell, const MeshGrid& grid) const {
        if (iris_.picture() == nullptr) return true;
        for (int c = 0; c < mesh_.stop_crossings; ++c) {
            const auto f = static_cast<std::size_t>(mesh_.stop_field(c));
            StopCorners at;
            for (std::size_t k = 0; k < 4; ++k) {
                const std::size_t v =
                    grid.Vertex(cell.i + (k == 1 || k == 2 ? 1 : 0), cell.j + (k >= 2 ? 1 : 0));
                at[k] = pose_.LensSpace({Field(grid, v, f), Field(grid, v, f + 1)});
            }
            if (!PassRange(*iris_.picture(), at).clear()) return false;
        }
        return true;
    }

    double PassingShare(const CellPlace& cell, const MeshGrid& grid) {
        bool cut = false;
        const auto look = [&](auto mask) {
            int outside = 0;
            for (int k = 0; k < 4; ++k) {
                const std::size_t v = grid.Vertex(cell.i + k % 2, cell.j + k / 2);
                outside += mask(v) > 0.0 ? 1 : 0;
            }
            cut = cut || outside > 0;
            return outside < 4;
        };
        for (int c = 0; c < mesh_.stop_crossings; ++c) {
            const auto f = static_cast<std::size_t>(mesh_.stop_field(c));
            // A small iris may lie within a cell whose corners are all outside.
            if (!look([&](std::size_t v) {
                    return StopMask(Field(grid, v, f), Field(grid, v, f + 1));
                }) &&
                surface_.FarOutsideStop(cell, iris_.outer_radius())) {
                return 0.0;
            }
        }
        for (int r = 0; r < static_cast<int>(mesh_.rims.size()); ++r) {
            const auto f = static_cast<std::size_t>(mesh_.rim_field(r));
            if (!look([&](std::size_t v) { return Field(grid, v, f); })) return 0.0;
        }
        return cut || !Clear(cell, grid) ? SampledShare(cell) : 1.0;
    }

    double SampledShare(const CellPlace& cell) {
        surface_.Evaluate(cell, weights_, 2, mesh_.field_count(), nets_);
        std::array<std::array<double, 4>, kLattice> weights;
        for (int i = 0; i < kLattice; ++i)
            weights[static_cast<std::size_t>(i)] = Bernstein((i + 0.5) / kLattice);
        double inside = 0.0;
        for (const std::array<double, 4>& b : weights) {
            for (const std::array<double, 4>& a : weights) {
                if (PassesAt(a, b)) inside += PictureAt(a, b);
            }
        }
        return inside / (kLattice * kLattice);
    }

    // What the iris's picture lets pass around a point of the lattice.
    double PictureAt(const std::array<double, 4>& a, const std::array<double, 4>& b) const {
        if (iris_.picture() == nullptr) return 1.0;
        double passes = 1.0;
        for (int c = 0; c < mesh_.stop_crossings; ++c) {
            const auto f = static_cast<std::size_t>(mesh_.stop_field(c));
            // The lattice is even: a cell of it is a sixth of what the corners span.
            const auto corner = [&](std::size_t n) {
                return pose_.LensSpace({nets_.nets[f][n], nets_.nets[f + 1][n]});
            };
            const Vec2d right = (corner(3) - corner(0) + corner(15) - corner(12)) * 0.5;
            const Vec2d up = (corner(12) - corner(0) + corner(15) - corner(3)) * 0.5;
            const Vec2d at = pose_.LensSpace({Value(f, a, b), Value(f + 1, a, b)});
            passes *= iris_.picture()->Mean({at, right / kLattice, up / kLattice, Vec2d(0.0, 0.0)});
        }
        return passes;
    }

    // Weights of the net's columns and rows.
    bool PassesAt(const std::array<double, 4>& a, const std::array<double, 4>& b) const {
        for (int r = 0; r < static_cast<int>(mesh_.rims.size()); ++r) {
            if (Value(static_cast<std::size_t>(mesh_.rim_field(r)), a, b) > 0.0) return false;
        }
        for (int c = 0; c < mesh_.stop_crossings; ++c) {
            const auto f = static_cast<std::size_t>(mesh_.stop_field(c));
            if (StopMask(Value(f, a, b), Value(f + 1, a, b)) > 0.0) return false;
        }
        return true;
    }

    double Value(std::size_t field, const std::array<double, 4>& ba,
                 const std::array<double, 4>& bb) const {
        const BezierNet& net = nets_.nets[field];
        double value = 0.0;
        for (std::size_t row = 0; row < 4; ++row) {
            for (std::size_t column = 0; column < 4; ++column) {
                value += bb[row] * ba[column] * net[4 * row + column];
            }
        }
        return value;
    }

    // Transmittance times flux density; a vertex serves four cells.
    double LightAt(int g, std::size_t vertex) {
        double& kept = light_[static_cast<std::size_t>(g)][vertex];
        if (kept >= 0.0) return kept;
        const MeshGrid& grid = mesh_.grids[static_cast<std::size_t>(g)];
        passage_.assign(static_cast<std::size_t>(mesh_.passage_count()), 0.0);
        AddPassage(grid, vertex, 1.0);
        const auto nu = static_cast<std::size_t>(grid.nu);
        kept = Light(grid, static_cast<double>(vertex % nu), static_cast<double>(vertex / nu));
        return kept;
    }

    // Its mean over a cell.
    double SampledLight(const CellPlace& cell) {
        const MeshGrid& grid = mesh_.grids[static_cast<std::size_t>(cell.grid)];
        double sum = 0.0;
        for (int j = 0; j < kLattice; ++j) {
            for (int i = 0; i < kLattice; ++i) {
                const double a = (i + 0.5) / kLattice;
                const double b = (j + 0.5) / kLattice;
                passage_.assign(static_cast<std::size_t>(mesh_.passage_count()), 0.0);
                AddPassage(grid, grid.Vertex(cell.i, cell.j), (1.0 - a) * (1.0 - b));
                AddPassage(grid, grid.Vertex(cell.i + 1, cell.j), a * (1.0 - b));
                AddPassage(grid, grid.Vertex(cell.i, cell.j + 1), (1.0 - a) * b);
                AddPassage(grid, grid.Vertex(cell.i + 1, cell.j + 1), a * b);
                sum += Light(grid, cell.i + a, cell.j + b);
            }
        }
        return sum / (kLattice * kLattice);
    }

    void AddPassage(const MeshGrid& grid, std::size_t vertex, double share) {
        for (std::size_t k = 0; k < grid.nodes.size(); ++k) {
            const float* const at = &grid.nodes[k].passage[vertex * passage_.size()];
            for (std::size_t s = 0; s < passage_.size(); ++s) {
                passage_[s] += share * weights_[k] * static_cast<double>(at[s]);
            }
        }
    }

    // Of the passage gathered, at a place in steps of the grid.
    double Light(const MeshGrid& grid, double i, double j) const {
        return std::max(0.0, path_.Weight(0, passage_)) *
               bundle_.FluxDensity(grid.u0 + i * grid.du, grid.v0 + j * grid.dv);
    }

    const GhostSurface& surface_;
    const GhostMesh& mesh_;
    const LightBundle& bundle_;
    TransmissionTables::Path path_;
    const Iris& iris_;
    const CanonicalPose& pose_;
    std::vector<double> weights_;
    std::vector<std::vector<double>> light_;  // [grid][vertex], -1: not yet known
    std::vector<double> passage_;
    CellSurface nets_;
    GhostEstimate estimate_;
};

}  // namespace

GhostEstimate EstimateOf(const GhostSurface& surface, const LightBundle& bundle, const Lens& lens,
                         const TransmissionTables& tables, const Iris& iris,
                         const CanonicalPose& pose) {
    if (surface.cells().empty()) return {};
    return Estimator(surface, bundle, lens, tables, iris, pose).Run();
}

}  // namespace flare
