// SPDX-License-Identifier: Apache-2.0
#include "core/image/tile_light.h"

#include <algorithm>
#include <cmath>

namespace flare {

TileLight::TileLight(const GhostLight& ghost) : ghost_(ghost) {
    const std::size_t count = ghost_.bands.front().light.size();
    double most = 0.0;
    for (const GhostLight::Band& band : ghost_.bands) {
        for (const double light : band.light) most = std::max(most, std::abs(light));
    }
    if (most > 0.0 && std::isfinite(most)) scale_ = std::exp2(std::floor(std::log2(most)));
    std::vector<double> sum(count);
    for (std::size_t k = 0; k <= kTracedInTiles; ++k) {
        std::fill(sum.begin(), sum.end(), 0.0);
        for (const GhostLight::Band& band : ghost_.bands) {
            const double w = k < kTracedInTiles ? band.node_weights[k] : 1.0;
            const double* const from = band.light.data();
            for (std::size_t n = 0; n < count; ++n) sum[n] += w * from[n];
        }
        light_[k].resize(count);
        for (std::size_t n = 0; n < count; ++n) light_[k][n] = static_cast<float>(sum[n] / scale_);
    }
}

std::array<float, kTileLights> TileLight::Point(Of what, std::size_t k, std::size_t at,
                                                float area) const {
    const float* const first = &light_[what == Of::kAll ? kTracedInTiles : k][at];
    std::array<float, kTileLights> out = {area * first[0], area * first[1], area * first[2]};
    if (what == Of::kBoth) {
        for (std::size_t c = 0; c < 3; ++c) out[3 + c] = area * light_[kTracedInTiles][at + c];
    }
    return out;
}

LightCorners TileLight::Corners(Of what, std::size_t k, const FittedCell& cell) const {
    const GhostLight::Cell& from = From(cell);
    const MeshGrid& grid = ghost_.surface->mesh().grids[static_cast<std::size_t>(from.place.grid)];
    const auto area = static_cast<float>(grid.du * grid.dv);
    const auto m = static_cast<std::size_t>(from.light_cuts);
    const std::size_t row = 3 * (m + 1);
    const std::size_t at = from.light_at;
    LightCorners corners;
    corners.count = what == Of::kBoth ? 6 : 3;
    corners.at = {Point(what, k, at, area), Point(what, k, at + 3 * m, area),
                  Point(what, k, at + m * row, area), Point(what, k, at + m * row + 3 * m, area)};
    return corners;
}

std::array<float, kTileLights> TileLight::At(Of what, std::size_t k, const FittedCell& cell,
                                             float a, float b) const {
    const GhostLight::Cell& from = From(cell);
    const int m = from.light_cuts;
    const float fa = std::clamp(a, 0.0F, 1.0F) * static_cast<float>(m);
    const float fb = std::clamp(b, 0.0F, 1.0F) * static_cast<float>(m);
    const int ia = std::min(static_cast<int>(fa), m - 1);
    const int ib = std::min(static_cast<int>(fb), m - 1);
    const float u = fa - static_cast<float>(ia);
    const float v = fb - static_cast<float>(ib);
    const auto row = static_cast<std::size_t>(m + 1) * 3;
    const std::size_t at =
        from.light_at + static_cast<std::size_t>(ib) * row + static_cast<std::size_t>(ia) * 3;
    const MeshGrid& grid = ghost_.surface->mesh().grids[static_cast<std::size_t>(from.place.grid)];
    const auto area = static_cast<float>(grid.du * grid.dv);
    const std::array<float, kTileLights> p00 = Point(what, k, at, area);
    const std::array<float, kTileLights> p10 = Point(what, k, at + 3, area);
    const std::array<float, kTileLights> p01 = Point(what, k, at + row, area);
    const std::array<float, kTileLights> p11 = Point(what, k, at + row + 3, area);
    std::array<float, kTileLights> out{};
    for (std::size_t c = 0; c < kTileLights; ++c) {
        out[c] = (1.0F - v) * ((1.0F - u) * p00[c] + u * p10[c]) +
                 v * ((1.0F - u) * p01[c] + u * p11[c]);
    }
    return out;
}

TileColour TileLight::OfBand(std::size_t band, const FittedCell& cell, float a, float b) const {
    const GhostLight::Cell& from = ghost_.cells[static_cast<std::size_t>(cell.cell)];
    const int m = from.light_cuts;
    const int i = std::clamp(static_cast<int>(std::lround(a * static_cast<float>(m))), 0, m);
    const int j = std::clamp(static_cast<int>(std::lround(b * static_cast<float>(m))), 0, m);
    const double* const at =
        &ghost_.bands[band].light[from.light_at + static_cast<std::size_t>(j * (m + 1) + i) * 3];
    return {static_cast<float>(at[0] / scale_), static_cast<float>(at[1] / scale_),
            static_cast<float>(at[2] / scale_)};
}

}  // namespace flare
