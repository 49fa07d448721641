// SPDX-License-Identifier: Apache-2.0
#include "core/image/tile_kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace flare {
namespace {

float At(const CellPolynomial& p, float a, float b) {
    float sum = 0.0F;
    for (std::size_t q = 0; q < 4; ++q) {
        for (std::size_t r = 0; r < 4; ++r) {
            sum += p[4 * q + r] * std::pow(a, static_cast<float>(r)) *
                   std::pow(b, static_cast<float>(q));
        }
    }
    return sum;
}

// A cell of about 40 x 30 pixels, bent.
CellFit BentCell() {
    CellFit cell;
    cell.x = {100.0F, 40.0F, 3.0F, -1.0F, 5.0F, 2.0F, 0.5F, 0.0F,
              -2.0F,  0.5F,  0.0F, 0.0F,  0.3F, 0.0F, 0.0F, 0.0F};
    cell.y = {50.0F, -4.0F, 1.0F, 0.2F, -30.0F, 1.5F, 0.0F, 0.0F,
              -2.0F, 0.0F,  0.4F, 0.0F, 0.5F,   0.0F, 0.0F, 0.1F};
    cell.field_count = 1;
    static const CellPolynomial kField = {1.0F, 2.0F, 0.0F, 0.0F, 3.0F};
    cell.fields = &kField;
    return cell;
}

TEST(SolveNodes, FindsThePointsThatLandOnTheNodes) {
    const CellFit cell = BentCell();
    NodeBlock block;
    std::vector<float> a, b;
    for (int n = 0; n < 50; ++n) {
        a.push_back(-0.2F + 0.028F * static_cast<float>(n));
        b.push_back(0.5F + 0.6F * std::sin(static_cast<float>(n)));
        block.px[n] = At(cell.x, a.back(), b.back());
        block.py[n] = At(cell.y, a.back(), b.back());
    }
    block.count = 50;
    SolveNodes(cell, {}, cell.field_count, nullptr, block);
    int found = 0;
    for (std::size_t n = 0; n < 50; ++n) {
        const bool within = a[n] >= 0.0F && a[n] < 1.0F && b[n] >= 0.0F && b[n] < 1.0F;
        EXPECT_EQ((block.found >> n & 1U) != 0, within) << a[n] << " " << b[n];
        if (!within) continue;
        ++found;
        EXPECT_NEAR(block.a[n], a[n], 1e-3F);
        EXPECT_NEAR(block.b[n], b[n], 1e-3F);
        EXPECT_NEAR(block.fields[0][n], 1.0F + 2.0F * a[n] + 3.0F * b[n], 5e-3F);
        const float h = 1e-2F;
        const float xa = (At(cell.x, a[n] + h, b[n]) - At(cell.x, a[n] - h, b[n])) / (2.0F * h);
        const float xb = (At(cell.x, a[n], b[n] + h) - At(cell.x, a[n], b[n] - h)) / (2.0F * h);
        const float ya = (At(cell.y, a[n] + h, b[n]) - At(cell.y, a[n] - h, b[n])) / (2.0F * h);
        const float yb = (At(cell.y, a[n], b[n] + h) - At(cell.y, a[n], b[n] - h)) / (2.0F * h);
        EXPECT_NEAR(block.det[n], xa * yb - xb * ya, 1e-2F * std::abs(block.det[n]));
    }
    EXPECT_GT(found, 10);
    EXPECT_EQ(block.found >> 50, 0U) << "padding is not found";
}

TEST(SolveNodes, LeavesOutWhatLandsInAnotherPart) {
    const CellFit cell = BentCell();
    NodeBlock block;
    block.px[0] = At(cell.x, 0.3F, 0.4F);
    block.py[0] = At(cell.y, 0.3F, 0.4F);
    block.count = 1;
    SolveNodes(cell, {0.0F, 0.5F, 0.0F, 0.5F}, 0, nullptr, block);
    EXPECT_EQ(block.found, 1U);
    SolveNodes(cell, {0.5F, 1.0F, 0.0F, 0.5F}, 0, nullptr, block);
    EXPECT_EQ(block.found, 0U);
}

EdgeShade EvenTile(int size) {
    EdgeShade tile;
    tile.size = size;
    for (auto& channel : tile.light) {
        for (float& corner : channel) corner = 2.0F;
    }
    return tile;
}

// Pixels across the edge, as GhostTiles hands them out.
StraightEdge Line(float nx, float ny, float offset, int size) {
    StraightEdge edge{};
    const float width = std::abs(nx) + std::abs(ny);
    for (int n = 0; n < 4; ++n) {
        const auto x = static_cast<float>(n % 2 * size);
        const auto y = static_cast<float>(n / 2 * size);
        edge.corners[n] = (nx * x + ny * y - offset) / width;
    }
    return edge;
}

// An edge tile shaded onto darkness.
struct TilePixels {
    explicit TilePixels(const EdgeShade& tile) {
        float* const planes[3] = {rgb[0], rgb[1], rgb[2]};
        ShadeEdge(tile, planes, kLargestEdgeTile);
    }
    float rgb[3][kLargestEdgeTile * kLargestEdgeTile] = {};
};

double SumOf(const TilePixels& pixels, int channel, int size) {
    double sum = 0.0;
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) sum += pixels.rgb[channel][y * kLargestEdgeTile + x];
    }
    return sum;
}

