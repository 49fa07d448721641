// SPDX-License-Identifier: Apache-2.0
//
// The picture that ghosts are drawn on: by exact polygons, or by tiles where the request's quality
// and colour allow them. Planes of the scene's window.
#pragma once

#include <optional>
#include <vector>

#include "core/render/layer_planes.h"
#include "core/render/picture.h"
#include "core/render/renderer.h"
#include "core/render/tile_picture.h"

namespace flare {

class GhostPicture {
  public:
    // The arguments must outlive the picture.
    GhostPicture(const RenderScene& scene, const RenderContext& context);

    // Null where polygons alone are drawn.
    const TilePicture* tiles() const { return tiles_ ? &*tiles_ : nullptr; }

    // Adds the ghosts in the order given; they are as before when it returns. `map` is MapOf the
    // light. Work: polygons and fragments.
    void Draw(std::vector<TiledGhost>& ghosts, const PictureMap& map, Work& work,
              std::span<LeftPixels> kept = {});

    // Light in a pixel times `scale`.
    LayerPlanes Resolve(double scale) const;
    // Back to darkness.
    void Clear();

  private:
    const RenderScene& scene_;
    const RenderContext& context_;
    // One of the two.
    std::optional<Picture> polygons_;
    std::optional<TilePicture> tiles_;
};

}  // namespace flare
