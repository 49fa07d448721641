// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/grid_roughness.h"

#include <algorithm>
#include <cmath>

namespace flare {
namespace {

// Squared cosines below this are near total reflection.
constexpr double kNearCritical = 0.1;

// A cell within this many times the tolerances does with a patch half as fine: that is better than
// the cell by 64 times or more.
constexpr double kVeryRough = 8.0;

// Predicts the middle one of five values from two neighbours on each side. The miss is h^4
// f/6; a cubic through the values is wrong by at most 3/128 h^4 f between them, 0.14
// times that.
double Miss(const std::array<double, 5>& f) {
    constexpr double kShare = 0.14;
    return kShare * std::abs(f[2] - (4.0 * (f[1] + f[3]) - f[0] - f[4]) / 6.0);
}

}  // namespace

GridRoughness::GridRoughness(const GridTracer& tracer, const MeshSpec& spec, const Lens& lens,
                             const RawGrid& main)
    : tracer_(tracer),
      spec_(spec),
      main_(main),
      sensor_gap_mm_(lens.nominal_sensor_gap_mm()),
      stop_semi_diameter_mm_(
          lens.surfaces()[static_cast<std::size_t>(lens.stop_index())].semi_diameter_mm),
      judged_(2 * main.grid.Vertex(0, main.grid.nv), Roughness::kUnknown) {}

Roughness GridRoughness::Worst(int i, int j) {
    Roughness worst = Roughness::kSmooth;
    for (const int k : {0, 1}) {
        for (const int l : {0, 1}) {
            for (const std::size_t direction : {0U, 1U})
                worst = std::max(worst, At(i + k, j + l, direction));
        }
    }
    return worst;
}

// A vertex is a corner of four cells.
Roughness GridRoughness::At(int i, int j, std::size_t direction) {
    Roughness& judged = judged_[2 * main_.grid.Vertex(i, j) + direction];
    if (judged == Roughness::kUnknown) {
        const int di = direction == 0 ? 1 : 0;
        judged = !Rough(i, j, di, 1 - di, 1.0)          ? Roughness::kSmooth
                 : !Rough(i, j, di, 1 - di, kVeryRough) ? Roughness::kRough
                                                        : Roughness::kVery;
    }
    return judged;
}

// At a vertex, along one direction, by this share of the tolerances.
bool GridRoughness::Rough(int i, int j, int di, int dj, double share) const {
    const int n = main_.grid.nu - 1;
    if (i - 2 * di < 0 || j - 2 * dj < 0 || i + 2 * di > n || j + 2 * dj > n) return false;
    Stencil at;
    for (int k = -2; k <= 2; ++k) {
        const auto m = static_cast<std::size_t>(k + 2);
        at.ray[m] = main_.Ray(i + k * di, j + k * dj);
        at.mirrored[m] = j + k * dj < main_.mirror_row;
    }
    // Next to dead rays slopes are of lower order; only close to them does that show.
    const std::vector<VertexState>& state = main_.rays->state;
    if (state[at.ray[1]] != VertexState::kAlive || state[at.ray[3]] != VertexState::kAlive)
        return true;
    if (state[at.ray[0]] != VertexState::kAlive || state[at.ray[4]] != VertexState::kAlive)
        return false;
    const TraceColumns& node = main_.rays->nodes[main_.rays->nodes.size() / 2];
    return RoughPlace(node, at, share) || RoughStop(node, at, share) || RoughMasks(node, at, share);
}

// Column x or y, 0 or 1, over the stencil.
std::array<double, 5> GridRoughness::Values(const float* column, std::size_t axis,
                                            const Stencil& at) const {
    std::array<double, 5> out{};
    for (std::size_t k = 0; k < 5; ++k) {
        const auto value = static_cast<double>(column[at.ray[k]]);
        out[k] = at.mirrored[k] && axis == tracer_.mirrored_axis() ? -value : value;
    }
    return out;
}

// On the sensor where it stands at infinity, so that the mesh is the same for every focus.
bool GridRoughness::RoughPlace(const TraceColumns& node, const Stencil& at, double share) const {
    std::array<std::array<double, 5>, 2> place{};
    for (const std::size_t axis : {0U, 1U}) {
        place[axis] = Values(axis == 0 ? node.exit_x.data() : node.exit_y.data(), axis, at);
        const std::array<double, 5> slope =
            Values(axis == 0 ? node.slope_x.data() : node.slope_y.data(), axis, at);
        for (std::size_t k = 0; k < 5; ++k) place[axis][k] += sensor_gap_mm_ * slope[k];
    }
    const double miss = std::max(Miss(place[0]), Miss(place[1]));
    const double tolerance = share * spec_.position_tolerance_mm;
    if (miss <= tolerance) return false;
    // The nearest that the stretch between the neighbours comes to the axis.
    std::array<double, 2> nearest{};
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const std::array<double, 5>& p = place[axis];
        const auto [lo, hi] = std::minmax({p[1], p[2], p[3]});
        nearest[axis] = std::max({lo, -hi, 0.0});
    }
    return miss > tolerance * FarScale(std::hypot(nearest[0], nearest[1]));
}

bool GridRoughness::RoughStop(const TraceColumns& node, const Stencil& at, double share) const {
    const double tolerance = share * spec_.mask_tolerance * stop_semi_diameter_mm_;
    for (std::size_t c = 0; c < tracer_.crossings(); ++c) {
        if (Miss(Values(&node.stop_x[c * node.stride], 0, at)) > tolerance ||
            Miss(Values(&node.stop_y[c * node.stride], 1, at)) > tolerance) {
            return true;
        }
    }
    return false;
}

bool GridRoughness::RoughMasks(const TraceColumns& node, const Stencil& at, double share) const {
    for (std::size_t s = 0; s < tracer_.steps(); ++s) {
        const float* const ratio2 = &node.rim_ratio2[s * node.stride];
        // Only near the rim does its field matter.
        if (ratio2[at.ray[2]] > 1.0F / 3.0F && ratio2[at.ray[2]] < 3.0F) {
            std::array<double, 5> rim{};
            for (std::size_t k = 0; k < 5; ++k) {
                rim[k] = RimField(static_cast<double>(ratio2[at.ray[k]]));
            }
            if (Miss(rim) > share * spec_.mask_tolerance) return true;
        }
        // Transmittances follow the cosines steeply near the critical angle, and are interpolated
        // linearly.
        const float* const c2 = &node.rare_cos2[s * node.stride];
        const auto middle = static_cast<double>(c2[at.ray[2]]);
        if (std::abs(middle) < kNearCritical &&
            std::abs(static_cast<double>(c2[at.ray[1]]) - 2.0 * middle +
                     static_cast<double>(c2[at.ray[3]])) > share * spec_.cosine_tolerance * 8.0) {
            return true;
        }
    }
    return false;
}

}  // namespace flare
