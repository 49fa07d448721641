// SPDX-License-Identifier: Apache-2.0
#include "core/image/tile_solver.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace flare {
namespace {

// Along each side: points at which a tile is held to its cells, and the most of a cell. Large tiles
// rest on them alone; small ones stand where masks cut, and are small.
constexpr float kPointsATile = 2.0F;
constexpr float kMostPoints = 48.0F, kFewPoints = 8.0F;

// A place in a cell, in cells of the main grid.
std::array<float, 2> InPupil(const FittedCell& cell, const std::array<float, 2>& at) {
    return {cell.u + at[0] * cell.step, cell.v + at[1] * cell.step};
}

// Found twice, on the border of two cells? In cells of the main grid.
bool SamePoint(const std::array<float, 2>& a, const std::array<float, 2>& b) {
    constexpr float kSame = 4e-3F;
    return std::abs(a[0] - b[0]) < kSame && std::abs(a[1] - b[1]) < kSame;
}

}  // namespace

void TileSolver::Run() {
    for (const std::vector<Triangle>& triangle : fitted_.triangles())
        level_.MarkTriangles(triangle, level_.folded);
    for (const FittedCell& cell : fitted_.cells()) MarkCell(cell);
    // Where lit parts and shut ones meet in a tile, an edge lies between them.
    for (const TileBits& live : level_.live) level_.cut.MarkCommon(live, level_.shut);
    for (FittedCell& cell : fitted_.cells()) {
        for (std::size_t k = 0; k < kTraced; ++k) SolveCell(cell, k);
    }
    if (masks_.count() > 0) FillEnds();
    for (std::size_t t = 0; t < level_.tiles.size(); ++t) {
        if (level_.folded.Has(level_.tiles[t][0], level_.tiles[t][1])) level_.bad[t] = 1;
    }
    for (FittedCell& cell : fitted_.cells()) {
        if (!cell.ring) CheckCell(cell);
    }
}

// Says which tiles the parts of a cell may touch, all wavelengths together.
void TileSolver::MarkCell(const FittedCell& cell) {
    if (!level_.wanted.Any(level_.Touched(cell.box))) return;
    for (const FittedPart& part : fitted_.Parts(cell)) {
        PixelBox box;
        bool folds = false;
        std::array<bool, kSheets> on_sheet{};
        for (const PartView& view : part.views) {
            box.Join(view.box);
            folds = folds || view.folds;
            for (std::size_t s = 0; s < kSheets; ++s) on_sheet[s] = on_sheet[s] || view.on_sheet[s];
        }
        // The drawn wavelengths reach a little beyond the traced ones.
        box = box.Grown(0.1F * (box.x1 - box.x0), 0.1F * (box.y1 - box.y0));
        box.Clip(cell.box);
        const TileBox tiles = level_.Touched(box);
        if (part.shut) {
            level_.shut.Mark(tiles);
            continue;
        }
        if (!part.open) level_.cut.Mark(tiles);
        if (cell.ring) continue;
        for (const PartView& view : part.views) {
            PixelBox fold = view.box;
            fold.Clip(cell.box);
            if (view.folds) level_.folded.Mark(level_.Touched(fold));
        }
        for (std::size_t s = 0; s < kSheets; ++s) {
            if (on_sheet[s] || folds) level_.live[s].Mark(tiles);
        }
    }
}

// How many masks are wanted of a cell: all if a node in the box may belong to a tile that one cuts.
int TileSolver::MasksFor(FittedCell& cell, const PixelBox& box) {
    const TileBox tiles = level_.Touched(box);
    if (masks_.count() == 0 ||
        !level_.cut.Any({tiles.x0 - 1, tiles.y0 - 1, tiles.x1 + 1, tiles.y1 + 1})) {
        return 0;
    }
    fitted_.NeedMasks(cell);
    return masks_.count();
}

// Before a cell's points are solved for or evaluated.
void TileSolver::TakeLight(TileLight::Of what, const FittedCell& cell, std::size_t k) {
    what_ = what;
    even_ = nullptr;
    if (!light_.Even(cell)) return;
    corners_ = light_.Corners(what, k, cell);
    even_ = &corners_;
}

