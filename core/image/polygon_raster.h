// SPDX-License-Identifier: Apache-2.0
//
// Spreads amounts of light over the pixels that polygons cover, in proportion to the exact area of
// the polygon within each pixel. The sum over all pixels is the amount, to rounding, whatever the
// polygon's shape; what falls outside the target is lost, as it should be.
//
// Polygons are collected and put on the picture together: polygons that overlap, like the images of
// one piece of a ghost at many wavelengths, then cost little more than their edges.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/base/vec.h"

namespace flare {

// Doubles a pixel in a colour layer: red, green, blue and one that stays 0, so that a pixel is one
// vector.
inline constexpr int kColourStride = 4;

// A window of layers that share one size. Rows y0 ... y0 + rows - 1 of the picture. A spectral
// layer has one double a pixel, a colour layer kColourStride.
struct RasterTarget {
    std::vector<double*> layers;  // pixel (x0, y0) of each
    int x0 = 0, y0 = 0, width = 0, rows = 0;
};

class PolygonRaster {
  public:
    // Layers of one channel, or of three (colour).
    PolygonRaster(const RasterTarget& target, int channels);

    // `points` (pixels) go round a simple polygon in either direction; one of no area is spread
    // along its longest diagonal.
    void Add(std::span<const Vec2d> points, std::span<const double> amounts, int layer);

    // Puts everything collected on the picture.
    void Flush();

    // Pixels that polygons covered or touched, counted once a polygon.
    std::uint64_t fragments() const { return fragments_; }

  private:
    struct Box {
        int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // pixels x0 ... x1 - 1
    };
    struct Item {
        std::size_t begin = 0, end = 0;  // of points_
        Box box;
        double density[kColourStride] = {0.0, 0.0, 0.0,
                                         0.0};  // amount over signed area, or amount for a pixel
        bool one_pixel = false;
        int layer = 0;
    };

    void Collect(std::span<const Vec2d> points, const double* amounts, int layer);
    void CollectPixel(int x, int y, const double* amounts, double share, int layer);
    void CollectSliver(std::span<const Vec2d> points, const double* amounts, int layer);
    void CollectClipped(std::span<const Vec2d> points, const double* amounts, int layer);

    void Spread(std::size_t first, std::size_t last, const Box& box);
    template <int kChannels>
    void SpreadItems(std::size_t first, std::size_t last, const Box& box);
    template <int kChannels>
    void AddEdge(const Vec2d& from, const Vec2d& to, const double* density, const Box& box);
    void Touch(int row, int first_column, int last_column) {
        auto& [from, to] = touched_[static_cast<std::size_t>(row)];
        from = first_column < from ? first_column : from;
        to = last_column + 1 > to ? last_column + 1 : to;
    }
    template <int kChannels>
    void AddRows(const Box& box, int layer);

    RasterTarget target_;
    std::size_t channels_;
    std::vector<Item> items_;
    std::vector<Vec2d> points_;
    std::vector<double> cover_;                 // rows x (columns + 1) x channels of a group's box
    std::vector<std::pair<int, int>> touched_;  // columns of each row that hold anything
    double group_density_ = 0.0;
    std::uint64_t fragments_ = 0;
};

}  // namespace flare
