// SPDX-License-Identifier: Apache-2.0
#include "core/render/error_estimate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace flare {
namespace {

// Shares of the light, fitted: docs/accuracy.md.
constexpr double kDispersion = 0.07;
constexpr double kPosition = 0.2;
constexpr double kTileEdge = 0.4;
constexpr double kDensity = 0.12;
constexpr double kMeshEdge = 0.6;
constexpr double kMeshDensity = 0.6;
constexpr double kColour = 0.1;

constexpr double kEdge = 3.5449077018110318;  // 2 sqrt(pi): perimeter over root of area of a disc

// The largest relative error of a ghost's colour: 21 bands are right to 0.12 % for coatings of one
// layer, 4 % for three and 35 % for more (docs/physics/coatings.md), and it falls with the fourth
// power.
double ColourError(const Lens& lens, const QualitySettings& settings) {
    const std::size_t layers = MostCoatingLayers(lens);
    const double at_21 = layers <= 1 ? 0.0012 : (layers <= 3 ? 0.04 : 0.35);
    return std::min(1.0, at_21 * std::pow(21.0 / ColourBandsFor(lens, settings), 4.0));
}

// Sensor places of five vertices in a row, in pixels, if all live.
using Row = std::array<Vec2d, 5>;

std::optional<Row> RowOf(const GhostSurface& surface, const PictureMap& map, int i, int j, int di,
                         int dj) {
    const GhostMesh& mesh = surface.mesh();
    const MeshGrid& grid = mesh.grids.front();
    if (i - 2 * di < 0 || j - 2 * dj < 0 || i + 2 * di >= grid.nu || j + 2 * dj >= grid.nv) {
        return std::nullopt;
    }
    const MeshNode& node = grid.nodes[grid.nodes.size() / 2];
    const auto fields = static_cast<std::size_t>(mesh.stored_count());
    Row row;
    for (int k = -2; k <= 2; ++k) {
        const std::size_t vertex = grid.Vertex(i + k * di, j + k * dj);
        if (grid.alive[vertex] == 0) return std::nullopt;
        const Vec2d place =
            mesh.SensorPlace(&node.fields[vertex * fields], surface.sensor_gap_mm());
        row[static_cast<std::size_t>(k + 2)] = map.Pixel(place.x, place.y);
    }
    return row;
}

}  // namespace

// The middle of five values against the cubic through the others is 7 times as far off as a cubic
// is between neighbours; an error of that shape bends the density by twice its height a cell.
MeshMiss MeshMissOf(const GhostSurface& surface, const std::vector<GhostLight::Cell>& cells,
                    const PictureMap& map) {
    constexpr double kShare = 0.14;
    MeshMiss sum;
    int rows = 0;
    for (const GhostLight::Cell& cell : cells) {
        if (cell.place.grid != 0) continue;
        for (const int direction : {0, 1}) {
            const std::optional<Row> row =
                RowOf(surface, map, cell.place.i, cell.place.j, 1 - direction, direction);
            if (!row) continue;
            const Row& p = *row;
            const double miss =
                kShare * (p[2] - ((p[1] + p[3]) * 4.0 - p[0] - p[4]) / 6.0).length();
            const double step = std::max(1.0, 0.5 * (p[3] - p[1]).length());
            sum.position_px += miss;
            sum.density += std::min(1.0, 2.0 * miss / step);
            ++rows;
        }
    }
    if (rows == 0) return {};
    return {sum.position_px / rows, 2.0 * sum.density / rows};
}

ErrorEstimate::ErrorEstimate(const Lens& lens, const QualitySettings& settings, bool spectral)
    : settings_(settings),
      colour_(spectral ? 0.0 : ColourError(lens, settings)),
      tile_edge_px_(settings.tiles && !spectral ? settings.tiles->edge_px : 0.0) {}

void ErrorEstimate::AddDrawn(const GhostSample& sample, double weight, double dispersion_step_px,
                             const MeshMiss& miss) {
    const double light = weight * sample.frame_light;
    if (light <= 0.0) return;
    const double edge = kEdge / std::sqrt(std::max(1.0, sample.area_px2));
    drawn_light_ += light;
    edge_light_ += light * std::min(1.0, edge);
    mesh_light_ +=
        light * std::min(1.0, kMeshEdge * miss.position_px * edge + kMeshDensity * miss.density);
    // Steps below a pixel are smoothed by the pixel itself.
    const double step = dispersion_step_px * dispersion_step_px / (1.0 + dispersion_step_px);
    dispersion_light_ += light * std::min(1.0, kDispersion * step * edge);
}

void ErrorEstimate::AddSource(const GhostSample& sample, double weight, double error) {
    source_light_ += weight * sample.frame_light * error;
}

void ErrorEstimate::AddLight(double frame_light, double lost_light) {
    frame_light_ += frame_light;
    lost_light_ += lost_light;
}

EstimatedError ErrorEstimate::Value() const {
    EstimatedError error;
    if (frame_light_ > 0.0) error.culling = lost_light_ / frame_light_;
    if (drawn_light_ > 0.0) {
        const double edge = edge_light_ / drawn_light_;
        error.dispersion = dispersion_light_ / drawn_light_;
        error.colour = kColour * colour_;
        error.mesh = mesh_light_ / drawn_light_;
        error.source = source_light_ / drawn_light_;
        error.pieces = (kPosition * settings_.walk.position_px + kTileEdge * tile_edge_px_) * edge +
                       kDensity * settings_.walk.density_step;
    }
    error.rel_l1 =
        error.culling + error.dispersion + error.colour + error.mesh + error.pieces + error.source;
    return error;
}

}  // namespace flare
