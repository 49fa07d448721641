// SPDX-License-Identifier: Apache-2.0
//
// A ghost mesh as a smooth surface: every field of a vertex (sensor place, stop places, rim ratios)
// as a function of the pupil place, cubic in both directions within a cell and with continuous
// slopes between cells (Hermite; slopes by fourth-order differences of the traced vertices, lower
// order where neighbours are dead). A cell is handed out as a Bezier net: the surface lies within
// the convex hull of its control points, so bounds are safe.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "core/mesh/ghost_mesh.h"

namespace flare {

// The 4 x 4 control values of one field over one cell, [row of v][column of u].
using BezierNet = std::array<double, 16>;

// One cell at one wavelength: a net a field.
struct CellSurface {
    std::vector<BezierNet> nets;
    std::vector<double> jets;  // scratch of Evaluate
};

// One field at the corners (0, 0), (1, 0), (0, 1), (1, 1) of a cell: value, du, dv, duv per cell.
using CellJets = std::array<std::array<float, 4>, 4>;

struct CellPlace {
    int grid = 0, i = 0, j = 0;
};

class GhostSurface {
  public:
    // `sensor_gap_mm`: from the last vertex to the sensor. Cells whose light cannot pass an iris
    // within `iris_radius_mm` are left out (FarOutsideStop), which at a small opening is most of
    // them. Without `cubic` every cell is bilinear.
    GhostSurface(std::shared_ptr<const GhostMesh> mesh, double sensor_gap_mm,
                 double iris_radius_mm = 1e300, bool cubic = true);

    const GhostMesh& mesh() const { return *mesh_; }
    double sensor_gap_mm() const { return sensor_gap_mm_; }

    // All cells that may pass light through that iris, in a fixed order.
    const std::vector<CellPlace>& cells() const { return cells_; }
    CellUse UseOf(const CellPlace& cell) const;
    // Which corner of a kTriangle cell is dead: 0 (i, j), 1 (i+1, j), 2 (i, j+1), 3 (i+1, j+1).
    int DeadCorner(const CellPlace& cell) const;

    // Is the cell so far outside radius `radius_mm` at some stop crossing that its light cannot
    // pass? A cheap look at the corners; false when in doubt.
    bool FarOutsideStop(const CellPlace& cell, double radius_mm) const;

    // The cell at the wavelength whose node weights are given (NodeWeights). A dead corner of a
    // triangle is filled in by the parallelogram rule. Fields first ... end - 1; the others' nets
    // are left as they are.
    void Evaluate(const CellPlace& cell, const std::vector<double>& node_weights, int first,
                  int end, CellSurface& out) const;

    // A field of the cell at a traced wavelength, in single precision.
    void Jets(const CellPlace& cell, std::size_t node, std::size_t field, CellJets& out) const;

  private:
    // [node][vertex * fields + field]: du, dv, duv per cell.
    using GridSlopes = std::vector<std::vector<std::array<float, 3>>>;

    bool Smooth(const MeshGrid& grid) const { return cubic_ && grid.smooth; }
    void AddCells(int g, double iris_radius_mm);
    bool FarOutside(const MeshGrid& grid, std::span<const std::size_t> vertices,
                    double radius_mm) const;
    // Of the whole grid, as FarOutsideStop of a cell.
    bool GridFarOutside(const MeshGrid& grid, double radius_mm) const;
    // Of each grid the vertices of its cells and of those next to them; none: empty.
    std::vector<std::vector<std::uint8_t>> Corners() const;
    void AddSlopes(const MeshGrid& grid, const std::vector<std::uint8_t>& corners,
                   GridSlopes& out) const;

    // Field f of a vertex, those of the sensor taken to where it stands.
    double Value(const MeshNode& node, std::size_t vertex, std::size_t f) const;

    std::shared_ptr<const GhostMesh> mesh_;
    double sensor_gap_mm_;
    bool cubic_;
    std::vector<CellPlace> cells_;
    std::vector<GridSlopes> slopes_;  // of each smooth grid
};

}  // namespace flare
