// SPDX-License-Identifier: Apache-2.0
#include "core/render/ghost_light.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/render/quality.h"

namespace flare {
namespace {

// Which vertices of each grid belong to cells that are drawn.
std::vector<std::vector<std::uint8_t>> UsedVertices(const GhostMesh& mesh,
                                                    const std::vector<GhostLight::Cell>& cells) {
    std::vector<std::vector<std::uint8_t>> used;
    for (const MeshGrid& grid : mesh.grids) used.emplace_back(grid.alive.size(), std::uint8_t{0});
    for (const GhostLight::Cell& cell : cells) {
        const auto g = static_cast<std::size_t>(cell.place.grid);
        for (int corner = 0; corner < 4; ++corner) {
            used[g][mesh.grids[g].Vertex(cell.place.i + corner % 2, cell.place.j + corner / 2)] = 1;
        }
    }
    return used;
}

// Transmittance times flux density over the cells of one ghost, at each wavelength of the tables.
class CellLight {
  public:
    CellLight(const GhostSurface& surface, const LightBundle& bundle,
              const TransmissionTables& tables, const TransmissionTables::Path& path)
        : surface_(surface), mesh_(surface.mesh()), bundle_(bundle), path_(path) {
        const std::vector<double> traced = TracedWavelengths(mesh_);
        for (const double wavelength : tables.wavelengths_nm()) {
            weights_.push_back(NodeWeights(traced, wavelength));
        }
        for (const MeshGrid& grid : mesh_.grids) at_vertex_.emplace_back(grid.alive.size());
    }

    std::size_t wavelengths() const { return weights_.size(); }

    // Notes the brightest cell, by which CutsOf judges what matters.
    void Weigh(const CellPlace& place) {
        SetCell(place);
        brightest_ = std::max(brightest_, Weight((weights_.size() - 1) / 2, 0.5, 0.5));
    }

    // How finely the cell's light must be sampled: the corners, unless the light at the middle is
    // not their mean. A miss counts by the ghost's brightest cell where the cell itself is dim, as
    // towards grazing incidence.
    int CutsOf(const CellPlace& place, double tolerance) {
        constexpr double kDim = 0.2;
        SetCell(place);
        const std::size_t last = weights_.size() - 1;
        int cuts = 1;
        double light = 0.0;
        for (const std::size_t band : {std::size_t{0}, last / 2, last}) {
            double mean = 0.0;
            for (std::size_t corner = 0; corner < 4; ++corner) {
                mean += 0.25 * Weight(band, corner % 2 == 0 ? 0.0 : 1.0, corner < 2 ? 0.0 : 1.0);
            }
            const double middle = Weight(band, 0.5, 0.5);
            light = std::max({light, mean, middle});
            const double scale = std::max({mean, kDim * brightest_, 1e-300});
            const double miss = std::abs(middle - mean) / scale;
            if (miss > 25.0 * tolerance) {
                cuts = 8;
            } else if (miss > tolerance) {
                cuts = std::max(cuts, 4);
            }
        }
        // R has a square-root edge at the critical angle, which the middle alone may not show.
        return NearCriticalAngle() && light > 0.02 * brightest_ ? 16 : cuts;
    }

    // Light at lattice point (a, b) of the cell, 0..1.
    void At(const CellPlace& place, int cuts, int i, int j, std::vector<double>& out) {
        if (cuts == 1 && surface_.UseOf(place) != CellUse::kTriangle) {
            // A vertex serves four cells.
            const auto g = static_cast<std::size_t>(place.grid);
            std::vector<double>& kept =
                at_vertex_[g][mesh_.grids[g].Vertex(place.i + i, place.j + j)];
            if (kept.empty()) Compute(place, i, j, kept);
            out = kept;
            return;
        }
        Compute(place, static_cast<double>(i) / cuts, static_cast<double>(j) / cuts, out);
    }

  private:
    void Compute(const CellPlace& place, double a, double b, std::vector<double>& out) {
        SetCell(place);
        const MeshGrid& grid = mesh_.grids[static_cast<std::size_t>(place.grid)];
        const double density = bundle_.FluxDensity(grid.u0 + (place.i + a) * grid.du,
                                                   grid.v0 + (place.j + b) * grid.dv);
        out.resize(weights_.size());
        for (std::size_t band = 0; band < weights_.size(); ++band)
            out[band] = density * Weight(band, a, b);
    }

