// SPDX-License-Identifier: Apache-2.0
//
// From the light that a layer has gathered to planes of an image: every layer stands in the root,
// which is the sum of all, and under its own name.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "core/image/flare_image.h"
#include "core/render/render_scene.h"

namespace flare {

// One plane a channel of the scene, over its window.
using LayerPlanes = std::vector<std::vector<float>>;

// Clamped to finite floats.
inline float PlaneValue(double value) {
    constexpr double kMost = std::numeric_limits<float>::max();
    return static_cast<float>(value > kMost ? kMost : value < -kMost ? -kMost : value);
}

// Adds a layer's planes to an image that holds the root first, or nothing yet. A root of one layer
// shares its samples.
void AppendLayer(const RenderScene& scene, const std::string& name, LayerPlanes planes,
                 FlareImage& image);

// Adds planes under a name without touching the root.
void AppendBeside(const RenderScene& scene, const std::string& name, LayerPlanes planes,
                  FlareImage& image);

}  // namespace flare
