// SPDX-License-Identifier: Apache-2.0
//
// The place at the stop is bilinear over the tile at each traced wavelength, and a band's place
// leans on those as its place on the picture does. A band stands for the wavelengths up to half-way
// to its neighbours: it is smeared by as much as they lie apart.
#include "core/image/tile_pass.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace flare {
namespace {

constexpr int kBlock = 4;  // pixels that are looked at together first

// A place at the stop as a function of a place in the tile, pixels.
struct StopPlane {
    Vec2d at, per_x, per_y, twist;

    Vec2d operator()(double i, double j) const { return at + per_x * i + (per_y + twist * i) * j; }
};

StopPlane PlaneOf(const TileAtStop& tile, int size) {
    std::array<Vec2d, 4> p;
    for (std::size_t n = 0; n < 4; ++n)
        p[n] = {static_cast<double>(tile.x[n]), static_cast<double>(tile.y[n])};
    const double step = 1.0 / size;
    return {p[0], (p[1] - p[0]) * step, (p[2] - p[0]) * step,
            (p[3] - p[2] - p[1] + p[0]) * (step * step)};
}

StopPlane Mixed(const StopPlane* traced, const float* weights) {
    StopPlane out{{0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}};
    for (int k = 0; k < kTracedInTiles; ++k) {
        const auto w = static_cast<double>(weights[k]);
        out.at += traced[k].at * w;
        out.per_x += traced[k].per_x * w;
        out.per_y += traced[k].per_y * w;
        out.twist += traced[k].twist * w;
    }
    return out;
}

void Multiply(const StopPicture& picture, const StopPlane& plane, Vec2d smear, int size,
              float* pass) {
    // Pixels are about as large all over the tile.
    const double middle = 0.5 * size;
    const StopSampler sampler(picture, plane.per_x + plane.twist * middle,
                              plane.per_y + plane.twist * middle, smear);
    const double room_x = std::abs(smear.x);
    const double room_y = std::abs(smear.y);
    for (int y = 0; y < size; y += kBlock) {
        for (int x = 0; x < size; x += kBlock) {
            Vec2d lo = plane(x - 1.0, y - 1.0);
            Vec2d hi = lo;
            for (int corner = 1; corner < 4; ++corner) {
                const Vec2d p = plane(x - 1.0 + (kBlock + 2.0) * (corner % 2),
                                      y - 1.0 + (kBlock + 2.0) * (corner / 2));
                lo = {std::min(lo.x, p.x), std::min(lo.y, p.y)};
                hi = {std::max(hi.x, p.x), std::max(hi.y, p.y)};
            }
            const StopRange range =
                picture.Over(lo.x - room_x, lo.y - room_y, hi.x + room_x, hi.y + room_y);
            if (range.clear()) continue;
            for (int n = 0; n < kBlock * kBlock; ++n) {
                const int i = x + n % kBlock;
                const int j = y + n / kBlock;
                float& value = pass[j * kLargestEdgeTile + i];
                if (range.dark()) value = 0.0F;
                if (value != 0.0F) value *= static_cast<float>(sampler.At(plane(i + 0.5, j + 0.5)));
            }
        }
    }
}

}  // namespace

void FindTilePass(const GhostTiles& tiles, const EdgeTile& tile, const StopPicture& picture,
                  std::vector<float>& pass) {
    const int size = TileSize(tile.level);
    const std::size_t bands =
        tile.dispersed ? tiles.band_weights.size() / static_cast<std::size_t>(kTracedInTiles) : 1;
    pass.assign(bands * kTilePixels, 1.0F);
    const std::size_t traced = tile.dispersed ? kTracedInTiles : 1;
    for (std::size_t c = 0; c < static_cast<std::size_t>(tile.pictured); ++c) {
        std::array<StopPlane, kTracedInTiles> planes{};
        for (std::size_t k = 0; k < traced; ++k)
            planes[k] = PlaneOf(tiles.pictured[tile.pictured_at + c * traced + k], size);
        if (!tile.dispersed) {
            Multiply(picture, planes[0], {0.0, 0.0}, size, pass.data());
            continue;
        }
        const auto weights = [&](std::size_t band) {
            return tiles.band_weights.data() + band * kTracedInTiles;
        };
        for (std::size_t b = 0; b < bands; ++b) {
            const std::size_t lo = b > 0 ? b - 1 : 0;
            const std::size_t hi = std::min(b + 1, bands - 1);
            const double middle = 0.5 * size;
            const Vec2d smear = (Mixed(planes.data(), weights(hi))(middle, middle) -
                                 Mixed(planes.data(), weights(lo))(middle, middle)) /
                                static_cast<double>(hi - lo);
            Multiply(picture, Mixed(planes.data(), weights(b)), smear, size,
                     pass.data() + b * kTilePixels);
        }
    }
}

}  // namespace flare