TEST(ShadeEdge, CoversTheAreaOnTheInsideOfALine) {
    for (const int size : {16, 8, 4}) {
        EdgeShade tile = EvenTile(size);
        const StraightEdge edge = Line(1.0F, 0.0F, 2.7F, size);
        tile.straight = 1;
        tile.straight_edges = &edge;
        const TilePixels pixels(tile);
        EXPECT_NEAR(SumOf(pixels, 1, size), 2.0 * 2.7 * size, 1e-3);
        EXPECT_FLOAT_EQ(pixels.rgb[0][1], 2.0F);
        EXPECT_NEAR(pixels.rgb[0][2], 1.4F, 1e-5);
        EXPECT_FLOAT_EQ(pixels.rgb[0][3], 0.0F);
        // A slanting one: the triangle below x + y = 5 (a pixel's ramp is exact in the mean).
        const StraightEdge slant = Line(1.0F, 1.0F, 3.0F, size);
        tile.straight_edges = &slant;
        EXPECT_NEAR(SumOf(TilePixels(tile), 1, size), 2.0 * 0.5 * 9.0, 0.6);
    }
}

TEST(ShadeEdge, CoversTheAreaWithinAnArc) {
    constexpr int kSize = 16;
    EdgeShade tile = EvenTile(kSize);
    // A circle of radius 9 about the tile's corner, in mm of half a pixel.
    ArcEdge arc{};
    for (int n = 0; n < 4; ++n) {
        arc.x[n] = 0.5F * static_cast<float>(n % 2 * kSize);
        arc.y[n] = 0.5F * static_cast<float>(n / 2 * kSize);
    }
    arc.radius2 = 4.5F * 4.5F;
    arc.per_x_x = 0.5F;
    arc.per_y_y = 0.5F;
    tile.arcs = 1;
    tile.arc_edges = &arc;
    const TilePixels pixels(tile);
    EXPECT_NEAR(SumOf(pixels, 2, kSize), 2.0 * 0.25 * 3.14159265 * 81.0, 0.6);
}

TEST(ShadeEdge, SpreadsABandsEdgeOverItsNeighbours) {
    constexpr int kSize = 16;
    EdgeShade tile = EvenTile(kSize);
    for (auto& channel : tile.light) {
        for (float& corner : channel) corner = 1.0F;
    }
    // Edges at x = 4, 8 and 12 for the traced wavelengths; two bands, at the first and the last.
    const StraightEdge edges[] = {Line(1.0F, 0.0F, 4.0F, kSize), Line(1.0F, 0.0F, 8.0F, kSize),
                                  Line(1.0F, 0.0F, 12.0F, kSize)};
    const float weights[] = {1.0F, 0.0F, 0.0F, 0.0F, 0.0F, 1.0F};
    const float rgb[] = {3.0F, 0.0F, 0.0F, 0.0F, 0.0F, 5.0F};
    const float sharpness[] = {1.0F, 0.25F};
    tile.straight = 1;
    tile.straight_edges = edges;
    tile.bands = 2;
    tile.band_weights = weights;
    tile.band_rgb = rgb;
    tile.band_sharpness = sharpness;
    const TilePixels pixels(tile);
    EXPECT_NEAR(SumOf(pixels, 0, kSize), 3.0 * 4.0 * kSize, 1e-2);
    EXPECT_NEAR(SumOf(pixels, 2, kSize), 5.0 * 12.0 * kSize, 1e-2);
    EXPECT_EQ(SumOf(pixels, 1, kSize), 0.0);
    EXPECT_FLOAT_EQ(pixels.rgb[2][9], 5.0F);
    EXPECT_NEAR(pixels.rgb[2][12], 5.0F * 0.375F, 1e-4) << "half a pixel beyond, four wide";
}

