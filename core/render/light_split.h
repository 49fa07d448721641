// SPDX-License-Identifier: Apache-2.0
//
// A layer for each light ("split": "light"): the picture is made light by light; each one's root,
// with everything that the light adds, becomes planes of its own, "light0.R", and the sums are the
// sums over the lights.
#pragma once

#include <vector>

#include "core/render/layer_planes.h"

namespace flare {

class LightSplit {
  public:
    // The scene must outlive it.
    explicit LightSplit(const RenderScene& scene) : scene_(scene) {}

    // Takes the picture of light number `index`: the root's planes first, all lights the same ones.
    void Add(std::size_t index, FlareImage picture);

    // Appends the sums and then the lights, and lets go of them. At least one light was added.
    void AppendTo(FlareImage& image);

  private:
    struct Sum {
        std::string name;
        std::vector<double> values;
    };
    const RenderScene& scene_;
    std::vector<Sum> sums_;
    std::vector<ImagePlane> lights_;
};

}  // namespace flare
