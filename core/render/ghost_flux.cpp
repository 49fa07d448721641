// SPDX-License-Identifier: Apache-2.0
#include "core/render/ghost_flux.h"

#include "core/render/ghost_light.h"

namespace flare {
namespace {

class FluxSink final : public PieceSink {
  public:
    explicit FluxSink(GhostFlux& flux) : flux_(flux) {}

    void Add(std::span<const Vec2d> points, std::span<const double> light, int /*band*/) override {
        Vec2d mean(0.0, 0.0);
        for (const Vec2d& p : points) mean += p;
        flux_.flux_mm2 += light[0];
        flux_.centroid_mm += mean * (light[0] / static_cast<double>(points.size()));
    }
    void EndOfPiece() override {}

  private:
    GhostFlux& flux_;
};

}  // namespace

GhostFlux FluxOf(const std::shared_ptr<const GhostSurface>& surface, const LightBundle& bundle,
                 const Lens& lens, const TransmissionTables& tables, const Iris& iris,
                 const WalkTolerance& tolerance, const CanonicalPose& pose) {
    // A "picture" in millimetres of the canonical sensor: one unit of length is one millimetre, so
    // the cuts are the masks' and the coarsest that the tolerances allow.
    PictureMap map;
    map.px_per_x = {1.0, 0.0};
    map.px_per_y = {0.0, 1.0};
    map.offset_px = {0.0, 0.0};
    map.stop_per_x = pose.x_axis;
    map.stop_per_y = pose.y_axis;
    LightColour colour;
    colour.spectral = true;
    const std::vector<double>& wavelengths = tables.wavelengths_nm();
    const GhostLight prepared = PrepareGhost(surface, bundle, lens, tables, colour,
                                             CellsInWindow(*surface, wavelengths, iris, map, {}));
    GhostFlux flux;
    if (prepared.cells.empty()) return flux;
    FluxSink sink(flux);
    GhostWalk walk(prepared, iris, map, tolerance);
    for (const GhostLight::Cell& cell : prepared.cells) walk.Cell(cell, {}, sink);
    if (flux.flux_mm2 > 0.0) flux.centroid_mm /= flux.flux_mm2;
    return flux;
}

}  // namespace flare
