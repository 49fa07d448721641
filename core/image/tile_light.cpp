// SPDX-License-Identifier: Apache-2.0
#include "core/image/tile_light.h"

#include <algorithm>
#include <cmath>

namespace flare {

TileLight::TileLight(const GhostLight& ghost) : ghost_(ghost) {
    const std::size_t numbers = ghost_.NumbersAPoint();
    for (std::size_t k = 0; k < kTracedInTiles; ++k) {
        for (std::size_t n = 0; n < numbers; ++n)
            leans_[k].push_back(static_cast<float>(ghost_.bands[n / 3].node_weights[k]));
    }
    const std::size_t points = ghost_.light.size() / numbers;
    sums_.resize(points * kSums);
    for (std::size_t p = 0; p < points; ++p) {
        const float* const from = &ghost_.light[p * numbers];
        std::array<float, kSums> sum{};
        for (std::size_t n = 0; n < numbers; n += 3) {
            for (std::size_t c = 0; c < 3; ++c) {
                for (std::size_t k = 0; k < kTracedInTiles; ++k)
                    sum[3 * k + c] += leans_[k][n] * from[n + c];
                sum[3 * kTracedInTiles + c] += from[n + c];
            }
        }
        std::copy(sum.begin(), sum.end(), &sums_[p * kSums]);
    }
}

float TileLight::AreaOf(const GhostLight::Cell& cell) const {
    const MeshGrid& grid = ghost_.surface->mesh().grids[static_cast<std::size_t>(cell.place.grid)];
    return static_cast<float>(grid.du * grid.dv);
}

std::array<float, kTileLights> TileLight::Point(Of what, std::size_t k, std::size_t point,
                                                float area) const {
    const float* const sums = &sums_[point * kSums];
    const float* const first = sums + 3 * (what == Of::kAll ? kTracedInTiles : k);
    std::array<float, kTileLights> out = {area * first[0], area * first[1], area * first[2]};
    if (what == Of::kBoth) {
        for (std::size_t c = 0; c < 3; ++c) out[3 + c] = area * sums[3 * kTracedInTiles + c];
    }
    return out;
}

LightCorners TileLight::Corners(Of what, std::size_t k, const FittedCell& cell) const {
    const GhostLight::Cell& from = From(cell);
    const float area = AreaOf(from);
    const auto m = static_cast<std::size_t>(from.light_cuts);
    const std::size_t top = from.light_at + m * (m + 1);
    LightCorners corners;
    corners.count = what == Of::kBoth ? 6 : 3;
    corners.at = {Point(what, k, from.light_at, area), Point(what, k, from.light_at + m, area),
                  Point(what, k, top, area), Point(what, k, top + m, area)};
    return corners;
}

TileLight::InLattice TileLight::Find(const GhostLight::Cell& cell, float a, float b) const {
    const int m = cell.light_cuts;
    const float fa = std::clamp(a, 0.0F, 1.0F) * static_cast<float>(m);
    const float fb = std::clamp(b, 0.0F, 1.0F) * static_cast<float>(m);
    const int ia = std::min(static_cast<int>(fa), m - 1);
    const int ib = std::min(static_cast<int>(fb), m - 1);
    const float u = fa - static_cast<float>(ia);
    const float v = fb - static_cast<float>(ib);
    InLattice found;
    found.row = static_cast<std::size_t>(m + 1);
    found.point =
        cell.light_at + static_cast<std::size_t>(ib) * found.row + static_cast<std::size_t>(ia);
    found.shares = {(1.0F - u) * (1.0F - v), u * (1.0F - v), (1.0F - u) * v, u * v};
    return found;
}

std::array<float, kTileLights> TileLight::At(Of what, std::size_t k, const FittedCell& cell,
                                             float a, float b) const {
    const GhostLight::Cell& from = From(cell);
    const InLattice in = Find(from, a, b);
    const float area = AreaOf(from);
    std::array<float, kTileLights> out{};
    for (std::size_t n = 0; n < 4; ++n) {
        const std::array<float, kTileLights> point =
            Point(what, k, in.point + n / 2 * in.row + n % 2, area);
        for (std::size_t c = 0; c < kTileLights; ++c) out[c] += in.shares[n] * point[c];
    }
    return out;
}

void TileLight::AddBands(std::size_t k, const FittedCell& cell, const std::array<float, 2>& at,
                         float factor, float* rgb) const {
    const GhostLight::Cell& from = From(cell);
    const InLattice in = Find(from, at[0], at[1]);
    const float scale = factor * AreaOf(from);
    const std::size_t numbers = ghost_.NumbersAPoint();
    const float* const first = &ghost_.light[in.point * numbers];
    const float* const above = first + in.row * numbers;
    const float* const lean = leans_[k].data();
    const std::array<float, 4> s = {scale * in.shares[0], scale * in.shares[1],
                                    scale * in.shares[2], scale * in.shares[3]};
    for (std::size_t n = 0; n < numbers; ++n) {
        rgb[n] += lean[n] * (s[0] * first[n] + s[1] * first[n + numbers] + s[2] * above[n] +
                             s[3] * above[n + numbers]);
    }
}

}  // namespace flare