void TileSolver::SolveCell(FittedCell& cell, std::size_t k) {
    if (!level_.wanted_nodes.Any(level_.NodesIn(cell.boxes[k]))) return;
    TakeLight(k == kTraced / 2 ? TileLight::Of::kBoth : TileLight::Of::kTraced, cell, k);
    fields_ = MasksFor(cell, cell.boxes[k]);
    const int starts = cell.starts[k];
    if (starts == 0) {
        for (const FittedPart& part : fitted_.Parts(cell)) {
            if (part.views[k].folds) continue;
            PixelBox box = part.views[k].box;
            box.Clip(cell.box);
            SolvePart(cell, k, part.range, box);
        }
        return;
    }
    const float step = 1.0F / static_cast<float>(starts);
    for (int j = 0; j < starts; ++j) {
        for (int i = 0; i < starts; ++i) {
            SolvePart(cell, k,
                      {static_cast<float>(i) * step, static_cast<float>(i + 1) * step,
                       static_cast<float>(j) * step, static_cast<float>(j + 1) * step},
                      cell.boxes[k]);
        }
    }
}

void TileSolver::SolvePart(const FittedCell& cell, std::size_t k, const CellPart& part,
                           const PixelBox& box) {
    block_.count = 0;
    level_.wanted_nodes.ForEach(level_.NodesIn(box), [&](int x, int y) {
        const int n = block_.count++;
        block_.px[n] = static_cast<float>(x * level_.size);
        block_.py[n] = static_cast<float>(y * level_.size);
        nodes_[static_cast<std::size_t>(n)] =
            static_cast<std::size_t>(level_.node_at[level_.Node(x, y)]);
        if (block_.count == kTileNodes) SolveBlock(cell, k, part);
    });
    if (block_.count > 0) SolveBlock(cell, k, part);
}

void TileSolver::SolveBlock(const FittedCell& cell, std::size_t k, const CellPart& part) {
    SolveNodes(cell.fits[k], part, fields_, even_, block_);
    for (std::uint64_t left = block_.found; left != 0; left &= left - 1) {
        const auto n = static_cast<std::size_t>(std::countr_zero(left));
        const std::size_t node = nodes_[n];
        TileLevel::Sheet& sheet = level_.sheets[block_.det[n] < 0.0F ? 1 : 0];
        std::uint8_t& found = sheet.found[k][node];
        if (found > 0) {
            const auto last = static_cast<std::size_t>(sheet.cell[k][node]);
            const std::array<float, 2> at = {block_.a[n], block_.b[n]};
            if (SamePoint(InPupil(cell, at), InPupil(fitted_.cells()[last], sheet.at[k][node])))
                continue;
        }
        if (found < 255) ++found;
        Keep(cell, k, n, node, sheet);
    }
    block_.count = 0;
}

// Point n of the block is what lands on a node.
void TileSolver::Keep(const FittedCell& cell, std::size_t k, std::size_t n, std::size_t node,
                      TileLevel::Sheet& sheet) const {
    const std::array<float, kTileLights> light = LightAt(cell, k, n);
    for (std::size_t c = 0; c < 3; ++c) sheet.rgb[3 * node + c] += light[c];
    float* const at =
        sheet.fields.data() + (node * kTraced + k) * static_cast<std::size_t>(masks_.count());
    for (std::size_t f = 0; f < static_cast<std::size_t>(fields_); ++f) at[f] = block_.fields[f][n];
    sheet.cell[k][node] = static_cast<std::int32_t>(&cell - fitted_.cells().data());
    sheet.at[k][node] = {block_.a[n], block_.b[n]};
    sheet.stretch[k][node] = std::abs(block_.det[n]);
    if (k == kTraced / 2) sheet.middle[node] = {light[3], light[4], light[5]};
}

// At a ghost's edge one wavelength may land on a node while the mesh ends before another does. That
// one is dark there, but its masks are wanted: the edges of the bands between lean on them.
void TileSolver::FillEnds() {
    fields_ = masks_.count();
    for (const auto& [x, y] : level_.tiles) {
        if (!level_.cut.Has(x, y)) continue;
        const std::array<std::size_t, 4> corners = level_.Corners(x, y);
        for (std::size_t s = 0; s < kSheets; ++s) {
            if (!level_.live[s].Has(x, y)) continue;
            for (std::size_t c = 0; c < 4; ++c) {
                FillNode(level_.sheets[s], corners[c],
                         {static_cast<float>((x + static_cast<int>(c % 2)) * level_.size),
                          static_cast<float>((y + static_cast<int>(c / 2)) * level_.size)});
            }
        }
    }
}

