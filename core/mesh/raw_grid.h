// SPDX-License-Identifier: Apache-2.0
//
// A grid of traced rays before anybody has decided which of it a ghost mesh keeps: every
// wavelength, every interaction's rim ratio, and how each ray ended. Main grid and patches are
// traced alike, in floats and many at once (trace_columns.h) or, where the spec asks for it, one by
// one by the reference. Used by the mesh builder.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/mesh/ghost_mesh.h"
#include "core/mesh/mesh_builder.h"
#include "core/mesh/pass_region.h"
#include "core/tracing/light_bundle.h"
#include "core/tracing/trace_columns.h"

namespace flare {

// How a vertex counts for the masks at all wavelengths.
enum class VertexState : std::uint8_t { kAlive, kDead, kDeadOutside };

// Rays traced in one go, shared by the grids they belong to.
struct TracedRays {
    std::vector<TraceColumns> nodes;  // one a wavelength
    std::vector<VertexState> state;   // [ray]
    // [ray] over wavelengths: largest rim ratio^2 met (rims, stop)
    std::vector<float> smallest_rim;
};

using CellCorners = std::array<std::size_t, 4>;

// Cells whose best corner has a larger (distance / semi-diameter)^2 than this at some rim do not
// pass.
inline constexpr double kNearlyPasses = 1.05;

struct RawGrid {
    MeshGrid grid;
    std::shared_ptr<const TracedRays> rays;
    std::size_t first = 0;  // of its rays among them
    int mirror_row = 0;     // rows below this one are mirror images of those above; 0: none is

    // Which ray vertex (i, j) is.
    std::size_t Ray(int i, int j) const {
        const int row = j < mirror_row ? mirror_row - j : j - mirror_row;
        return first + static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.nu) +
               static_cast<std::size_t>(i);
    }
    CellCorners CornersOf(int i, int j) const {
        return {Ray(i, j), Ray(i + 1, j), Ray(i, j + 1), Ray(i + 1, j + 1)};
    }
    // Of the corners' largest rim ratios the smallest.
    double NearestRatio2(const CellCorners& corners) const {
        double nearest = 1e30;
        for (const std::size_t ray : corners)
            nearest = std::min(nearest, static_cast<double>(rays->smallest_rim[ray]));
        return nearest;
    }
};

struct CellIndex {
    int i = 0, j = 0;
};

// A cell of the main grid that a finer grid stands in for, and how many cells a side that has.
struct PatchedCell {
    int i = 0, j = 0, cells = 0;
};

// By how much more a place on the sensor may be off if it lies this far from the axis: 1 within any
// picture and its surroundings, growing with the square of the distance beyond, where nobody looks.
inline double FarScale(double distance_mm) {
    constexpr double kSeen_mm = 60.0;
    const double far = distance_mm / kSeen_mm;
    return far > 1.0 ? far * far : 1.0;
}

// Traces the grids of one ghost and one light. `spec` must outlive it.
class GridTracer {
  public:
    GridTracer(const Lens& lens, const MeshSpec& spec, MeshArithmetic arithmetic);

    // Over the pass region and a little beyond, `cells` (even) a side; its cells' use is left open.
    RawGrid MainGrid(const Rect& rect, int cells);
    // The finer grids of these cells of the main grid, their cells put to use where rays live.
    std::vector<RawGrid> Patches(const MeshGrid& main, const std::vector<PatchedCell>& cells);

    // How far the sensor places of a sample of a main grid's passing rays lie from the reference's,
    // at the middle wavelength, at most, mm; far places count by
    // FarScale.
    double SampledMiss_mm(const RawGrid& main, double sensor_gap_mm);

    const LightBundle& bundle() const { return bundle_; }
    // One a wavelength. Light is traced to the last vertex, wherever the sensor stands: not even
    // the last bit of a mesh may depend on the focus.
    const std::vector<InteractionList>& lists() const { return lists_; }
    // Interactions that light reaches through absorbing glass.
    const std::vector<int>& absorbing() const { return absorbing_; }
    std::size_t steps() const { return lists_.front().steps.size(); }
    std::size_t crossings() const {
        return static_cast<std::size_t>(lists_.front().stop_crossings);
    }
    std::size_t passage_count() const { return steps() + absorbing_.size(); }
    // Of x and y the one that changes its sign in the plane of light and axis: that is the x-z
    // plane or, for an anamorphic lens lit from there, the y-z plane.
    std::size_t mirrored_axis() const { return spec_.azimuth_rad != 0.0 ? 0 : 1; }

    // Traced so far.
    std::uint64_t rays() const { return rays_; }
    std::uint64_t ray_surfaces() const { return ray_surfaces_; }

  private:
    std::shared_ptr<const TracedRays> Trace(const std::vector<Vec2d>& pupil);
    void TraceOneByOne(std::size_t node, const std::vector<Vec2d>& pupil, TraceColumns& out);
    void Store(const InteractionList& list, std::size_t ray, const TraceResult& result,
               TraceColumns& out) const;
    void Judge(TracedRays& rays);

    const MeshSpec& spec_;
    MeshArithmetic arithmetic_;
    LightBundle bundle_;
    std::vector<InteractionList> lists_;
    std::vector<int> absorbing_;
    RayRecord record_;
    std::uint64_t rays_ = 0, ray_surfaces_ = 0;
};

}  // namespace flare
