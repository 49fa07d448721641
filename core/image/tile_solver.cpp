// SPDX-License-Identifier: Apache-2.0
#include "core/image/tile_solver.h"

#include <algorithm>
#include <cmath>

namespace flare {
namespace {

constexpr float kPointsATile = 2.0F;  // along each side, at which a tile is held to its cells

// The box of a part, with some room, and whether the Jacobian changes its sign there.
bool Survey(const CellFit& fit, const CellPart& part, PixelBox& box) {
    float least = 1e30F;
    float most = -1e30F;
    for (int j = 0; j < 3; ++j) {
        for (int i = 0; i < 3; ++i) {
            const float a = part.a0 + (part.a1 - part.a0) * 0.5F * static_cast<float>(i);
            const float b = part.b0 + (part.b1 - part.b0) * 0.5F * static_cast<float>(j);
            const PolynomialJet x = JetOf(fit.x, a, b);
            const PolynomialJet y = JetOf(fit.y, a, b);
            const float det = x.per_a * y.per_b - x.per_b * y.per_a;
            least = std::min(least, det);
            most = std::max(most, det);
            box.Join({x.value, y.value, x.value, y.value});
        }
    }
    const float room_x = 0.1F * (box.x1 - box.x0) + 0.1F;
    const float room_y = 0.1F * (box.y1 - box.y0) + 0.1F;
    box = {box.x0 - room_x, box.y0 - room_y, box.x1 + room_x, box.y1 + room_y};
    return least * most <= 0.0F;
}

}  // namespace

void TileSolver::Run() {
    for (const FittedCell& cell : cells_) {
        for (std::size_t k = 0; k < kTraced; ++k) SolveCell(cell, k);
    }
    for (const GhostLight::Cell& cell : ghost_.cells) {
        if (cell.ring) continue;
        if (ghost_.surface->UseOf(cell.place) == CellUse::kTriangle)
            level_.Mark(level_.bad, BoxOf(cell));
    }
    for (const FittedCell& cell : cells_) {
        if (cell.ring) continue;
        const PixelBox box = BoxOf(ghost_.cells[static_cast<std::size_t>(cell.cell)]);
        for (std::size_t s = 0; s < kSheets; ++s) {
            if (cell.on_sheet[s]) level_.Mark(level_.live[s], box);
        }
    }
    for (const FittedCell& cell : cells_) {
        if (!cell.ring) CheckCell(cell);
    }
}

void TileSolver::SolveCell(const FittedCell& cell, std::size_t k) {
    if (!level_.AnyWanted(cell.boxes[k])) return;
    const int parts = cell.parts[k];
    if (parts == 1) {
        SolvePart(cell, k, {}, cell.boxes[k]);
        return;
    }
    const float step = 1.0F / static_cast<float>(parts);
    for (int j = 0; j < parts; ++j) {
        for (int i = 0; i < parts; ++i) {
            const CellPart part{static_cast<float>(i) * step, static_cast<float>(i + 1) * step,
                                static_cast<float>(j) * step, static_cast<float>(j + 1) * step};
            PixelBox box;
            const bool folds = Survey(cell.fits[k], part, box);
            if (folds) {
                level_.Mark(level_.bad, box);
            } else {
                SolvePart(cell, k, part, box);
            }
        }
    }
}

void TileSolver::SolvePart(const FittedCell& cell, std::size_t k, const CellPart& part,
                           const PixelBox& box) {
    const TileBox& tiles = level_.box;
    const int size = level_.size;
    const int x0 = std::max(tiles.x0, FloorTo(box.x0, size) + 1);
    const int y0 = std::max(tiles.y0, FloorTo(box.y0, size) + 1);
    const int x1 = std::min(tiles.x1, FloorTo(box.x1, size));
    const int y1 = std::min(tiles.y1, FloorTo(box.y1, size));
    block_.count = 0;
    for (int y = y0; y <= y1; ++y) {
        for (int x = x0; x <= x1; ++x) {
            const std::int32_t node = level_.node_at[level_.Node(x, y)];
            if (node < 0) continue;
            const auto n = static_cast<std::size_t>(block_.count++);
            block_.px[n] = static_cast<float>(x * size);
            block_.py[n] = static_cast<float>(y * size);
            nodes_[n] = static_cast<std::size_t>(node);
            if (block_.count == kTileNodes) SolveBlock(cell, k, part);
        }
    }
    if (block_.count > 0) SolveBlock(cell, k, part);
}

void TileSolver::SolveBlock(const FittedCell& cell, std::size_t k, const CellPart& part) {
    SolveNodes(cell.fits[k], part, block_);
    const auto fields = static_cast<std::size_t>(masks_.count());
    for (std::size_t n = 0; n < static_cast<std::size_t>(block_.count); ++n) {
        if ((block_.found >> n & 1U) == 0) continue;
        const std::size_t node = nodes_[n];
        TileLevel::Sheet& sheet = level_.sheets[block_.det[n] < 0.0F ? 1 : 0];
        if (sheet.found[k][node] < 255) ++sheet.found[k][node];
        const float inverse = 1.0F / std::abs(block_.det[n]);
        const TileColour light = light_.OfTraced(k, cell, block_.a[n], block_.b[n]);
        for (std::size_t c = 0; c < 3; ++c) sheet.rgb[3 * node + c] += inverse * light[c];
        float* const at = sheet.fields.data() + (node * kTraced + k) * fields;
        for (std::size_t f = 0; f < fields; ++f) at[f] = block_.fields[f][n];
        if (k != kTraced / 2) continue;
        sheet.middle[node] = inverse * Luminance(light_.OfAll(cell, block_.a[n], block_.b[n]));
        sheet.cell[node] = static_cast<std::int32_t>(&cell - cells_.data());
        sheet.at[node] = {block_.a[n], block_.b[n]};
    }
    block_.count = 0;
}

// Holds tiles to points of the cell itself.
void TileSolver::CheckCell(const FittedCell& cell) {
    const std::size_t k = kTraced / 2;
    const CellFit& fit = cell.fits[k];
    const PixelBox& box = cell.boxes[k];
    if (!level_.AnyWanted(box)) return;
    const float extent = std::max(box.x1 - box.x0, box.y1 - box.y0);
    const int samples = std::clamp(
        static_cast<int>(kPointsATile * extent / static_cast<float>(level_.size)) + 1, 1, 8);
    const float step = 1.0F / static_cast<float>(samples);
    for (int j = 0; j < samples; ++j) {
        for (int i = 0; i < samples; ++i) {
            CheckPoint(cell, fit, (static_cast<float>(i) + 0.5F) * step,
                       (static_cast<float>(j) + 0.5F) * step, step * step);
        }
    }
}

// `share`: of the cell that the point stands for.
void TileSolver::CheckPoint(const FittedCell& cell, const CellFit& fit, float a, float b,
                            float share) {
    const PolynomialJet x = JetOf(fit.x, a, b);
    const PolynomialJet y = JetOf(fit.y, a, b);
    const int tx = FloorTo(x.value, level_.size);
    const int ty = FloorTo(y.value, level_.size);
    const TileBox& box = level_.box;
    if (tx < box.x0 || ty < box.y0 || tx >= box.x1 || ty >= box.y1) return;
    const std::int32_t wanted = level_.tile_at[level_.Tile(tx, ty)];
    if (wanted < 0) return;
    const auto tile = static_cast<std::size_t>(wanted);
    if (level_.bad[tile] != 0) return;
    const float det = x.per_a * y.per_b - x.per_b * y.per_a;
    const std::size_t s = det < 0.0F ? 1 : 0;
    const TileLevel::Sheet& sheet = level_.sheets[s];
    if (Passes(fit, a, b)) level_.lit[s][tile] = 1;
    const std::array<std::size_t, 4> corners = level_.Corners(tx, ty);
    for (const std::size_t n : corners) {
        if (sheet.found[kTraced / 2][n] != 1) return;
    }
    const float u = x.value / static_cast<float>(level_.size) - static_cast<float>(tx);
    const float v = y.value / static_cast<float>(level_.size) - static_cast<float>(ty);
    const std::array<float, 4> w = {(1.0F - u) * (1.0F - v), u * (1.0F - v), (1.0F - u) * v, u * v};
    const auto fields = static_cast<std::size_t>(masks_.count());
    const std::size_t crossings = 2 * masks_.crossings.size();
    bool dark = false;
    for (std::size_t f = 0; f < fields; ++f) {
        const float truth = JetOf(fit.fields[f], a, b).value;
        float flat = 0.0F;
        float lo = 1e30F;
        float hi = -1e30F;
        for (std::size_t c = 0; c < 4; ++c) {
            const float at = sheet.fields[(corners[c] * kTraced + kTraced / 2) * fields + f];
            flat += w[c] * at;
            lo = std::min(lo, at);
            hi = std::max(hi, at);
        }
        const float miss = std::abs(truth - flat);
        const float spread = hi - lo;
        if (f >= crossings) {
            if (truth > spread) dark = true;
            // A rim that is nowhere near does not matter.
            if (truth < -2.0F * spread - miss) continue;
        }
        const float allowed =
            static_cast<float>(tolerance_.edge_px) * spread / static_cast<float>(level_.size);
        if (miss > allowed && !FarFromIris(corners, sheet, f)) level_.bad[tile] = 1;
    }
    for (std::size_t c = 0; c < masks_.crossings.size() && !dark; ++c) {
        const double sx = static_cast<double>(JetOf(fit.fields[2 * c], a, b).value);
        const double sy = static_cast<double>(JetOf(fit.fields[2 * c + 1], a, b).value);
        if (sx * sx + sy * sy > 1.2 * iris_.outer_radius() * iris_.outer_radius()) dark = true;
    }
    if (dark) return;
    float flat = 0.0F;
    for (std::size_t c = 0; c < 4; ++c) flat += w[c] * sheet.middle[corners[c]];
    const float truth = Luminance(light_.OfAll(cell, a, b)) / std::abs(det);
    if (!(std::abs(truth - flat) <=
          static_cast<float>(tolerance_.light) * std::max(std::abs(truth), std::abs(flat)))) {
        level_.bad[tile] = 1;
    }
    // By the picture's area that each point stands for.
    const float area = std::abs(det) * share;
    level_.truth[s][tile] += area * truth;
    level_.flat[s][tile] += area * flat;
}

// Does the light at a point pass all masks?
bool TileSolver::Passes(const CellFit& fit, float a, float b) const {
    const std::size_t crossings = masks_.crossings.size();
    for (std::size_t r = 0; r < masks_.rims.size(); ++r) {
        if (JetOf(fit.fields[2 * crossings + r], a, b).value > 0.0F) return false;
    }
    for (std::size_t c = 0; c < crossings; ++c) {
        const Vec2d p(static_cast<double>(JetOf(fit.fields[2 * c], a, b).value),
                      static_cast<double>(JetOf(fit.fields[2 * c + 1], a, b).value));
        if (iris_.Distance(p) > 0.0) return false;
    }
    return true;
}

// Is a tile clear of the iris' edge at the crossing that field f belongs to?
bool TileSolver::FarFromIris(const std::array<std::size_t, 4>& corners,
                             const TileLevel::Sheet& sheet, std::size_t f) const {
    if (f >= 2 * masks_.crossings.size()) return false;
    const auto fields = static_cast<std::size_t>(masks_.count());
    double farthest = 0.0;
    double nearest = 1e30;
    for (const std::size_t n : corners) {
        const float* const at = &sheet.fields[(n * kTraced + kTraced / 2) * fields];
        const double x = static_cast<double>(at[f / 2 * 2]);
        const double y = static_cast<double>(at[f / 2 * 2 + 1]);
        const double r = std::hypot(x, y);
        farthest = std::max(farthest, r);
        nearest = std::min(nearest, r);
    }
    return farthest < 0.9 * iris_.inner_radius() || nearest > 1.2 * iris_.outer_radius();
}

}  // namespace flare
