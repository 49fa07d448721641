// SPDX-License-Identifier: Apache-2.0
//
// The picture while light is added to it: planes of doubles over the data window, in E0 mm^2 a
// pixel. Drawn in horizontal strips: a strip is one thread's own, and every pixel gets its light
// ghost by ghost, cell by cell, band by band, so the sums do not depend on threads or strips.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/parallel.h"
#include "core/image/flare_image.h"
#include "core/render/ghost_light.h"

namespace flare {

class Picture {
  public:
    // `spectral_layers` wavelengths, or 0 for colour.
    Picture(const PixelWindow& window, int spectral_layers);

    struct Drawn {
        std::uint64_t pieces = 0;
        std::uint64_t fragments = 0;
    };
    // Adds the ghosts in the order given. Stops early, leaving the picture unfinished, when
    // cancelled.
    Drawn Draw(const std::vector<GhostLight>& ghosts, const Iris& iris, const PictureMap& map,
               const WalkTolerance& tolerance, ThreadPool& threads, const CancelToken& cancel);

    // Back to darkness.
    void Clear();

    const PixelWindow& window() const { return window_; }
    // Channel `index` (a wavelength, or red, green, blue) times `scale`, clamped to finite floats.
    std::vector<float> Channel(int index, double scale) const;
    int channel_count() const { return spectral_ ? static_cast<int>(layers_.size()) : 3; }

  private:
    Drawn DrawStrip(int row, int rows, const std::vector<GhostLight>& ghosts, const Iris& iris,
                    const PictureMap& map, const WalkTolerance& tolerance,
                    const CancelToken& cancel);

    PixelWindow window_;
    bool spectral_;
    std::vector<std::vector<double>> layers_;
};

WalkWindow WalkWindowOf(const PixelWindow& window);

}  // namespace flare
