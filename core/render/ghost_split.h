// SPDX-License-Identifier: Apache-2.0
//
// A layer for each ghost ("split": "ghost"): every ghost that puts light on the picture is drawn a
// second time, alone, and added to planes of its own, "ghosts.9_1.R". Over all lights they add up
// to the ghosts layer.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "core/render/ghost_picture.h"
#include "core/tracing/bounce_sequence.h"

namespace flare {

// "9_1"
std::string SequenceLabel(const BounceSequence& sequence);

// Whether so many layers may be held; the error's `where` is "/split".
std::optional<Error> CheckSplitLayers(const RenderScene& scene, std::size_t layers);

class GhostSplit {
  public:
    // The arguments must outlive it.
    GhostSplit(const RenderScene& scene, const RenderContext& context);

    // Adds one light's ghost, `ghost` being as GhostPicture draws it.
    std::optional<Error> Add(const BounceSequence& sequence, TiledGhost& ghost,
                             const PictureMap& map, Work& work);

    // Appends the planes, times `scale`, by sequence, and lets go of them.
    void AppendTo(FlareImage& image, double scale);

  private:
    const RenderScene& scene_;
    GhostPicture scratch_;
    std::map<BounceSequence, LayerPlanes> layers_;
};

}  // namespace flare
