// SPDX-License-Identifier: Apache-2.0
//
// Level by level: the corners of the wanted tiles are solved for in every cell; the cells' own
// points then say whether a tile's bilinear light and masks are good enough; tiles that are not go
// to the next level, those of the last one to polygons. Sheets of the two orientations are kept
// apart: a fold is where they meet, and cells that hold one mark it part by part.
#include "core/image/ghost_tiles.h"

#include <algorithm>
#include <cmath>

#include "core/image/cell_fits.h"

namespace flare {
namespace {

constexpr std::size_t kSheets = 2;  // of positive and of negative Jacobian
constexpr std::size_t kTraced = kTracedInTiles;
constexpr int kMostIrisEdges = 12;
constexpr float kPointsATile = 2.0F;  // along each side, at which a tile is held to its cells

struct TileBox {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // tiles x0 ... x1 - 1
    int width() const { return x1 - x0; }
    int height() const { return y1 - y0; }
    std::size_t count() const {
        return static_cast<std::size_t>(width()) * static_cast<std::size_t>(height());
    }
};

// The tile that holds a place; far away is far away.
int FloorTo(float value, int size) {
    constexpr float kFar = 1e6F;
    const float tile = std::floor(value / static_cast<float>(size));
    return tile > -kFar ? static_cast<int>(std::min(tile, kFar)) : -static_cast<int>(kFar);
}

// What is known of the nodes and tiles of one level: maps over the ghost's box say which are wanted
// and where their records are. A node stands at its tile's first corner.
struct Level {
    int size = 0;
    TileBox box;
    std::vector<std::int32_t> tile_at, node_at;  // of the records, -1: not wanted
    std::vector<std::array<int, 2>> tiles, nodes;

    // Records of tiles.
    std::vector<std::uint8_t> bad;                        // to be refined
    std::array<std::vector<std::uint8_t>, kSheets> live;  // cells that are drawn touch it
    std::array<std::vector<std::uint8_t>, kSheets> lit;   // one of the cells' own points passes
    // Light of the cells' own points, and what the corners make of it there, of each sheet.
    std::array<std::vector<float>, kSheets> truth, flat;

    // Records of nodes.
    struct Sheet {
        std::array<std::vector<std::uint8_t>, kTraced> found;  // solutions
        std::vector<float> rgb;          // [node][channel], over all wavelengths
        std::vector<float> middle;       // light of all bands by the middle wavelength's map
        std::vector<float> fields;       // [node][traced][field]
        std::vector<std::int32_t> cell;  // of the middle wavelength
        std::vector<std::array<float, 2>> at;
    };
    std::array<Sheet, kSheets> sheets;