    // R and T go with the square root of the squared cosine. That bends sharply where the squared
    // cosine comes near 0 within the cell, not where it is small all over it.
    bool NearCriticalAngle() const {
        const auto steps = static_cast<std::size_t>(mesh_.interactions);
        const auto stride = static_cast<std::size_t>(mesh_.passage_count());
        const std::size_t nodes = corners_.size() / (4 * stride);
        for (std::size_t k = 0; k < nodes; ++k) {
            for (std::size_t s = 0; s < steps; ++s) {
                double lo = 1.0;
                double hi = -1.0;
                for (std::size_t corner = 0; corner < 4; ++corner) {
                    const double c2 = corners_[(k * 4 + corner) * stride + s];
                    lo = std::min(lo, c2);
                    hi = std::max(hi, c2);
                }
                if (lo < 0.04 && hi > -0.04 && hi > 2.0 * lo) return true;
            }
        }
        return false;
    }

    // Gathers the passages at the cell's corners, a dead one filled in by the parallelogram rule.
    void SetCell(const CellPlace& place) {
        if (place.grid == cell_.grid && place.i == cell_.i && place.j == cell_.j) return;
        cell_ = place;
        const MeshGrid& grid = mesh_.grids[static_cast<std::size_t>(place.grid)];
        const auto steps = static_cast<std::size_t>(mesh_.passage_count());
        corners_.assign(grid.nodes.size() * 4 * steps, 0.0);
        const int dead =
            surface_.UseOf(place) == CellUse::kTriangle ? surface_.DeadCorner(place) : -1;
        for (std::size_t k = 0; k < grid.nodes.size(); ++k) {
            double* const at = &corners_[k * 4 * steps];
            for (int corner = 0; corner < 4; ++corner) {
                const std::size_t vertex = grid.Vertex(place.i + corner % 2, place.j + corner / 2);
                for (std::size_t s = 0; s < steps; ++s) {
                    at[static_cast<std::size_t>(corner) * steps + s] =
                        static_cast<double>(grid.nodes[k].passage[vertex * steps + s]);
                }
            }
            if (dead < 0) continue;
            const auto d = static_cast<std::size_t>(dead);
            for (std::size_t s = 0; s < steps; ++s) {
                at[d * steps + s] =
                    at[(d ^ 1U) * steps + s] + at[(d ^ 2U) * steps + s] - at[(d ^ 3U) * steps + s];
            }
        }
    }

    double Weight(std::size_t band, double a, double b) {
        const auto steps = static_cast<std::size_t>(mesh_.passage_count());
        passage_.assign(steps, 0.0);
        const std::array<double, 4> w = {(1.0 - a) * (1.0 - b), a * (1.0 - b), (1.0 - a) * b,
                                         a * b};
        for (std::size_t k = 0; k < weights_[band].size(); ++k) {
            for (std::size_t corner = 0; corner < 4; ++corner) {
                const double share = weights_[band][k] * w[corner];
                if (share == 0.0) continue;
                const double* const at = &corners_[(k * 4 + corner) * steps];
                for (std::size_t s = 0; s < steps; ++s) passage_[s] += share * at[s];
            }
        }
        return path_.Weight(static_cast<int>(band), passage_);
    }