void TileSolver::FillNode(TileLevel::Sheet& sheet, std::size_t node,
                          const std::array<float, 2>& px) {
    constexpr float kFar = 1.5F;  // cells
    std::size_t known = kTraced;
    bool missing = false;
    for (const std::size_t k : {std::size_t{0}, kTraced - 1, kTraced / 2}) {
        if (sheet.found[k][node] == 1) known = k;
        missing = missing || sheet.found[k][node] == 0;
    }
    if (!missing || known == kTraced) return;
    FittedCell& cell = fitted_.cells()[static_cast<std::size_t>(sheet.cell[known][node])];
    fitted_.NeedMasks(cell);
    const auto [a, b] = sheet.at[known][node];
    const bool positive = &sheet == &level_.sheets[0];
    for (std::size_t k = 0; k < kTraced; ++k) {
        if (sheet.found[k][node] != 0) continue;
        what_ = k == kTraced / 2 ? TileLight::Of::kBoth : TileLight::Of::kTraced;
        even_ = nullptr;
        block_.count = 1;
        block_.px[0] = px[0];
        block_.py[0] = px[1];
        SolveNodes(cell.fits[k], {a - kFar, a + kFar, b - kFar, b + kFar}, fields_, nullptr,
                   block_);
        if (block_.found == 0 || (block_.det[0] > 0.0F) != positive) continue;
        sheet.found[k][node] = 1;
        Keep(cell, k, 0, node, sheet);
    }
}

// Of point n of the block.
std::array<float, kTileLights> TileSolver::LightAt(const FittedCell& cell, std::size_t k,
                                                   std::size_t n) const {
    std::array<float, kTileLights> light{};
    if (even_ != nullptr) {
        for (std::size_t c = 0; c < static_cast<std::size_t>(even_->count); ++c)
            light[c] = block_.light[c][n];
        return light;
    }
    light = light_.At(what_, k, cell, block_.a[n], block_.b[n]);
    for (float& value : light) value /= std::abs(block_.det[n]);
    return light;
}

// Holds tiles to points of the cell itself.
void TileSolver::CheckCell(FittedCell& cell) {
    const std::size_t k = kTraced / 2;
    const PixelBox& box = cell.boxes[k];
    if (!level_.wanted.Any(level_.Touched(box))) return;
    TakeLight(TileLight::Of::kAll, cell, k);
    fields_ = MasksFor(cell, box);
    const float extent = std::max(box.x1 - box.x0, box.y1 - box.y0);
    const float wanted = kPointsATile * extent / static_cast<float>(level_.size);
    const float most = level_.size > kLargestEdgeTile ? kMostPoints : kFewPoints;
    const int samples = static_cast<int>(std::min(wanted, most - 1.0F)) + 1;
    const float step = 1.0F / static_cast<float>(samples);
    for (int first = 0; first < samples * samples; first += kTileNodes) {
        block_.count = std::min(kTileNodes, samples * samples - first);
        for (int n = 0; n < block_.count; ++n) {
            block_.a[n] = (static_cast<float>((first + n) % samples) + 0.5F) * step;
            block_.b[n] = (static_cast<float>((first + n) / samples) + 0.5F) * step;
        }
        EvaluatePoints(cell.fits[k], fields_, even_, block_);
        for (std::size_t n = 0; n < static_cast<std::size_t>(block_.count); ++n) {
            const std::array<float, kTileLights> light = LightAt(cell, k, n);
            const bool within = block_.px[n] >= cell.box.x0 && block_.px[n] <= cell.box.x1 &&
                                block_.py[n] >= cell.box.y0 && block_.py[n] <= cell.box.y1;
            if (within) CheckPoint(n, {light[0], light[1], light[2]}, step * step);
        }
    }
}

// `share`: of the cell that point n of the block stands for.
void TileSolver::CheckPoint(std::size_t n, const TileColour& truth, float share) {
    const float px = block_.px[n];
    const float py = block_.py[n];
    const int tx = FloorTo(px, level_.size);
    const int ty = FloorTo(py, level_.size);
    const TileBox& box = level_.box;
    if (tx < box.x0 || ty < box.y0 || tx >= box.x1 || ty >= box.y1) return;
    if (!level_.wanted.Has(tx, ty)) return;
    const auto tile = static_cast<std::size_t>(level_.tile_at[level_.Tile(tx, ty)]);
    if (level_.bad[tile] != 0) return;
    const bool cut = fields_ > 0 && level_.cut.Has(tx, ty);
    const std::size_t s = block_.det[n] < 0.0F ? 1 : 0;
    const TileLevel::Sheet& sheet = level_.sheets[s];
    if (level_.lit[s][tile] == 0 && (!cut || Passes(n))) level_.lit[s][tile] = 1;
    const std::array<std::size_t, 4> corners = level_.Corners(tx, ty);
    for (const std::size_t c : corners) {
        if (sheet.found[kTraced / 2][c] != 1) return;
    }
    const float u = px / static_cast<float>(level_.size) - static_cast<float>(tx);
    const float v = py / static_cast<float>(level_.size) - static_cast<float>(ty);
    const std::array<float, 4> w = {(1.0F - u) * (1.0F - v), u * (1.0F - v), (1.0F - u) * v, u * v};
    if (cut && CheckMasks(n, sheet, tile, corners, w)) return;
    TileColour flat{};
    for (std::size_t c = 0; c < 4; ++c) {
        const TileColour& at = sheet.middle[corners[c]];
        for (std::size_t i = 0; i < 3; ++i) flat[i] += w[c] * at[i];
    }
    const float bright = Luminance(truth);
    const float shown = Luminance(flat);
    if (!(std::abs(bright - shown) <=
          static_cast<float>(tolerance_.light) * std::max(std::abs(bright), std::abs(shown)))) {
        level_.bad[tile] = 1;
    }
    // By the picture's area that each point stands for.
    const float area = std::abs(block_.det[n]) * share;
    TileLevel::Sums& sums = level_.sums[s][tile];
    sums.area += area;
    for (std::size_t i = 0; i < 3; ++i) {
        sums.truth[i] += area * truth[i];
        sums.flat[i] += area * flat[i];
    }
    sums.bulge += area * (u * (1.0F - u) + v * (1.0F - v));
}

