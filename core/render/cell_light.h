// SPDX-License-Identifier: Apache-2.0
//
// The light on the cells of one ghost, transmittance times flux density, at each wavelength of the
// tables: how finely each cell must be sampled, and the light at all samples, many at once
// (passage_columns.h). What a cell gets does not depend on which others are asked for.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/image/ghost_walk.h"
#include "core/mesh/passage_columns.h"
#include "core/mesh/transmission.h"
#include "core/tracing/light_bundle.h"

namespace flare {

class LightPoints;
struct VertexPoints;

// By how much the light at a cell's corners is to be scaled so that its bilinear mean is the
// light's own: at the first, the middle and the last wavelength of the tables.
struct LightLift {
    std::array<float, 3> factor = {1.0F, 1.0F, 1.0F};

    // `share`: how far from the first wavelength to the last, 0..1.
    float At(double share) const;
};

class CellLight {
  public:
    // All arguments must outlive it; `surface` has cells.
    CellLight(const GhostSurface& surface, const LightBundle& bundle,
              const TransmissionTables& tables, const TransmissionTables::Path& path);

    // Sets light_cuts: corners only, unless the light at the middle is far from their mean. A miss
    // counts by the ghost's brightest cell where the cell itself is dim, as towards grazing
    // incidence. The result is each cell's lift, none for those that are cut.
    std::vector<LightLift> ChooseCuts(std::vector<GhostLight::Cell>& cells, double tolerance) const;

    // Lattice by lattice, cell after cell: point_of[n] is the place among the result's points of
    // the n-th lattice point. The result is [point][wavelength].
    std::vector<float> Light(const std::vector<GhostLight::Cell>& cells,
                             std::vector<std::uint32_t>& point_of) const;

  private:
    // Middle, corners, and next to the critical angle the middles of the quarters.
    static constexpr std::size_t kSamples = 9;
    static constexpr double kDim = 0.2;  // of the brightest cell

    double Brightest() const;
    std::uint32_t AddCorner(const CellPlace& place, int i, int j, LightPoints& points,
                            VertexPoints& vertices) const;
    void AddSamples(const CellPlace& place, bool critical, LightPoints& points,
                    VertexPoints& vertices, std::array<std::uint32_t, kSamples>& at) const;
    static int CutsOf(const std::array<std::array<double, kSamples>, 3>& light, double brightest,
                      double tolerance, bool critical);
    static float LiftOf(const std::array<double, kSamples>& light, double brightest);
    bool NearCriticalAngle(const CellPlace& place) const;

    const GhostSurface& surface_;
    const GhostMesh& mesh_;
    const LightBundle& bundle_;
    PathInColumns path_;
};

}  // namespace flare
