// SPDX-License-Identifier: Apache-2.0
//
// A grid of exactly traced rays before anybody has decided which of it a ghost mesh keeps: every
// wavelength, every interaction's rim ratio, and how each ray ended. Main grid and patches are
// traced alike. Used by the mesh builder.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh/ghost_mesh.h"
#include "core/mesh/mesh_builder.h"
#include "core/mesh/pass_region.h"
#include "core/tracing/light_bundle.h"

namespace flare {

struct RawNode {
    std::vector<float> exit;     // [vertex][x, y, dx/dz, dy/dz] at the last vertex
    std::vector<float> stops;    // [vertex][2 * crossings]
    std::vector<float> rims;     // [vertex][interaction], see GhostMesh
    std::vector<float> passage;  // [vertex][passage], see transmission.h
};

// How a vertex counts for the masks at all wavelengths.
enum class VertexState : std::uint8_t { kAlive, kDead, kDeadOutside };

struct RawGrid {
    MeshGrid grid;
    std::vector<RawNode> nodes;
    std::vector<VertexState> state;
    std::vector<float>
        smallest_rim;  // [vertex] over wavelengths: largest rim ratio^2 met (rims, stop)
};

using CellCorners = std::array<std::size_t, 4>;

inline CellCorners CornersOf(const MeshGrid& grid, int i, int j) {
    return {grid.Vertex(i, j), grid.Vertex(i + 1, j), grid.Vertex(i, j + 1),
            grid.Vertex(i + 1, j + 1)};
}

// Traces the grids of one ghost and one light. `spec` must outlive it.
class GridTracer {
  public:
    GridTracer(const Lens& lens, const MeshSpec& spec);

    // Over the pass region and a little beyond; its cells' use is left open.
    RawGrid MainGrid(const Rect& rect);
    // The finer grid of the main grid's cell (ci, cj), its cells put to use where rays live.
    RawGrid Patch(const MeshGrid& main, int ci, int cj);

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

    // Traced so far.
    std::uint64_t rays() const { return rays_; }
    std::uint64_t ray_surfaces() const { return ray_surfaces_; }

  private:
    void Allocate(RawGrid& raw) const;
    void TraceVertex(RawGrid& raw, int i, int j);
    void Store(RawNode& node, const InteractionList& list, std::size_t vertex,
               const TraceResult& result) const;
    void MirrorVertex(RawGrid& raw, std::size_t from, std::size_t to) const;
    void MirrorPair(const float* from, float* to) const;

    const MeshSpec& spec_;
    LightBundle bundle_;
    std::vector<InteractionList> lists_;
    std::vector<int> absorbing_;
    RayRecord record_;
    std::uint64_t rays_ = 0, ray_surfaces_ = 0;
};

}  // namespace flare
