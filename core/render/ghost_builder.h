// SPDX-License-Identifier: Apache-2.0
//
// One ghost of one light, ready to draw: its mesh, the cells that reach the picture, light and
// colour at their vertices, and for the fast picture its tiles.
#pragma once

#include <optional>

#include "core/render/error_estimate.h"
#include "core/render/fringe_plan.h"
#include "core/render/ghost_light.h"
#include "core/render/lights.h"
#include "core/render/render_scene.h"
#include "core/render/renderer.h"
#include "core/render/tile_picture.h"

namespace flare {

// What ghosts are drawn on: pixels of 2^coarse of the picture's, counted from `origin`.
struct GhostCanvas {
    // The canvas a picture is drawn on.
    static GhostCanvas Of(const RenderScene& scene, const TilePicture* tile_picture);
    // From full-frame pixels.
    PictureMap MapOnto(PictureMap map) const;

    int origin_x = 0, origin_y = 0;  // full-frame pixels
    int coarse = 0;
    bool blurred = false;  // what is drawn here is blurred by the source afterwards
    PixelWindow window;    // that is wanted; for tiles in whole blocks
    PixelWindow frame;     // the whole frame, and what is blurred into it
    bool tiles = false;
    double unit = 1.0;  // that tiles hold light in
};

class GhostBuilder {
  public:
    // The arguments must outlive the builder.
    GhostBuilder(const RenderScene& scene, const RenderContext& context);

    // Before the first ghost is built; takes all threads. Does nothing when called again.
    void MakeTables();

    // Where a ghost lands, before it gets any light.
    struct Located {
        std::shared_ptr<const GhostSurface> surface;  // null if nothing passes
        std::vector<GhostLight::Cell> cells;          // that may reach the picture
        MeshMiss miss;
        double dispersion_px = 0.0;  // see LightColour; 0 in a spectral picture
        FringePlan plan;
        Work work;
    };
    // Null when cancelled; `plain`: without fringes. Threads may call it at once.
    Located Locate(const PlacedLight& light, const BounceSequence& sequence,
                   const GhostCanvas& canvas, bool plain = false) const;

    struct Built {
        TiledGhost ghost;  // empty if none of it reaches the picture
        MeshMiss miss;
        std::optional<double> dispersion_step_px;  // if drawn at more than one wavelength
        RingingFacts ringing;
        double flux_mm2 = 0.0;  // on the whole sensor plane, if asked for: see GhostFacts
        Work work;
    };
    // The ghost drawn with `weight`; `plain`: without fringes, at the fewest wavelengths. Empty
    // when cancelled. Threads may call it at once.
    Built Build(const PlacedLight& light, const BounceSequence& sequence, double weight,
                bool with_flux, const GhostCanvas& canvas, bool plain = false) const;

  private:
    LightColour ColourOf(const PlacedLight& light, const BounceSequence& sequence,
                         double weight) const;
    std::vector<GhostLight::Cell> InFrame(const GhostSurface& surface, const Iris& iris,
                                          const PictureMap& map, const GhostCanvas& canvas,
                                          const std::vector<GhostLight::Cell>& cells) const;

    const RenderScene& scene_;
    const RenderContext& context_;
    // Of the drawn bands, and of the wavelength that fluxes are told at.
    std::shared_ptr<const TransmissionTables> tables_, flux_tables_;
    std::vector<double> bounded_nm_;  // wavelengths that bound where the ghost lands
};

}  // namespace flare
