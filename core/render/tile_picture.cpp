// SPDX-License-Identifier: Apache-2.0
#include "core/render/tile_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/image/raster_sink.h"
#include "core/image/tile_pass.h"

namespace flare {
namespace {

constexpr int kBlock = kLargestTile;  // pixels a side; a strip is a row of blocks
constexpr int kFinest = TileSize(kTileLevels - 1);
constexpr std::size_t kCornerNumbers = 12;

int FloorDiv(int value, int by) {
    return value >= 0 ? value / by : -((-value + by - 1) / by);
}

constexpr std::size_t kLeftTilePixels = std::size_t{kFinest} * kFinest;
constexpr std::size_t kLeftNumbers = 3 * kLeftTilePixels;
using LeftTile = std::array<float, kLeftNumbers>;

// Where the numbers of tile (x, y) begin.
std::size_t LeftAt(const GhostTiles& tiles, const LeftPixels& pixels, int x, int y) {
    const auto row = static_cast<std::size_t>(y - tiles.left_y);
    const auto begin = tiles.left.begin() + static_cast<std::ptrdiff_t>(row) * tiles.left_width;
    const auto before = std::count_if(begin, begin + (x - tiles.left_x),
                                      [](std::uint8_t left) { return left != 0; });
    return (pixels.row_at[row] + static_cast<std::size_t>(before)) * kLeftNumbers;
}

// Passes on only the pieces that touch tiles of a block that are left to polygons.
class LeftSink final : public PieceSink {
  public:
    LeftSink(const GhostTiles& tiles, const PixelWindow& block, RasterSink& to)
        : tiles_(tiles),
          x0_(block.x / kFinest),
          y0_(block.y / kFinest),
          x1_((block.x + block.width) / kFinest - 1),
          y1_((block.y + block.height) / kFinest - 1),
          to_(to) {}

    bool Wants(const Vec2d& lo, const Vec2d& hi) const override {
        const auto tile = [](double value, int first, int last) {
            const double t = std::floor(value / kFinest);
            return static_cast<int>(std::clamp(t, first - 1.0, last + 1.0));
        };
        const int end_x = std::min(tile(hi.x, x0_, x1_), x1_);
        const int end_y = std::min(tile(hi.y, y0_, y1_), y1_);
        for (int y = std::max(tile(lo.y, y0_, y1_), y0_); y <= end_y; ++y) {
            for (int x = std::max(tile(lo.x, x0_, x1_), x0_); x <= end_x; ++x) {
                if (tiles_.Left(x, y)) return true;
            }
        }
        return false;
    }
    void Add(std::span<const Vec2d> points, std::span<const double> light, int band) override {
        Vec2d lo(1e300), hi(-1e300);
        for (const Vec2d& p : points) {
            lo = {std::min(lo.x, p.x), std::min(lo.y, p.y)};
            hi = {std::max(hi.x, p.x), std::max(hi.y, p.y)};
        }
        if (Wants(lo, hi)) to_.Add(points, light, band);
    }
    void EndOfPiece() override { to_.EndOfPiece(); }