// Holds the tile's bilinear masks to point n of the block; true if the point is well in the dark.
bool TileSolver::CheckMasks(std::size_t n, const TileLevel::Sheet& sheet, std::size_t tile,
                            const std::array<std::size_t, 4>& corners,
                            const std::array<float, 4>& w) {
    const auto fields = static_cast<std::size_t>(masks_.count());
    const std::size_t crossings = 2 * masks_.crossings.size();
    const auto outer = static_cast<float>(iris_.outer_radius());
    for (std::size_t f = 0; f < crossings; f += 2) {
        const float x = block_.fields[f][n];
        const float y = block_.fields[f + 1][n];
        if (x * x + y * y > 1.2F * outer * outer) return true;
    }
    bool miss = false;
    for (std::size_t f = 0; f < fields; ++f) {
        const float truth = block_.fields[f][n];
        float flat = 0.0F;
        float lo = 1e30F;
        float hi = -1e30F;
        for (std::size_t c = 0; c < 4; ++c) {
            const float at = sheet.fields[(corners[c] * kTraced + kTraced / 2) * fields + f];
            flat += w[c] * at;
            lo = std::min(lo, at);
            hi = std::max(hi, at);
        }
        const float off = std::abs(truth - flat);
        const float spread = hi - lo;
        if (f >= crossings) {
            // In the dark of one mask the others do not matter.
            if (truth > spread + off) return true;
            // Nor does a rim that is nowhere near.
            if (truth < -2.0F * spread - off) continue;
        }
        const float allowed = EdgeTolerance(f) * spread / static_cast<float>(level_.size);
        miss = miss || (off > allowed && !FarFromIris(corners, sheet, f));
    }
    if (miss) level_.bad[tile] = 1;
    return false;
}

// Of the edges that field f tells of, px: fringes need no more than a small part of their width.
float TileSolver::EdgeTolerance(std::size_t f) const {
    constexpr double kOfFringe = 0.04;
    double px = tolerance_.edge_px;
    if (ghost_.fringes && f < 2 * masks_.crossings.size()) {
        const GhostFringes::Crossing& crossing =
            ghost_.fringes->crossings[static_cast<std::size_t>(masks_.crossings[f / 2])];
        if (crossing.rings) px = std::max(px, kOfFringe * crossing.fringe_px);
    }
    return static_cast<float>(px);
}

// Does the light at point n of the block pass all masks?
bool TileSolver::Passes(std::size_t n) const {
    const std::size_t crossings = 2 * masks_.crossings.size();
    for (std::size_t r = 0; r < masks_.rims.size(); ++r) {
        if (block_.fields[crossings + r][n] > 0.0F) return false;
    }
    for (std::size_t f = 0; f < crossings; f += 2) {
        const Vec2d p(static_cast<double>(block_.fields[f][n]),
                      static_cast<double>(block_.fields[f + 1][n]));
        if (iris_.reach_mm() > 0.0 ? iris_.Distance(p) > iris_.reach_mm()
                                   : iris_.TransmissionAt(p) <= 0.0)
            return false;
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
        const double r = std::sqrt(x * x + y * y);
        farthest = std::max(farthest, r);
        nearest = std::min(nearest, r);
    }
    return farthest < 0.9 * iris_.inner_radius() || nearest > 1.2 * iris_.outer_radius();
}

}  // namespace flare