    void Start(int tile_size, const TileBox& tile_box) {
        size = tile_size;
        box = tile_box;
        tile_at.assign(box.count(), -1);
        node_at.assign(
            static_cast<std::size_t>(box.width() + 1) * static_cast<std::size_t>(box.height() + 1),
            -1);
        tiles.clear();
        nodes.clear();
    }
    void Want(int x, int y) {
        tile_at[Tile(x, y)] = static_cast<std::int32_t>(tiles.size());
        tiles.push_back({x, y});
        for (int corner = 0; corner < 4; ++corner) {
            const int nx = x + corner % 2;
            const int ny = y + corner / 2;
            std::int32_t& at = node_at[Node(nx, ny)];
            if (at >= 0) continue;
            at = static_cast<std::int32_t>(nodes.size());
            nodes.push_back({nx, ny});
        }
    }
    // After all that is wanted is known.
    void MakeRecords(int fields) {
        bad.assign(tiles.size(), 0);
        for (std::size_t s = 0; s < kSheets; ++s) {
            live[s].assign(tiles.size(), 0);
            lit[s].assign(tiles.size(), 0);
            truth[s].assign(tiles.size(), 0.0F);
            flat[s].assign(tiles.size(), 0.0F);
            Sheet& sheet = sheets[s];
            for (auto& found : sheet.found) found.assign(nodes.size(), 0);
            sheet.rgb.assign(nodes.size() * 3, 0.0F);
            sheet.middle.resize(nodes.size());
            sheet.fields.resize(nodes.size() * kTraced * static_cast<std::size_t>(fields));
            sheet.cell.resize(nodes.size());
            sheet.at.resize(nodes.size());
        }
    }
    std::size_t Tile(int x, int y) const {
        return static_cast<std::size_t>(y - box.y0) * static_cast<std::size_t>(box.width()) +
               static_cast<std::size_t>(x - box.x0);
    }
    std::size_t Node(int x, int y) const {
        return static_cast<std::size_t>(y - box.y0) * static_cast<std::size_t>(box.width() + 1) +
               static_cast<std::size_t>(x - box.x0);
    }
    // Records of a wanted tile's corners.
    std::array<std::size_t, 4> Corners(int x, int y) const {
        const std::int32_t* const at = &node_at[Node(x, y)];
        const std::int32_t* const below = at + box.width() + 1;
        return {static_cast<std::size_t>(at[0]), static_cast<std::size_t>(at[1]),
                static_cast<std::size_t>(below[0]), static_cast<std::size_t>(below[1])};
    }
    // The tiles that a box of pixels touches.
    TileBox Touched(const PixelBox& b) const {
        return {std::max(box.x0, FloorTo(b.x0, size)), std::max(box.y0, FloorTo(b.y0, size)),
                std::min(box.x1, FloorTo(b.x1, size) + 1),
                std::min(box.y1, FloorTo(b.y1, size) + 1)};
    }
    void Mark(std::vector<std::uint8_t>& what, const PixelBox& b) const {
        const TileBox t = Touched(b);
        for (int y = t.y0; y < t.y1; ++y) {
            for (int x = t.x0; x < t.x1; ++x) {
                const std::int32_t tile = tile_at[Tile(x, y)];
                if (tile >= 0) what[static_cast<std::size_t>(tile)] = 1;
            }
        }
    }
};

class Tiler {
  public:
    Tiler(const GhostLight& ghost, const Iris& iris, const PictureMap& map,
          const PixelWindow& window, const TileTolerance& tolerance, double unit)
        : ghost_(ghost),
          iris_(iris),
          map_(map),
          window_(window),
          tolerance_(tolerance),
          unit_(unit),
          mesh_(ghost.surface->mesh()),
          masks_(ghost.masks) {}

    GhostTiles Run() {
        const bool polygons = masks_.count() > kTileFields || iris_.edge_count() > kMostIrisEdges;
        if (!polygons) {
            cells_ = FitCells(ghost_, map_);
            LightOfNodes();
        }
        const TileBox all = Bounds();
        if (all.width() <= 0 || all.height() <= 0) return std::move(out_);
        StartLeft(all);
        if (polygons) {
            std::fill(out_.left.begin(), out_.left.end(), std::uint8_t{1});
            out_.any_left = true;
            return std::move(out_);
        }
        for (const GhostLight::Band& band : ghost_.bands) {
            for (const double w : band.node_weights)
                out_.band_weights.push_back(static_cast<float>(w));
        }
        level_.Start(TileSize(0), all);
        for (int y = all.y0; y < all.y1; ++y) {
            for (int x = all.x0; x < all.x1; ++x) level_.Want(x, y);
        }
        for (int l = 0; l < kTileLevels; ++l) {
            RunLevel(l);
            if (l + 1 < kTileLevels && !Descend(l)) break;
        }
        return std::move(out_);
    }

  private:
    // Tiles of the coarsest level around all that is drawn, within the window.
    TileBox Bounds() const {
        PixelBox box;
        for (const GhostLight::Cell& cell : ghost_.cells) {
            if (cell.ring) continue;
            box.Join(BoxOf(cell));
        }
        if (box.empty()) return {};
        const int size = TileSize(0);
        const auto limit = [&](float value, int lo, int hi) {
            return std::clamp(value, static_cast<float>(lo), static_cast<float>(hi));
        };
        const int right = window_.x + window_.width;
        const int bottom = window_.y + window_.height;
        return {FloorTo(limit(box.x0, window_.x, right - 1), size),
                FloorTo(limit(box.y0, window_.y, bottom - 1), size),
                FloorTo(limit(box.x1, window_.x, right - 1), size) + 1,
                FloorTo(limit(box.y1, window_.y, bottom - 1), size) + 1};
    }