    const GhostSurface& surface_;
    const GhostMesh& mesh_;
    const LightBundle& bundle_;
    const TransmissionTables::Path& path_;
    std::vector<std::vector<double>> weights_;
    std::vector<std::vector<std::vector<double>>> at_vertex_;  // [grid][vertex][wavelength]
    double brightest_ = 0.0;  // light at the middle of a cell, at the middle wavelength
    CellPlace cell_{-1, -1, -1};
    std::vector<double> corners_;  // [node][corner][passage]
    std::vector<double> passage_;
};

// Where a cell lands, from its corners with ample room.
void BoxFromCorners(const GhostSurface& surface, const PictureMap& map, GhostLight::Cell& cell) {
    const MeshGrid& grid = surface.mesh().grids[static_cast<std::size_t>(cell.place.grid)];
    const auto stored = static_cast<std::size_t>(surface.mesh().stored_count());
    Vec2d lo(1e300), hi(-1e300);
    for (const MeshNode& node : grid.nodes) {
        for (int corner = 0; corner < 4; ++corner) {
            const std::size_t v = grid.Vertex(cell.place.i + corner % 2, cell.place.j + corner / 2);
            const Vec2d at =
                surface.mesh().SensorPlace(&node.fields[v * stored], surface.sensor_gap_mm());
            const Vec2d p = map.Pixel(at.x, at.y);
            lo = {std::min(lo.x, p.x), std::min(lo.y, p.y)};
            hi = {std::max(hi.x, p.x), std::max(hi.y, p.y)};
        }
    }
    const Vec2d room = (hi - lo) * 0.5 + Vec2d(2.0, 2.0);
    cell.x0 = lo.x - room.x;
    cell.x1 = hi.x + room.x;
    cell.y0 = lo.y - room.y;
    cell.y1 = hi.y + room.y;
}

}  // namespace

std::vector<double> TracedWavelengths(const GhostMesh& mesh) {
    std::vector<double> wavelengths;
    if (mesh.grids.empty()) return wavelengths;
    for (const MeshNode& node : mesh.grids.front().nodes) wavelengths.push_back(node.wavelength_nm);
    return wavelengths;
}

bool Touches(const GhostLight::Cell& cell, const WalkWindow& window) {
    return cell.x1 >= window.x0 && cell.x0 <= window.x1 && cell.y1 >= window.y0 &&
           cell.y0 <= window.y1;
}

std::vector<GhostLight::Cell> CellsInWindow(const GhostSurface& surface,
                                            const std::vector<double>& wavelengths_nm,
                                            const Iris& iris, const PictureMap& map,
                                            const WalkWindow& window) {
    std::vector<GhostLight::Cell> cells;
    const std::vector<double> traced = TracedWavelengths(surface.mesh());
    std::vector<std::vector<double>> weights;
    for (const double wavelength : wavelengths_nm)
        weights.push_back(NodeWeights(traced, wavelength));
    for (const CellPlace& place : surface.cells()) {
        CellBounds b = BoundCell(surface, weights, place, iris, map);
        if (!b.passes) continue;
        if (weights.size() > 1) {
            // Wavelengths between the ones bounded may reach a little farther.
            const double dx = 0.25 * (b.x1 - b.x0) + 2.0;
            const double dy = 0.25 * (b.y1 - b.y0) + 2.0;
            b = {true, b.open, b.y0 - dy, b.y1 + dy, b.x0 - dx, b.x1 + dx};
        }
        GhostLight::Cell cell;
        cell.place = place;
        cell.x0 = b.x0;
        cell.x1 = b.x1;
        cell.y0 = b.y0;
        cell.y1 = b.y1;
        cell.open = b.open;
        if (Touches(cell, window)) cells.push_back(cell);
    }
    return cells;
}

void AddRing(const GhostSurface& surface, const PictureMap& map, const PixelWindow& window,
             std::vector<GhostLight::Cell>& cells) {
    const GhostMesh& mesh = surface.mesh();
    constexpr double kTile = kLargestTile;
    const WalkWindow tiles{window.x - kTile, window.y - kTile, window.x + window.width + kTile,
                           window.y + window.height + kTile};
    for (GhostLight::Cell& cell : cells) cell.wanted = Touches(cell, tiles);
    std::vector<std::vector<std::uint8_t>> known;
    for (const MeshGrid& grid : mesh.grids) known.emplace_back(grid.cells.size(), std::uint8_t{0});
    for (const GhostLight::Cell& cell : cells) {
        const auto g = static_cast<std::size_t>(cell.place.grid);
        known[g][mesh.grids[g].Cell(cell.place.i, cell.place.j)] = 1;
    }
    const auto add = [&](int g, int i, int j) {
        const MeshGrid& grid = mesh.grids[static_cast<std::size_t>(g)];
        if (i < 0 || j < 0 || i + 1 >= grid.nu || j + 1 >= grid.nv) return;
        std::uint8_t& seen = known[static_cast<std::size_t>(g)][grid.Cell(i, j)];
        const CellUse use = grid.cells[grid.Cell(i, j)];
        if (seen != 0 || (use != CellUse::kUsed && use != CellUse::kOutside)) return;
        seen = 1;
        for (int corner = 0; corner < 4; ++corner) {
            if (grid.alive[grid.Vertex(i + corner % 2, j + corner / 2)] == 0) return;
        }
        GhostLight::Cell& cell = cells.emplace_back();
        cell.place = {g, i, j};
        cell.ring = true;
        BoxFromCorners(surface, map, cell);
        cell.wanted = Touches(cell, tiles);
    };
    const auto around = [&](int g, int i, int j) {
        for (int dj = -1; dj <= 1; ++dj) {
            for (int di = -1; di <= 1; ++di) add(g, i + di, j + dj);
        }
    };
    const std::size_t drawn = cells.size();
    std::vector<bool> whole(mesh.grids.size(), false);
    for (std::size_t n = 0; n < drawn; ++n) {
        const CellPlace place = cells[n].place;
        if (place.grid == 0) {
            around(0, place.i, place.j);
            continue;
        }
        // A patch stands in one cell of the grid: all of it, and what is around that cell.
        if (whole[static_cast<std::size_t>(place.grid)]) continue;
        whole[static_cast<std::size_t>(place.grid)] = true;
        const MeshGrid& patch = mesh.grids[static_cast<std::size_t>(place.grid)];
        for (int j = 0; j + 1 < patch.nv; ++j) {
            for (int i = 0; i + 1 < patch.nu; ++i) add(place.grid, i, j);
        }
        const MeshGrid& grid = mesh.grids.front();
        around(0, static_cast<int>(std::lround((patch.u0 - grid.u0) / grid.du)),
               static_cast<int>(std::lround((patch.v0 - grid.v0) / grid.dv)));
    }
}

double DispersionPx(const GhostSurface& surface, const std::vector<GhostLight::Cell>& cells,
                    const PictureMap& map) {
    const GhostMesh& mesh = surface.mesh();
    const std::vector<double> traced = TracedWavelengths(mesh);
    const std::vector<std::vector<std::uint8_t>> used = UsedVertices(mesh, cells);
    const std::vector<double> low = NodeWeights(traced, kDrawnLow_nm);
    const std::vector<double> high = NodeWeights(traced, kDrawnHigh_nm);
    const auto fields = static_cast<std::size_t>(mesh.stored_count());
    double largest = 0.0;
    for (std::size_t g = 0; g < mesh.grids.size(); ++g) {
        for (std::size_t v = 0; v < used[g].size(); ++v) {
            if (used[g][v] == 0 || mesh.grids[g].alive[v] == 0) continue;
            Vec2d spread(0.0, 0.0);
            for (std::size_t k = 0; k < traced.size(); ++k) {
                const float* const f = &mesh.grids[g].nodes[k].fields[v * fields];
                spread += mesh.SensorPlace(f, surface.sensor_gap_mm()) * (high[k] - low[k]);
            }
            largest =
                std::max(largest, (map.px_per_x * spread.x + map.px_per_y * spread.y).length());
        }
    }
    return largest;
}

GhostLight PrepareGhost(std::shared_ptr<const GhostSurface> surface, const LightBundle& bundle,
                        const Lens& lens, const TransmissionTables& tables,
                        const LightColour& colour, std::vector<GhostLight::Cell> cells) {
    GhostLight ghost;
    ghost.cells = std::move(cells);
    ghost.surface = surface;
    ghost.channels = colour.spectral ? 1 : 3;
    if (ghost.cells.empty()) return ghost;

    const GhostMesh& mesh = surface->mesh();
    const std::vector<double> traced = TracedWavelengths(mesh);
    std::vector<double> drawn = tables.wavelengths_nm();
    std::vector<BandShare> shares;
    if (!colour.spectral) {
        const double px = colour.dispersion_px;
        // One wavelength a step; but a small picture gets one a pixel, up to five.
        const double steps = std::max(px / colour.dispersion_step_px, std::min(px, 5.0));
        const int count = 2 + static_cast<int>(std::min(steps, colour.most_drawn - 2.0));
        drawn = EvenInDispersion(kDrawnLow_nm, kDrawnHigh_nm, count);
        shares = BandShares(drawn, tables.wavelengths_nm(), colour.power);
    }

    const TransmissionTables::Path path = tables.PathOf(lens, mesh.sequence);
    CellLight light(*surface, bundle, tables, path);
    const auto channels = static_cast<std::size_t>(ghost.channels);
    std::size_t points = 0;
    // Over the whole ghost, not what the window shows: a crop is drawn as the frame is.
    for (std::size_t k = 0; k < surface->cells().size(); k += 3) light.Weigh(surface->cells()[k]);
    for (GhostLight::Cell& cell : ghost.cells) {
        if (!cell.wanted) continue;
        cell.light_cuts = cell.ring ? 1 : light.CutsOf(cell.place, colour.light_tolerance);
        cell.light_at = points * channels;
        points += static_cast<std::size_t>(cell.light_cuts + 1) *
                  static_cast<std::size_t>(cell.light_cuts + 1);
    }
    for (std::size_t b = 0; b < drawn.size(); ++b) {
        ghost.bands.push_back({NodeWeights(traced, drawn[b]),
                               std::vector<double>(points * channels, 0.0),
                               colour.spectral ? static_cast<int>(b) : 0});
    }

    std::vector<double> passed;
    for (const GhostLight::Cell& cell : ghost.cells) {
        if (!cell.wanted) continue;
        std::size_t at = cell.light_at;
        for (int j = 0; j <= cell.light_cuts; ++j) {
            for (int i = 0; i <= cell.light_cuts; ++i, at += channels) {
                light.At(cell.place, cell.light_cuts, i, j, passed);
                if (colour.spectral) {
                    for (std::size_t b = 0; b < drawn.size(); ++b) {
                        ghost.bands[b].light[at] = colour.irradiance * passed[b];
                    }
                    continue;
                }
                for (const BandShare& share : shares) {
                    double* const out =
                        &ghost.bands[static_cast<std::size_t>(share.drawn)].light[at];
                    const double t = passed[static_cast<std::size_t>(share.colour)];
                    out[0] += t * share.rgb.x;
                    out[1] += t * share.rgb.y;
                    out[2] += t * share.rgb.z;
                }
            }
        }
    }
    return ghost;
}

}  // namespace flare
