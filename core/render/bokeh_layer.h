// SPDX-License-Identifier: Apache-2.0
//
// The bokeh: the direct image of each light, in or out of focus, as the lens makes it: aberrated,
// vignetted, with the iris's shape and the glasses' colours. It is the ghost of the empty bounce
// sequence, drawn by the same mesh as exact polygons, so an image that collapses into a pixel
// leaves all its light there. docs/bokeh.md.
//
// Absolute: the sum over the sensor is E0 times the projected area of the beam times its
// transmittance. Geometric: diffraction is the starburst's.
#pragma once

#include "core/render/ghost_builder.h"
#include "core/render/layer_planes.h"
#include "core/render/picture.h"

namespace flare {

class BokehLayer {
  public:
    // The arguments must outlive the layer; facts and work are added to `report`.
    BokehLayer(const RenderScene& scene, const RenderContext& context, Report& report);

    // Adds a light's image. Unfinished when cancelled.
    void Add(const PlacedLight& light);

    // Light in a pixel times `scale`.
    LayerPlanes Resolve(double scale) const;
    // Back to a picture without light.
    void Clear() { picture_.Clear(); }

  private:
    RenderScene scene_;  // with settings of its own
    const RenderContext& context_;
    Report& report_;
    GhostBuilder builder_;
    TransmissionTables flux_tables_;
    Picture picture_;
};

}  // namespace flare