    void StartLeft(const TileBox& all) {
        constexpr int kFine = 1 << (kTileLevels - 1);
        out_.left_x = all.x0 * kFine;
        out_.left_y = all.y0 * kFine;
        out_.left_width = all.width() * kFine;
        out_.left_height = all.height() * kFine;
        out_.left.assign(
            static_cast<std::size_t>(out_.left_width) * static_cast<std::size_t>(out_.left_height),
            0);
    }

    // The light that each traced wavelength stands for, and that of all bands together.
    void LightOfNodes() {
        const std::size_t count = ghost_.bands.front().light.size();
        double most = 0.0;
        for (const GhostLight::Band& band : ghost_.bands) {
            for (const double light : band.light) most = std::max(most, std::abs(light));
        }
        if (most > 0.0 && std::isfinite(most)) scale_ = std::exp2(std::floor(std::log2(most)));
        for (auto& light : light_) light.assign(count, 0.0F);
        std::vector<double> sum(count);
        for (std::size_t k = 0; k <= kTraced; ++k) {
            std::fill(sum.begin(), sum.end(), 0.0);
            for (const GhostLight::Band& band : ghost_.bands) {
                const double w = k < kTraced ? band.node_weights[k] : 1.0;
                const double* const from = band.light.data();
                for (std::size_t n = 0; n < count; ++n) sum[n] += w * from[n];
            }
            for (std::size_t n = 0; n < count; ++n)
                light_[k][n] = static_cast<float>(sum[n] / scale_);
        }
    }

    // Light for each unit of the cell's own coordinates.
    std::array<float, 3> LightAt(const std::vector<float>& light, const FittedCell& cell, float a,
                                 float b) const {
        const GhostLight::Cell& from = ghost_.cells[static_cast<std::size_t>(cell.cell)];
        const int m = from.light_cuts;
        const float fa = std::clamp(a, 0.0F, 1.0F) * static_cast<float>(m);
        const float fb = std::clamp(b, 0.0F, 1.0F) * static_cast<float>(m);
        const int ia = std::min(static_cast<int>(fa), m - 1);
        const int ib = std::min(static_cast<int>(fb), m - 1);
        const float u = fa - static_cast<float>(ia);
        const float v = fb - static_cast<float>(ib);
        const auto row = static_cast<std::size_t>(m + 1) * 3;
        const float* const at = &light[from.light_at + static_cast<std::size_t>(ib) * row +
                                       static_cast<std::size_t>(ia) * 3];
        const MeshGrid& grid = mesh_.grids[static_cast<std::size_t>(from.place.grid)];
        const auto area = static_cast<float>(grid.du * grid.dv);
        std::array<float, 3> rgb{};
        for (std::size_t c = 0; c < 3; ++c) {
            rgb[c] = area * ((1.0F - v) * ((1.0F - u) * at[c] + u * at[c + 3]) +
                             v * ((1.0F - u) * at[c + row] + u * at[c + row + 3]));
        }
        return rgb;
    }

    static float Luminance(const std::array<float, 3>& rgb) {
        return 0.2126F * rgb[0] + 0.7152F * rgb[1] + 0.0722F * rgb[2];
    }

    void RunLevel(int l) {
        level_.MakeRecords(masks_.count());
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
        for (const auto& [x, y] : level_.tiles) Classify(l, x, y);
    }

    static PixelBox BoxOf(const GhostLight::Cell& cell) {
        return {static_cast<float>(cell.x0), static_cast<float>(cell.y0),
                static_cast<float>(cell.x1), static_cast<float>(cell.y1)};
    }

    bool Wanted(const PixelBox& box) const {
        const TileBox t = level_.Touched(box);
        for (int y = t.y0; y < t.y1; ++y) {
            for (int x = t.x0; x < t.x1; ++x) {
                if (level_.tile_at[level_.Tile(x, y)] >= 0) return true;
            }
        }
        return false;
    }