TEST(ShadeEdge, AddsToWhatIsThereAndNothingBeside) {
    EdgeShade tile = EvenTile(4);
    const StraightEdge edge = Line(1.0F, 0.0F, 2.0F, 4);
    tile.straight = 1;
    tile.straight_edges = &edge;
    constexpr std::ptrdiff_t kStride = 24;
    std::vector<float> plane(6 * kStride, 1.0F);
    float* const at = plane.data() + kStride + 5;
    float* const planes[3] = {at, at, at};  // three times 2
    ShadeEdge(tile, planes, kStride);
    for (std::ptrdiff_t n = 0; n < std::ssize(plane); ++n) {
        const std::ptrdiff_t x = n % kStride;
        const std::ptrdiff_t y = n / kStride;
        const bool lit = y >= 1 && y < 5 && x >= 5 && x < 7;
        EXPECT_FLOAT_EQ(plane[static_cast<std::size_t>(n)], lit ? 7.0F : 1.0F) << x << ' ' << y;
    }
}

TEST(ExpandTiles, IsBilinearAtPixelCentres) {
    for (const int size : {16, 8, 4}) {
        // Two tiles: channel c of corner n of tile t.
        std::vector<float> corners;
        for (int t = 0; t < 2; ++t) {
            for (int n = 0; n < 4; ++n) {
                for (int c = 0; c < 3; ++c)
                    corners.push_back(static_cast<float>(1 + t * 7 + n * 3 + c * n));
            }
        }
        const auto width = static_cast<std::size_t>(2 * size);
        std::vector<float> planes[3];
        for (auto& plane : planes) plane.assign(width, 0.5F);
        float* rows[3] = {planes[0].data(), planes[1].data(), planes[2].data()};
        const int row = size / 2 - 1;
        const std::uint64_t lit = 3;
        ExpandTiles(corners.data(), &lit, 1, size, row, rows);
        for (int x = 0; x < 2 * size; ++x) {
            const float u = (static_cast<float>(x % size) + 0.5F) / static_cast<float>(size);
            const float v = (static_cast<float>(row) + 0.5F) / static_cast<float>(size);
            for (int c = 0; c < 3; ++c) {
                const float* const at = &corners[static_cast<std::size_t>(x / size * 12 + c)];
                const float truth =
                    (1 - v) * ((1 - u) * at[0] + u * at[3]) + v * ((1 - u) * at[6] + u * at[9]);
                EXPECT_NEAR(planes[c][static_cast<std::size_t>(x)], 0.5F + truth, 1e-4F);
            }
        }
    }
}

TEST(ExpandTiles, PassesOverWhatIsNotLit) {
    std::vector<float> corners(70 * 12, 1.0F);
    std::fill(corners.begin(), corners.begin() + 12, std::numeric_limits<float>::quiet_NaN());
    std::vector<float> plane(70 * 4, 0.0F);
    float* const rows[3] = {plane.data(), plane.data(), plane.data()};
    const std::uint64_t lit[2] = {2, std::uint64_t{1} << 5};  // tiles 1 and 69
    ExpandTiles(corners.data(), lit, 2, 4, 0, rows);
    for (std::size_t x = 0; x < plane.size(); ++x)
        EXPECT_FLOAT_EQ(plane[x], x / 4 == 1 || x / 4 == 69 ? 3.0F : 0.0F) << x;
}

}  // namespace
}  // namespace flare