  private:
    const GhostTiles& tiles_;
    int x0_, y0_, x1_, y1_;  // tiles of the block, the last included
    RasterSink& to_;
};

}  // namespace

std::size_t LeftPixels::BytesFor(const GhostTiles& tiles) {
    const auto count = std::count_if(tiles.left.begin(), tiles.left.end(),
                                     [](std::uint8_t left) { return left != 0; });
    return static_cast<std::size_t>(count) * kLeftNumbers * sizeof(float);
}

LeftPixels::LeftPixels(const GhostTiles& tiles) {
    std::uint32_t count = 0;
    for (std::size_t row = 0; row < static_cast<std::size_t>(tiles.left_height); ++row) {
        row_at.push_back(count);
        const auto begin = tiles.left.begin() + static_cast<std::ptrdiff_t>(row) * tiles.left_width;
        count += static_cast<std::uint32_t>(std::count_if(
            begin, begin + tiles.left_width, [](std::uint8_t left) { return left != 0; }));
    }
    rgb.resize(count * kLeftNumbers);
}

struct TilePicture::Strip {
    int row = 0;                   // of blocks, from the frame's middle
    int y0 = 0, y1 = 0;            // rows of the padded window
    std::vector<double> polygons;  // of a block
};

PixelWindow WholeBlocks(const PixelWindow& window) {
    const int x0 = FloorDiv(window.x, kBlock) * kBlock;
    const int y0 = FloorDiv(window.y, kBlock) * kBlock;
    const int x1 = -FloorDiv(-(window.x + window.width), kBlock) * kBlock;
    const int y1 = -FloorDiv(-(window.y + window.height), kBlock) * kBlock;
    return {x0, y0, x1 - x0, y1 - y0};
}

TilePicture::TilePicture(const PixelWindow& window, int width, int height, double unit)
    : middle_x_(width / 2), middle_y_(height / 2), unit_(unit) {
    window_ = FromMiddle(window);
    padded_ = WholeBlocks(window_);
    const int x0 = padded_.x;
    const int y0 = padded_.y;
    for (int l = 0; l < kTileLevels; ++l) {
        Plane& plane = planes_[static_cast<std::size_t>(l)];
        const int size = TileSize(l);
        plane.x0 = x0 / size;
        plane.y0 = y0 / size;
        plane.width = padded_.width / size;
        plane.height = padded_.height / size;
        plane.lit.assign(
            static_cast<std::size_t>(plane.words()) * static_cast<std::size_t>(plane.height), 0);
    }
    for (auto& plane : pixels_) plane = std::make_unique_for_overwrite<float[]>(padded_.pixels());
    inked_.assign(static_cast<std::size_t>(padded_.height / kBlock), 0);
}

void TilePicture::Clear() {
    for (Plane& plane : planes_) std::fill(plane.lit.begin(), plane.lit.end(), 0);
    std::fill(inked_.begin(), inked_.end(), std::uint8_t{0});
}

PictureMap TilePicture::MapFromMiddle(PictureMap map) const {
    map.offset_px -= Vec2d(middle_x_, middle_y_);
    return map;
}

PixelWindow TilePicture::FromMiddle(const PixelWindow& window) const {
    return {window.x - middle_x_, window.y - middle_y_, window.width, window.height};
}

TilePicture::Drawn TilePicture::Draw(const std::vector<TiledGhost>& ghosts, const Iris& iris,
                                     const PictureMap& map, const WalkTolerance& tolerance,
                                     ThreadPool& threads, const CancelToken& cancel,
                                     std::span<LeftPixels> kept) {
    const int strips = (padded_.height + kBlock - 1) / kBlock;
    std::vector<Drawn> drawn(static_cast<std::size_t>(strips));
    MakeRoom(ghosts);
    threads.For(strips, [&](int s) {
        Strip strip;
        strip.row = padded_.y / kBlock + s;
        strip.y0 = padded_.y + s * kBlock;
        strip.y1 = std::min(strip.y0 + kBlock, padded_.y + padded_.height);
        for (std::size_t n = 0; n < ghosts.size(); ++n) {
            const TiledGhost& ghost = ghosts[n];
            if (cancel.cancelled()) return;
            if (!ghost.tiles) continue;
            Drawn& sum = drawn[static_cast<std::size_t>(s)];
            DrawSmooth(*ghost.tiles, strip, sum);
            DrawEdges(ghost, iris, strip, sum);
            if (!ghost.tiles->any_left) continue;
            if (ghost.left) {
                AddLeft(ghost, strip, sum);
                continue;
            }
            LeftPixels* const keep = kept.empty() || kept[n].rgb.empty() ? nullptr : &kept[n];
            DrawLeft(ghost, iris, map, tolerance, strip, keep, sum);
        }
    });
    Drawn sum;
    for (const Drawn& d : drawn) {
        sum.pieces += d.pieces;
        sum.fragments += d.fragments;
    }
    return sum;
}

// For the smooth tiles of all levels that there are.
void TilePicture::MakeRoom(const std::vector<TiledGhost>& ghosts) {
    std::array<bool, kTileLevels> wanted{};
    for (const TiledGhost& ghost : ghosts) {
        if (!ghost.tiles) continue;
        for (const SmoothTile& tile : ghost.tiles->smooth)
            wanted[static_cast<std::size_t>(tile.level)] = true;
    }
    for (std::size_t l = 0; l < kTileLevels; ++l) {
        Plane& plane = planes_[l];
        if (!wanted[l] || plane.corners) continue;
        plane.corners = std::make_unique_for_overwrite<float[]>(
            static_cast<std::size_t>(plane.width) * static_cast<std::size_t>(plane.height) *
            kCornerNumbers);
    }
}

void TilePicture::Ink(const Strip& strip) {
    std::uint8_t& inked = inked_[static_cast<std::size_t>((strip.y0 - padded_.y) / kBlock)];
    if (inked != 0) return;
    inked = 1;
    const auto pixels = static_cast<std::ptrdiff_t>(strip.y1 - strip.y0) * padded_.width;
    for (std::size_t c = 0; c < 3; ++c) std::fill_n(Row(c, strip.y0), pixels, 0.0F);
}

void TilePicture::DrawSmooth(const GhostTiles& tiles, const Strip& strip, Drawn& drawn) {
    for (const SmoothTile& tile : tiles.smooth_rows.In(tiles.smooth, strip.row)) {
        Plane& plane = planes_[static_cast<std::size_t>(tile.level)];
        const auto x = static_cast<std::size_t>(tile.x - plane.x0);
        const auto y = static_cast<std::size_t>(tile.y - plane.y0);
        std::uint64_t& word = plane.lit[y * static_cast<std::size_t>(plane.words()) + x / 64];
        const std::uint64_t bit = std::uint64_t{1} << (x % 64);
        float* const at =
            &plane.corners[(y * static_cast<std::size_t>(plane.width) + x) * kCornerNumbers];
        if ((word & bit) == 0) std::fill_n(at, kCornerNumbers, 0.0F);
        word |= bit;
        for (std::size_t n = 0; n < 4; ++n) {
            for (std::size_t c = 0; c < 3; ++c) at[3 * n + c] += tile.corners[n][c];
        }
        ++drawn.pieces;
    }
}

void TilePicture::DrawEdges(const TiledGhost& ghost, const Iris& iris, const Strip& strip,
                            Drawn& drawn) {
    const GhostTiles& tiles = *ghost.tiles;
    const GhostFringes* const fringes = ghost.light.fringes.get();
    const std::span<const EdgeTile> edges = tiles.edge_rows.In(tiles.edges, strip.row);
    if (edges.empty()) return;
    Ink(strip);
    std::vector<float> pass;
    for (const EdgeTile& tile : edges) {
        const int size = TileSize(tile.level);
        EdgeShade shade;
        shade.size = size;
        shade.straight = tile.straight;
        shade.arcs = tile.arcs;
        shade.straight_edges = tiles.straight_edges.data() + tile.straight_at;
        shade.arc_edges = tiles.arc_edges.data() + tile.arcs_at;
        for (std::size_t n = 0; n < 4; ++n) {
            for (std::size_t c = 0; c < 3; ++c) shade.light[c][n] = tile.corners[n][c];
        }
        if (tile.fringes > 0) {
            shade.fringes = tile.fringes;
            shade.fringe_edges = tiles.fringe_edges.data() + tile.fringes_at;
            shade.fringe_tables = fringes->tables.data();
            shade.fringe_entries = fringes->entries;
            shade.fringe_start = static_cast<float>(fringes->dark_t / fringes->step_t);
        }
        if (tile.dispersed) {
            shade.bands = static_cast<int>(tiles.band_weights.size() / kTracedInTiles);
            shade.band_rgb = tiles.band_rgb.data() + 3 * tile.bands_at;
            shade.band_sharpness = tiles.band_sharpness.data() + tile.bands_at;
            shade.band_weights = tiles.band_weights.data();
        }
        if (tile.pictured > 0) {
            FindTilePass(tiles, tile, *iris.picture(), pass);
            shade.pass = pass.data();
        }
        std::array<float*, 3> to{};
        for (std::size_t c = 0; c < 3; ++c)
            to[c] = Row(c, tile.y * size) + (tile.x * size - padded_.x);
        ShadeEdge(shade, to.data(), padded_.width);
        ++drawn.pieces;
        drawn.fragments += static_cast<std::uint64_t>(size) * static_cast<std::uint64_t>(size);
    }
}

void TilePicture::DrawLeft(const TiledGhost& ghost, const Iris& iris, const PictureMap& map,
                           const WalkTolerance& tolerance, Strip& strip, LeftPixels* kept,
                           Drawn& drawn) {
    const GhostTiles& tiles = *ghost.tiles;
    const int first_y = std::max(tiles.left_y * kFinest, strip.y0);
    const int end_y = std::min((tiles.left_y + tiles.left_height) * kFinest, strip.y1);
    if (end_y <= first_y) return;
    const int first_x = FloorDiv(tiles.left_x * kFinest, kBlock) * kBlock;
    const int end_x = (tiles.left_x + tiles.left_width) * kFinest;
    for (int x = first_x; x < end_x; x += kBlock) {
        // What is left within the block; the same whatever the window.
        PixelWindow left{x + kBlock, strip.y1, 0, 0};
        int right = x;
        int bottom = strip.y0;
        for (int ty = first_y / kFinest; ty < end_y / kFinest; ++ty) {
            for (int tx = x / kFinest; tx < (x + kBlock) / kFinest; ++tx) {
                if (!tiles.Left(tx, ty)) continue;
                left.x = std::min(left.x, tx * kFinest);
                left.y = std::min(left.y, ty * kFinest);
                right = std::max(right, (tx + 1) * kFinest);
                bottom = std::max(bottom, (ty + 1) * kFinest);
            }
        }
        if (right == x) continue;
        left.width = right - left.x;
        left.height = bottom - left.y;
        DrawBlock(ghost, left, iris, map, tolerance, strip, kept, drawn);
    }
}

// The tiles that are left in a part of a block.
void TilePicture::DrawBlock(const TiledGhost& ghost, const PixelWindow& box, const Iris& iris,
                            const PictureMap& map, const WalkTolerance& tolerance, Strip& strip,
                            LeftPixels* kept, Drawn& drawn) {
    const GhostTiles& tiles = *ghost.tiles;
    Ink(strip);
    strip.polygons.assign(box.pixels() * kColourStride, 0.0);
    RasterTarget target;
    target.x0 = box.x;
    target.y0 = box.y;
    target.width = box.width;
    target.rows = box.height;
    target.layers = {strip.polygons.data()};
    const WalkWindow window{static_cast<double>(box.x), static_cast<double>(box.y),
                            static_cast<double>(box.x + box.width),
                            static_cast<double>(box.y + box.height)};
    RasterSink raster(ghost.light, target);
    LeftSink sink(tiles, box, raster);
    GhostWalk walk(ghost.light, iris, map, tolerance);
    for (const GhostLight::Cell& cell : ghost.light.cells) {
        if (cell.ring || cell.y1 < window.y0 || cell.y0 > window.y1 || cell.x1 < window.x0 ||
            cell.x0 > window.x1) {
            continue;
        }
        walk.Cell(cell, window, sink);
    }
    for (int y = box.y / kFinest; y < (box.y + box.height) / kFinest; ++y) {
        for (int x = box.x / kFinest; x < (box.x + box.width) / kFinest; ++x) {
            if (!tiles.Left(x, y)) continue;
            const double* const from =
                &strip.polygons[(static_cast<std::size_t>(y * kFinest - box.y) *
                                     static_cast<std::size_t>(box.width) +
                                 static_cast<std::size_t>(x * kFinest - box.x)) *
                                kColourStride];
            LeftTile tile;
            for (std::size_t n = 0; n < tile.size(); ++n) {
                const std::size_t c = n / kLeftTilePixels;
                const std::size_t row = n % kLeftTilePixels / kFinest;
                const std::size_t i = n % kFinest;
                const std::size_t at = row * static_cast<std::size_t>(box.width) + i;
                tile[n] = static_cast<float>(from[at * kColourStride + c] / unit_);
            }
            AddLeftTile(x, y, tile.data());
            if (kept) std::copy(tile.begin(), tile.end(), &kept->rgb[LeftAt(tiles, *kept, x, y)]);
        }
    }
    drawn.pieces += walk.pieces();
    drawn.fragments += raster.fragments();
}

void TilePicture::AddLeftTile(int x, int y, const float* rgb) {
    for (std::size_t c = 0; c < 3; ++c) {
        for (int row = 0; row < kFinest; ++row) {
            float* const to = Row(c, y * kFinest + row) + (x * kFinest - padded_.x);
            for (int i = 0; i < kFinest; ++i) to[i] += *rgb++;
        }
    }
}

// What polygons drew before.
void TilePicture::AddLeft(const TiledGhost& ghost, const Strip& strip, Drawn& drawn) {
    const GhostTiles& tiles = *ghost.tiles;
    const int first = std::max(tiles.left_y, strip.y0 / kFinest);
    const int end = std::min(tiles.left_y + tiles.left_height, strip.y1 / kFinest);
    if (first < end) Ink(strip);
    for (int y = first; y < end; ++y) {
        const auto row = static_cast<std::size_t>(y - tiles.left_y);
        const float* from = ghost.left->rgb.data() + ghost.left->row_at[row] * kLeftNumbers;
        const std::uint8_t* const left =
            &tiles.left[row * static_cast<std::size_t>(tiles.left_width)];
        for (int x = 0; x < tiles.left_width; ++x) {
            if (left[x] == 0) continue;
            AddLeftTile(tiles.left_x + x, y, from);
            from += kLeftNumbers;
            ++drawn.pieces;
            drawn.fragments += kLeftTilePixels;
        }
    }
}

std::array<std::vector<float>, 3> TilePicture::Resolve(double scale, ThreadPool& threads) const {
    std::array<std::vector<float>, 3> planes;
    threads.For(3, [&](int p) { planes[static_cast<std::size_t>(p)].resize(window_.pixels()); });
    const int strips = (window_.height + kBlock - 1) / kBlock;
    threads.For(strips, [&](int s) {
        const int end = std::min((s + 1) * kBlock, window_.height);
        for (int y = s * kBlock; y < end; ++y) ResolveRow(y, scale * unit_, planes);
    });
    return planes;
}

// Row y of the window.
void TilePicture::ResolveRow(int row, double factor,
                             std::array<std::vector<float>, 3>& planes) const {
    constexpr float kMost = std::numeric_limits<float>::max();
    thread_local std::array<std::vector<float>, 3> lines;
    const int y = row + window_.y;
    const bool inked = inked_[static_cast<std::size_t>((y - padded_.y) / kBlock)] != 0;
    std::array<float*, 3> line{};
    for (std::size_t c = 0; c < 3; ++c) {
        const auto width = static_cast<std::size_t>(padded_.width);
        const float* const from =
            pixels_[c].get() + static_cast<std::size_t>(y - padded_.y) * width;
        if (inked) {
            lines[c].assign(from, from + width);
        } else {
            lines[c].assign(width, 0.0F);
        }
        line[c] = lines[c].data();
    }
    for (int l = 0; l < kTileLevels; ++l) {
        const Plane& plane = planes_[static_cast<std::size_t>(l)];
        if (!plane.corners) continue;
        const int size = TileSize(l);
        const int tile = FloorDiv(y, size);
        const auto tile_row = static_cast<std::size_t>(tile - plane.y0);
        ExpandTiles(
            plane.corners.get() + tile_row * static_cast<std::size_t>(plane.width) * kCornerNumbers,
            &plane.lit[tile_row * static_cast<std::size_t>(plane.words())], plane.words(), size,
            y - tile * size, line.data());
    }
    // Floats will do unless the factor itself is beyond their range.
    const bool tame = factor > 1e-30 && factor < 1e30;
    const auto tame_factor = static_cast<float>(tame ? factor : 1.0);
    const auto width = static_cast<std::size_t>(window_.width);
    for (std::size_t p = 0; p < planes.size(); ++p) {
        const float* const from = line[p] + (window_.x - padded_.x);
        float* const to = planes[p].data() + static_cast<std::size_t>(row) * width;
        if (tame) {
            for (std::size_t x = 0; x < width; ++x)
                to[x] = std::max(-kMost, std::min(kMost, from[x] * tame_factor));
            continue;
        }
        for (std::size_t x = 0; x < width; ++x) {
            const double value = static_cast<double>(from[x]) * factor;
            to[x] = static_cast<float>(
                std::clamp(value, -static_cast<double>(kMost), static_cast<double>(kMost)));
        }
    }
}

}  // namespace flare