    void SolveCell(const FittedCell& cell, std::size_t k) {
        if (!Wanted(cell.boxes[k])) return;
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

    // The box of a part, with some room, and whether the Jacobian changes its sign there.
    static bool Survey(const CellFit& fit, const CellPart& part, PixelBox& box) {
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

    void SolvePart(const FittedCell& cell, std::size_t k, const CellPart& part,
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

    void SolveBlock(const FittedCell& cell, std::size_t k, const CellPart& part) {
        SolveNodes(cell.fits[k], part, block_);
        const auto fields = static_cast<std::size_t>(masks_.count());
        for (std::size_t n = 0; n < static_cast<std::size_t>(block_.count); ++n) {
            if ((block_.found >> n & 1U) == 0) continue;
            const std::size_t node = nodes_[n];
            Level::Sheet& sheet = level_.sheets[block_.det[n] < 0.0F ? 1 : 0];
            if (sheet.found[k][node] < 255) ++sheet.found[k][node];
            const float inverse = 1.0F / std::abs(block_.det[n]);
            const std::array<float, 3> light = LightAt(light_[k], cell, block_.a[n], block_.b[n]);
            for (std::size_t c = 0; c < 3; ++c) sheet.rgb[3 * node + c] += inverse * light[c];
            float* const at = sheet.fields.data() + (node * kTraced + k) * fields;
            for (std::size_t f = 0; f < fields; ++f) at[f] = block_.fields[f][n];
            if (k != kTraced / 2) continue;
            sheet.middle[node] =
                inverse * Luminance(LightAt(light_[kTraced], cell, block_.a[n], block_.b[n]));
            sheet.cell[node] = static_cast<std::int32_t>(&cell - cells_.data());
            sheet.at[node] = {block_.a[n], block_.b[n]};
        }
        block_.count = 0;
    }

    // Holds tiles to points of the cell itself.
    void CheckCell(const FittedCell& cell) {
        const std::size_t k = kTraced / 2;
        const CellFit& fit = cell.fits[k];
        const PixelBox& box = cell.boxes[k];
        if (!Wanted(box)) return;
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
    void CheckPoint(const FittedCell& cell, const CellFit& fit, float a, float b, float share) {
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
        const Level::Sheet& sheet = level_.sheets[s];
        if (Passes(fit, a, b)) level_.lit[s][tile] = 1;
        const std::array<std::size_t, 4> corners = level_.Corners(tx, ty);
        for (const std::size_t n : corners) {
            if (sheet.found[kTraced / 2][n] != 1) return;
        }
        const float u = x.value / static_cast<float>(level_.size) - static_cast<float>(tx);
        const float v = y.value / static_cast<float>(level_.size) - static_cast<float>(ty);
        const std::array<float, 4> w = {(1.0F - u) * (1.0F - v), u * (1.0F - v), (1.0F - u) * v,
                                        u * v};
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
        const float truth = Luminance(LightAt(light_[kTraced], cell, a, b)) / std::abs(det);
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
    bool Passes(const CellFit& fit, float a, float b) const {
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
    bool FarFromIris(const std::array<std::size_t, 4>& corners, const Level::Sheet& sheet,
                     std::size_t f) const {
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

    void Classify(int l, int x, int y) {
        const auto tile = static_cast<std::size_t>(level_.tile_at[level_.Tile(x, y)]);
        const std::array<std::size_t, 4> corners = level_.Corners(x, y);
        bool bad = level_.bad[tile] != 0;
        const std::size_t smooth_before = out_.smooth.size();
        const std::size_t edges_before = out_.edges.size();
        std::array<bool, kSheets> lit{};
        for (std::size_t s = 0; s < kSheets && !bad; ++s) {
            int none = 0;
            int once = 0;
            for (const std::size_t n : corners) {
                for (std::size_t k = 0; k < kTraced; ++k) {
                    const int found = level_.sheets[s].found[k][n];
                    none += found == 0 ? 1 : 0;
                    once += found == 1 ? 1 : 0;
                }
            }
            constexpr int kAll = 4 * kTracedInTiles;
            lit[s] = once == kAll;
            if (none != kAll && once != kAll) bad = true;
            // Cells that lie between the corners.
            if (none == kAll && level_.live[s][tile] != 0) bad = true;
        }
        for (std::size_t s = 0; s < kSheets && !bad; ++s) {
            if (!lit[s]) continue;
            // Bilinear light is too much where light is convex: the points within set it right.
            const float flat = level_.flat[s][tile];
            const float scale = flat > 0.0F ? level_.truth[s][tile] / flat : 1.0F;
            // The corners may all be dark while light passes between them.
            const bool passes = Emit(l, x, y, level_.sheets[s], corners, scale);
            bad = !passes && level_.lit[s][tile] != 0;
        }
        if (!bad) return;
        out_.smooth.resize(smooth_before);
        out_.edges.resize(edges_before);
        level_.bad[tile] = 1;
        if (l + 1 < kTileLevels) return;
        out_.left[static_cast<std::size_t>(y - out_.left_y) *
                      static_cast<std::size_t>(out_.left_width) +
                  static_cast<std::size_t>(x - out_.left_x)] = 1;
        out_.any_left = true;
    }

    // Corner values of a condition at one wavelength, as pixels across the edge.
    struct Scalar {
        std::array<float, 4> at{};
        float lo = 0.0F, hi = 0.0F;  // over the tile, with half a pixel of room
    };

    static Scalar InPixels(std::array<float, 4> at, int size) {
        const float per_x = 0.5F * (at[1] - at[0] + at[3] - at[2]) / static_cast<float>(size);
        const float per_y = 0.5F * (at[2] - at[0] + at[3] - at[1]) / static_cast<float>(size);
        const float inverse = 1.0F / std::max(std::abs(per_x) + std::abs(per_y), 1e-20F);
        Scalar out;
        for (std::size_t c = 0; c < 4; ++c) out.at[c] = std::clamp(at[c] * inverse, -1e6F, 1e6F);
        out.lo = *std::min_element(out.at.begin(), out.at.end()) - 0.5F;
        out.hi = *std::max_element(out.at.begin(), out.at.end()) + 0.5F;
        return out;
    }

    float Field(const Level::Sheet& sheet, std::size_t node, std::size_t k, std::size_t f) const {
        return sheet.fields[(node * kTraced + k) * static_cast<std::size_t>(masks_.count()) + f];
    }

    // Adds a straight edge if it cuts the tile; false if it shuts it out. `at(k)` gives its corner
    // values at a traced wavelength.
    template <class At>
    bool AddStraight(At at, int size) {
        std::array<Scalar, kTraced> edge;
        float lo = 1e30F;
        float hi = -1e30F;
        for (std::size_t k = 0; k < kTraced; ++k) {
            edge[k] = InPixels(at(k), size);
            lo = std::min(lo, edge[k].lo);
            hi = std::max(hi, edge[k].hi);
        }
        const float room = 0.1F * (hi - lo);
        if (lo - room > 0.5F) return false;
        if (hi + room < -0.5F) return true;
        straight_.push_back(edge);
        return true;
    }

    // The same for an arc of the iris at crossing c.
    bool AddArc(const Iris::Edge& edge, std::size_t c, const Level::Sheet& sheet,
                const std::array<std::size_t, 4>& corners, int size) {
        std::array<ArcEdge, kTraced> arcs;
        bool shut = true;
        bool open = true;
        const auto r = static_cast<float>(edge.radius);
        for (std::size_t k = 0; k < kTraced; ++k) {
            ArcEdge& arc = arcs[k];
            PixelBox box;
            for (std::size_t n = 0; n < 4; ++n) {
                arc.x[n] = Field(sheet, corners[n], k, 2 * c) - static_cast<float>(edge.centre.x);
                arc.y[n] =
                    Field(sheet, corners[n], k, 2 * c + 1) - static_cast<float>(edge.centre.y);
                box.Join({arc.x[n], arc.y[n], arc.x[n], arc.y[n]});
            }
            arc.radius2 = r * r;
            const float step = 0.5F / static_cast<float>(size);
            arc.per_x_x = step * (arc.x[1] - arc.x[0] + arc.x[3] - arc.x[2]);
            arc.per_x_y = step * (arc.y[1] - arc.y[0] + arc.y[3] - arc.y[2]);
            arc.per_y_x = step * (arc.x[2] - arc.x[0] + arc.x[3] - arc.x[1]);
            arc.per_y_y = step * (arc.y[2] - arc.y[0] + arc.y[3] - arc.y[1]);
            // A pixel and a tenth of the tile on all sides, in mm.
            const float room_x = std::abs(arc.per_x_x) + std::abs(arc.per_y_x);
            const float room_y = std::abs(arc.per_x_y) + std::abs(arc.per_y_y);
            const float dx = std::max({box.x0 - room_x, -box.x1 - room_x, 0.0F});
            const float dy = std::max({box.y0 - room_y, -box.y1 - room_y, 0.0F});
            shut = shut && dx * dx + dy * dy > r * r;
            const float fx = std::max(std::abs(box.x0), std::abs(box.x1)) + room_x;
            const float fy = std::max(std::abs(box.y0), std::abs(box.y1)) + room_y;
            open = open && fx * fx + fy * fy < r * r;
        }
        if (shut) return false;
        if (!open) arcs_.push_back(arcs);
        return true;
    }

    // False if a mask shuts the tile out.
    bool Emit(int l, int x, int y, const Level::Sheet& sheet,
              const std::array<std::size_t, 4>& corners, float scale) {
        straight_.clear();
        arcs_.clear();
        for (std::size_t c = 0; c < masks_.crossings.size(); ++c) {
            for (int e = 0; e < iris_.edge_count(); ++e) {
                const Iris::Edge& edge = iris_.edge(e);
                const bool passes =
                    edge.radius > 0.0 ? AddArc(edge, c, sheet, corners, level_.size)
                                      : AddStraight(
                                            [&](std::size_t k) {
                                                std::array<float, 4> at{};
                                                for (std::size_t n = 0; n < 4; ++n) {
                                                    at[n] = Field(sheet, corners[n], k, 2 * c) *
                                                                static_cast<float>(edge.normal.x) +
                                                            Field(sheet, corners[n], k, 2 * c + 1) *
                                                                static_cast<float>(edge.normal.y) -
                                                            static_cast<float>(edge.offset);
                                                }
                                                return at;
                                            },
                                            level_.size);
                if (!passes) return false;
            }
        }
        for (std::size_t r = 0; r < masks_.rims.size(); ++r) {
            const std::size_t f = 2 * masks_.crossings.size() + r;
            const auto at = [&](std::size_t k) {
                std::array<float, 4> values{};
                for (std::size_t n = 0; n < 4; ++n) values[n] = Field(sheet, corners[n], k, f);
                return values;
            };
            if (!AddStraight(at, level_.size)) return false;
        }
        TileCorners light{};
        for (std::size_t n = 0; n < 4; ++n) {
            for (std::size_t c = 0; c < 3; ++c) light[n][c] = scale * sheet.rgb[3 * corners[n] + c];
        }
        if (straight_.empty() && arcs_.empty()) {
            Rescale(light);
            out_.smooth.push_back({static_cast<std::int16_t>(l), x, y, light});
            return true;
        }
        EmitEdge(l, x, y, sheet, corners, light);
        return true;
    }

    void EmitEdge(int l, int x, int y, const Level::Sheet& sheet,
                  const std::array<std::size_t, 4>& corners, const TileCorners& light) {
        EdgeTile tile;
        tile.level = static_cast<std::int16_t>(l);
        tile.x = x;
        tile.y = y;
        tile.straight = static_cast<int>(straight_.size());
        tile.arcs = static_cast<int>(arcs_.size());
        tile.corners = light;
        tile.straight_at = out_.straight_edges.size();
        tile.arcs_at = out_.arc_edges.size();
        tile.bands_at = out_.band_sharpness.size();
        tile.dispersed = Disperses();
        const std::size_t first = tile.dispersed ? 0 : kTraced / 2;
        const std::size_t end = tile.dispersed ? kTraced : first + 1;
        for (std::size_t k = first; k < end; ++k) {
            for (const auto& edge : straight_) {
                out_.straight_edges.push_back(
                    {{edge[k].at[0], edge[k].at[1], edge[k].at[2], edge[k].at[3]}});
            }
            for (const auto& arc : arcs_) out_.arc_edges.push_back(arc[k]);
        }
        if (tile.dispersed) AddBands(tile, sheet, corners);
        Rescale(tile.corners);
        out_.edges.push_back(tile);
    }

    void Rescale(TileCorners& light) const {
        const double factor = scale_ / unit_;
        for (auto& corner : light) {
            for (float& value : corner) value = static_cast<float>(value * factor);
        }
    }

    // Do the wavelengths' edges lie apart?
    bool Disperses() const {
        constexpr float kTogether_px = 0.1F;
        if (ghost_.bands.size() < 2) return false;
        if (!arcs_.empty()) {
            for (const auto& arc : arcs_) {
                for (std::size_t n = 0; n < 4; ++n) {
                    const float dx = std::abs(arc[0].x[n] - arc[kTraced - 1].x[n]);
                    const float dy = std::abs(arc[0].y[n] - arc[kTraced - 1].y[n]);
                    const float mm = std::hypot(arc[1].per_x_x, arc[1].per_x_y);
                    if (std::max(dx, dy) > kTogether_px * mm) return true;
                }
            }
        }
        for (const auto& edge : straight_) {
            for (std::size_t n = 0; n < 4; ++n) {
                if (std::abs(edge[0].at[n] - edge[kTraced - 1].at[n]) > kTogether_px) return true;
            }
        }
        return false;
    }

    // Each band's share of the tile's light, and how wide its edge is: a band stands for the
    // wavelengths around it, whose edges lie side by side.
    void AddBands(EdgeTile& tile, const Level::Sheet& sheet,
                  const std::array<std::size_t, 4>& corners) {
        const std::size_t bands = ghost_.bands.size();
        out_.band_rgb.resize(out_.band_rgb.size() + 3 * bands, 0.0F);
        float* const rgb = &out_.band_rgb[3 * tile.bands_at];
        std::array<float, 3> sum{};
        std::array<float, 3> all{};
        for (std::size_t b = 0; b < bands; ++b) {
            for (const std::size_t n : corners) {
                const FittedCell& cell = cells_[static_cast<std::size_t>(sheet.cell[n])];
                const std::array<float, 3> at =
                    BandLightAt(b, cell, sheet.at[n][0], sheet.at[n][1]);
                for (std::size_t c = 0; c < 3; ++c) rgb[3 * b + c] += at[c];
            }
            for (std::size_t c = 0; c < 3; ++c) {
                sum[c] += rgb[3 * b + c];
                all[c] += std::abs(rgb[3 * b + c]);
            }
        }
        // Fully covered pixels get the light of the corners. A channel whose bands cancel takes the
        // luminance's factor.
        std::array<float, 4> whole{};
        for (std::size_t n = 0; n < 4; ++n) whole[n] = Luminance(tile.corners[n]);
        const float luminance = std::max(Luminance(sum), 1e-30F);
        for (std::size_t c = 0; c < 3; ++c) {
            const bool steady = std::abs(sum[c]) > 0.2F * all[c];
            for (std::size_t n = 0; n < 4; ++n) {
                tile.corners[n][c] = steady ? tile.corners[n][c] / sum[c] : whole[n] / luminance;
            }
        }
        AddSharpness();
    }

    // From how far each band's edge lies from its neighbours', at the middle of the tile.
    void AddSharpness() {
        const std::size_t bands = ghost_.bands.size();
        std::array<float, kTraced> over{};
        over.fill(-1e6F);
        for (std::size_t k = 0; k < kTraced; ++k) {
            for (const auto& edge : straight_) {
                const auto& at = edge[k].at;
                over[k] = std::max(over[k], 0.25F * (at[0] + at[1] + at[2] + at[3]));
            }
            for (const auto& arcs : arcs_) {
                const ArcEdge& arc = arcs[k];
                const float x = 0.25F * (arc.x[0] + arc.x[1] + arc.x[2] + arc.x[3]);
                const float y = 0.25F * (arc.y[0] + arc.y[1] + arc.y[2] + arc.y[3]);
                const float slope = std::abs(x * arc.per_x_x + y * arc.per_x_y) +
                                    std::abs(x * arc.per_y_x + y * arc.per_y_y);
                over[k] = std::max(over[k],
                                   (x * x + y * y - arc.radius2) / std::max(2.0F * slope, 1e-20F));
            }
        }
        const auto at = [&](std::size_t b) {
            float sum = 0.0F;
            for (std::size_t k = 0; k < kTraced; ++k)
                sum += static_cast<float>(ghost_.bands[b].node_weights[k]) * over[k];
            return sum;
        };
        for (std::size_t b = 0; b < bands; ++b) {
            const std::size_t lo = b > 0 ? b - 1 : 0;
            const std::size_t hi = std::min(b + 1, bands - 1);
            const float step = (at(hi) - at(lo)) / static_cast<float>(hi - lo);
            out_.band_sharpness.push_back(1.0F / std::sqrt(1.0F + step * step));
        }
    }

    // Of one band, by the nearest point of the cell's lattice.
    std::array<float, 3> BandLightAt(std::size_t band, const FittedCell& cell, float a,
                                     float b) const {
        const GhostLight::Cell& from = ghost_.cells[static_cast<std::size_t>(cell.cell)];
        const int m = from.light_cuts;
        const int i = std::clamp(static_cast<int>(std::lround(a * static_cast<float>(m))), 0, m);
        const int j = std::clamp(static_cast<int>(std::lround(b * static_cast<float>(m))), 0, m);
        const double* const at =
            &ghost_.bands[band]
                 .light[from.light_at + static_cast<std::size_t>(j * (m + 1) + i) * 3];
        return {static_cast<float>(at[0] / scale_), static_cast<float>(at[1] / scale_),
                static_cast<float>(at[2] / scale_)};
    }

    // Makes the next level's wanted tiles of this one's bad ones; false if there are none.
    bool Descend(int l) {
        std::vector<std::array<int, 2>> bad;
        for (std::size_t t = 0; t < level_.tiles.size(); ++t) {
            if (level_.bad[t] != 0) bad.push_back(level_.tiles[t]);
        }
        if (bad.empty()) return false;
        TileBox box{bad[0][0], bad[0][1], bad[0][0], bad[0][1]};
        for (const auto& [x, y] : bad) {
            box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x),
                   std::max(box.y1, y)};
        }
        level_.Start(TileSize(l + 1), {2 * box.x0, 2 * box.y0, 2 * box.x1 + 2, 2 * box.y1 + 2});
        for (const auto& [x, y] : bad) {
            for (int child = 0; child < 4; ++child)
                level_.Want(2 * x + child % 2, 2 * y + child / 2);
        }
        return true;
    }

    const GhostLight& ghost_;
    const Iris& iris_;
    const PictureMap& map_;
    const PixelWindow& window_;
    const TileTolerance& tolerance_;
    double unit_;
    double scale_ = 1.0;  // of the light that floats stand for here: a power of two
    const GhostMesh& mesh_;
    const MaskFields& masks_;
    std::vector<FittedCell> cells_;
    std::array<std::vector<float>, kTraced + 1> light_;  // laid out as GhostLight::Band::light
    Level level_;
    NodeBlock block_;
    std::array<std::size_t, kTileNodes> nodes_{};
    std::vector<std::array<Scalar, kTraced>> straight_;
    std::vector<std::array<ArcEdge, kTraced>> arcs_;
    GhostTiles out_;
};

}  // namespace

bool CanBeTiled(const GhostLight& ghost) {
    return ghost.channels == 3 && !ghost.bands.empty() &&
           ghost.bands.front().node_weights.size() == static_cast<std::size_t>(kTracedInTiles);
}

GhostTiles TilesOf(const GhostLight& ghost, const Iris& iris, const PictureMap& map,
                   const PixelWindow& window, const TileTolerance& tolerance, double unit) {
    if (ghost.cells.empty()) return {};
    return Tiler(ghost, iris, map, window, tolerance, unit).Run();
}

}  // namespace flare
