// SPDX-License-Identifier: Apache-2.0
#include "core/render/ghost_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/image/cell_bounds.h"
#include "core/render/cell_light.h"
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

// The box of a cell's corners on the picture, at all traced wavelengths.
struct CornerBox {
    Vec2d lo{1e300, 1e300}, hi{-1e300, -1e300};
};

CornerBox CornersOf(const GhostSurface& surface, const CellPlace& place, const PictureMap& map) {
    const GhostMesh& mesh = surface.mesh();
    const MeshGrid& grid = mesh.grids[static_cast<std::size_t>(place.grid)];
    const auto stored = static_cast<std::size_t>(mesh.stored_count());
    CornerBox box;
    for (const MeshNode& node : grid.nodes) {
        for (int corner = 0; corner < 4; ++corner) {
            const std::size_t v = grid.Vertex(place.i + corner % 2, place.j + corner / 2);
            const Vec2d at = mesh.SensorPlace(&node.fields[v * stored], surface.sensor_gap_mm());
            const Vec2d p = map.Pixel(at.x, at.y);
            box.lo = {std::min(box.lo.x, p.x), std::min(box.lo.y, p.y)};
            box.hi = {std::max(box.hi.x, p.x), std::max(box.hi.y, p.y)};
        }
    }
    return box;
}

// Where a cell lands, from its corners with ample room.
void BoxFromCorners(const GhostSurface& surface, const PictureMap& map, GhostLight::Cell& cell) {
    const auto [lo, hi] = CornersOf(surface, cell.place, map);
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

namespace {

// Do the cell's corners say that it is nowhere near the window? A cheap look; false when in doubt.
bool FarFromWindow(const GhostSurface& surface, const CellPlace& place, const PictureMap& map,
                   const WalkWindow& window) {
    if (surface.UseOf(place) == CellUse::kTriangle) return false;
    const auto [lo, hi] = CornersOf(surface, place, map);
    // The surface bulges out of its corners' box by less than the box's size.
    constexpr double kPad_px = 32.0;
    const Vec2d margin = hi - lo + Vec2d(kPad_px, kPad_px);
    return hi.x + margin.x < window.x0 || lo.x - margin.x > window.x1 ||
           hi.y + margin.y < window.y0 || lo.y - margin.y > window.y1;
}

}  // namespace

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
        if (FarFromWindow(surface, place, map, window)) continue;
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
    std::erase_if(cells, [&](const GhostLight::Cell& cell) { return !Touches(cell, tiles); });
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

int DrawnWavelengths(const LightColour& colour) {
    const double px = colour.dispersion_px;
    // One wavelength a step; but a small picture gets one a pixel, up to five.
    const double steps = std::max(px / colour.dispersion_step_px, std::min(px, 5.0));
    return std::max(colour.least_drawn,
                    2 + static_cast<int>(std::min(steps, colour.most_drawn - 2.0)));
}

namespace {

// From what passes at each colour band to red, green and blue of each drawn one, in units of a
// power of two: a light may be brighter than a float holds.
class ColourMix {
  public:
    explicit ColourMix(const std::vector<BandShare>& shares) {
        double most = 0.0;
        for (const BandShare& share : shares) {
            most = std::max(
                {most, std::abs(share.rgb.x), std::abs(share.rgb.y), std::abs(share.rgb.z)});
        }
        if (most > 0.0 && std::isfinite(most)) unit_ = std::exp2(std::floor(std::log2(most)));
        for (const BandShare& share : shares) {
            const Vec3d rgb = share.rgb / unit_;
            terms_.push_back({static_cast<std::size_t>(share.colour),
                              3 * static_cast<std::size_t>(share.drawn),
                              {static_cast<float>(rgb.x), static_cast<float>(rgb.y),
                               static_cast<float>(rgb.z)}});
        }
    }

    double unit() const { return unit_; }

    void Add(const float* passed, float* out) const {
        for (const Term& term : terms_) {
            const float t = passed[term.colour];
            for (std::size_t c = 0; c < 3; ++c) out[term.at + c] += t * term.rgb[c];
        }
    }

  private:
    struct Term {
        std::size_t colour, at;
        std::array<float, 3> rgb;
    };
    std::vector<Term> terms_;
    double unit_ = 1.0;
};

}  // namespace

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
        drawn = EvenInDispersion(kDrawnLow_nm, kDrawnHigh_nm, DrawnWavelengths(colour));
        shares = BandShares(drawn, tables.wavelengths_nm(), colour.power, *colour.response);
        for (BandShare& share : shares) share.rgb *= colour.tint;
    }

    const TransmissionTables::Path path = tables.PathOf(lens, mesh.sequence);
    const CellLight light(*surface, bundle, tables, path);
    std::size_t points = 0;
    const std::vector<LightLift> lifts = light.ChooseCuts(ghost.cells, colour.light_tolerance);
    for (GhostLight::Cell& cell : ghost.cells) {
        if (cell.ring) cell.light_cuts = 1;
        cell.light_at = points;
        points += static_cast<std::size_t>(cell.light_cuts + 1) *
                  static_cast<std::size_t>(cell.light_cuts + 1);
    }
    for (std::size_t b = 0; b < drawn.size(); ++b) {
        ghost.bands.push_back(
            {NodeWeights(traced, drawn[b]), colour.spectral ? static_cast<int>(b) : 0, drawn[b]});
    }

    std::vector<std::uint32_t> point_of;
    const std::vector<float> passed = light.Light(ghost.cells, point_of);
    const std::size_t wavelengths = tables.wavelengths_nm().size();
    const std::size_t numbers = ghost.NumbersAPoint();
    const std::size_t known = passed.size() / wavelengths;
    std::vector<float> mixed;
    if (colour.spectral) {
        ghost.light_unit = colour.irradiance;
        mixed = passed;
    } else {
        const ColourMix mix(shares);
        ghost.light_unit = mix.unit();
        mixed.resize(known * numbers);
        for (std::size_t k = 0; k < known; ++k)
            mix.Add(&passed[k * wavelengths], &mixed[k * numbers]);
    }
    std::vector<double> places;  // of the bands among the tables' wavelengths
    const double first = tables.wavelengths_nm().front();
    const double range = tables.wavelengths_nm().back() - first;
    for (const GhostLight::Band& band : ghost.bands)
        places.push_back(range != 0.0 ? (band.wavelength_nm - first) / range : 0.0);
    ghost.light.resize(points * numbers);
    float* to = ghost.light.data();
    const std::uint32_t* point = point_of.data();
    const auto channels = static_cast<std::size_t>(ghost.channels);
    std::vector<float> scale(numbers);
    for (std::size_t n = 0; n < ghost.cells.size(); ++n) {
        for (std::size_t b = 0; b < places.size(); ++b)
            std::fill_n(&scale[b * channels], channels, lifts[n].At(places[b]));
        const int side = ghost.cells[n].light_cuts + 1;
        for (int k = 0; k < side * side; ++k) {
            const float* const from = &mixed[*point++ * numbers];
            for (std::size_t c = 0; c < numbers; ++c) *to++ = scale[c] * from[c];
        }
    }
    return ghost;
}

}  // namespace flare
