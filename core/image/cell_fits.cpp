// SPDX-License-Identifier: Apache-2.0
#include "core/image/cell_fits.h"

#include <algorithm>
#include <cmath>

#include "core/image/net_shape.h"

namespace flare {
namespace {

// Bernstein to powers, along one direction.
constexpr std::array<std::array<double, 4>, 4> kPowers = {
    {{1.0, 0.0, 0.0, 0.0}, {-3.0, 3.0, 0.0, 0.0}, {3.0, -6.0, 3.0, 0.0}, {-1.0, 3.0, -3.0, 1.0}}};

CellPolynomial PolynomialOf(const BezierNet& net) {
    std::array<double, 16> rows{};  // powers of a, Bernstein in b
    for (std::size_t j = 0; j < 4; ++j) {
        for (std::size_t p = 0; p < 4; ++p) {
            for (std::size_t i = 0; i <= p; ++i) rows[4 * j + p] += kPowers[p][i] * net[4 * j + i];
        }
    }
    CellPolynomial out{};
    for (std::size_t q = 0; q < 4; ++q) {
        for (std::size_t p = 0; p < 4; ++p) {
            double sum = 0.0;
            for (std::size_t j = 0; j <= q; ++j) sum += kPowers[q][j] * rows[4 * j + p];
            out[4 * q + p] = static_cast<float>(sum);
        }
    }
    return out;
}

PixelBox BoxOfNets(const BezierNet& x, const BezierNet& y) {
    const NetRange rx = RangeOf(x);
    const NetRange ry = RangeOf(y);
    return {static_cast<float>(rx.lo), static_cast<float>(ry.lo), static_cast<float>(rx.hi),
            static_cast<float>(ry.hi)};
}

// Into how many parts the cell is cut so that the map is nearly affine over each, and which signs
// the Jacobian has.
void ChooseParts(FittedCell& cell, std::size_t k) {
    constexpr int kSamples = 3;
    constexpr float kEven = 0.4F;
    const CellFit& fit = cell.fits[k];
    float least = 1e30F;
    float most = -1e30F;
    for (int j = 0; j < kSamples; ++j) {
        for (int i = 0; i < kSamples; ++i) {
            const float a = static_cast<float>(i) / (kSamples - 1);
            const float b = static_cast<float>(j) / (kSamples - 1);
            const PolynomialJet x = JetOf(fit.x, a, b);
            const PolynomialJet y = JetOf(fit.y, a, b);
            const float det = x.per_a * y.per_b - x.per_b * y.per_a;
            least = std::min(least, det);
            most = std::max(most, det);
        }
    }
    cell.on_sheet[0] = cell.on_sheet[0] || most > 0.0F;
    cell.on_sheet[1] = cell.on_sheet[1] || least < 0.0F;
    if (most < 0.0F) {
        const float swap = -least;
        least = -most;
        most = swap;
    }
    const bool folds = !(least > 0.02F * most);
    if (folds) cell.on_sheet = {true, true};
    cell.parts[k] = folds ? 8 : least > kEven * most ? 1 : 2;
}

}  // namespace

void PixelBox::Join(const PixelBox& other) {
    x0 = std::min(x0, other.x0);
    y0 = std::min(y0, other.y0);
    x1 = std::max(x1, other.x1);
    y1 = std::max(y1, other.y1);
}

PixelBox BoxOf(const GhostLight::Cell& cell) {
    return {static_cast<float>(cell.x0), static_cast<float>(cell.y0), static_cast<float>(cell.x1),
            static_cast<float>(cell.y1)};
}

PolynomialJet JetOf(const CellPolynomial& p, float a, float b) {
    std::array<float, 4> row{};
    std::array<float, 4> slope{};
    for (std::size_t q = 0; q < 4; ++q) {
        const float* const c = &p[4 * q];
        row[q] = ((c[3] * a + c[2]) * a + c[1]) * a + c[0];
        slope[q] = (3.0F * c[3] * a + 2.0F * c[2]) * a + c[1];
    }
    return {((row[3] * b + row[2]) * b + row[1]) * b + row[0],
            ((slope[3] * b + slope[2]) * b + slope[1]) * b + slope[0],
            (3.0F * row[3] * b + 2.0F * row[2]) * b + row[1]};
}

MaskFields MasksOf(const GhostSurface& surface, const std::vector<GhostLight::Cell>& cells,
                   const Iris& iris) {
    const GhostMesh& mesh = surface.mesh();
    std::vector<bool> stop(static_cast<std::size_t>(mesh.stop_crossings), false);
    std::vector<bool> rim(mesh.rims.size(), false);
    const double inner2 = iris.inner_radius() * iris.inner_radius() * 0.98;
    for (const GhostLight::Cell& cell : cells) {
        if (cell.open) continue;
        const MeshGrid& grid = mesh.grids[static_cast<std::size_t>(cell.place.grid)];
        const auto stored = static_cast<std::size_t>(mesh.stored_count());
        for (int corner = 0; corner < 4; ++corner) {
            const std::size_t v = grid.Vertex(cell.place.i + corner % 2, cell.place.j + corner / 2);
            for (const MeshNode& node : grid.nodes) {
                const float* const at = &node.fields[v * stored];
                for (std::size_t c = 0; c < stop.size(); ++c) {
                    const auto f = static_cast<std::size_t>(mesh.stop_field(static_cast<int>(c)));
                    const double x = static_cast<double>(at[f]);
                    const double y = static_cast<double>(at[f + 1]);
                    if (x * x + y * y > inner2) stop[c] = true;
                }
                for (std::size_t r = 0; r < rim.size(); ++r) {
                    if (at[mesh.rim_field(static_cast<int>(r))] > -0.02F) rim[r] = true;
                }
            }
        }
    }
    MaskFields masks;
    for (std::size_t c = 0; c < stop.size(); ++c) {
        if (stop[c]) masks.crossings.push_back(static_cast<int>(c));
    }
    for (std::size_t r = 0; r < rim.size(); ++r) {
        if (rim[r]) masks.rims.push_back(static_cast<int>(r));
    }
    return masks;
}

std::vector<FittedCell> FitCells(const GhostLight& ghost, const PictureMap& map) {
    const MaskFields& masks = ghost.masks;
    const GhostSurface& surface = *ghost.surface;
    const GhostMesh& mesh = surface.mesh();
    std::vector<FittedCell> cells;
    cells.reserve(ghost.cells.size());
    CellSurface nets;
    for (std::size_t n = 0; n < ghost.cells.size(); ++n) {
        const GhostLight::Cell& from = ghost.cells[n];
        if (surface.UseOf(from.place) == CellUse::kTriangle) continue;
        FittedCell& cell = cells.emplace_back();
        cell.cell = static_cast<int>(n);
        cell.ring = from.ring;
        for (std::size_t k = 0; k < kTracedInTiles; ++k) {
            std::vector<double> only(kTracedInTiles, 0.0);
            only[k] = 1.0;
            surface.Evaluate(from.place, only, 0, masks.count() > 0 ? mesh.field_count() : 2, nets);
            MapNets(nets.nets[0], nets.nets[1], map.px_per_x, map.px_per_y, map.offset_px);
            CellFit& fit = cell.fits[k];
            fit.x = PolynomialOf(nets.nets[0]);
            fit.y = PolynomialOf(nets.nets[1]);
            cell.boxes[k] = BoxOfNets(nets.nets[0], nets.nets[1]);
            for (const int crossing : masks.crossings) {
                const auto f = static_cast<std::size_t>(mesh.stop_field(crossing));
                MapNets(nets.nets[f], nets.nets[f + 1], map.stop_per_x, map.stop_per_y, {0.0, 0.0});
                for (std::size_t axis = 0; axis < 2; ++axis) {
                    fit.fields[static_cast<std::size_t>(fit.field_count++)] =
                        PolynomialOf(nets.nets[f + axis]);
                }
            }
            for (const int rim : masks.rims) {
                fit.fields[static_cast<std::size_t>(fit.field_count++)] =
                    PolynomialOf(nets.nets[static_cast<std::size_t>(mesh.rim_field(rim))]);
            }
            ChooseParts(cell, k);
        }
    }
    return cells;
}

}  // namespace flare
