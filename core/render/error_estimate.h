// SPDX-License-Identifier: Apache-2.0
//
// How far a picture is from the converged one, by what is known while it is drawn. Most errors sit
// at the edges of ghosts: something that is e pixels off there counts with the share of a ghost's
// light that lies within e of its edge, 3.5 e / sqrt(area) for a disc. What a mesh lacks between
// its vertices is seen in them: each is compared with the cubic through its neighbours. The factors
// are fitted to measured errors; docs/accuracy.md compares both. An estimate, not a bound: made to
// lie above the error more often than below.
#pragma once

#include <vector>

#include "core/image/ghost_walk.h"
#include "core/render/ghost_sample.h"
#include "core/render/quality.h"
#include "core/render/report.h"

namespace flare {

// How far interpolation in a ghost's mesh is off, in the mean over the cells that are drawn.
struct MeshMiss {
    double position_px = 0.0;
    double density = 0.0;  // relative, of irradiance
};

MeshMiss MeshMissOf(const GhostSurface& surface, const std::vector<GhostLight::Cell>& cells,
                    const PictureMap& map);

class ErrorEstimate {
  public:
    ErrorEstimate(const Lens& lens, const QualitySettings& settings, bool spectral);

    // One ghost of one light, drawn with `weight`, of which neighbouring wavelengths lie at most
    // `dispersion_step_px` apart.
    void AddDrawn(const GhostSample& sample, double weight, double dispersion_step_px,
                  const MeshMiss& miss);
    // The same ghost, of a light that is no point: what its blur is wrong by, relative.
    void AddSource(const GhostSample& sample, double weight, double error);
    // All ghosts of one light, and what is lost of them by culling.
    void AddLight(double frame_light, double lost_light);

    EstimatedError Value() const;

  private:
    const QualitySettings& settings_;
    double colour_;        // relative error of a ghost's colour
    double tile_edge_px_;  // how far a mask's edge may be off in a tile
    double drawn_light_ = 0.0;
    double edge_light_ = 0.0;        // drawn light a pixel from an edge
    double dispersion_light_ = 0.0;  // drawn light at edges that are coloured wrongly
    double source_light_ = 0.0;      // drawn light that is blurred wrongly
    double mesh_light_ = 0.0;        // drawn light that is misplaced by interpolation
    double frame_light_ = 0.0, lost_light_ = 0.0;
};

}  // namespace flare
