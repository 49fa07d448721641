// SPDX-License-Identifier: Apache-2.0
//
// A ghost's light as tiles take it: by traced wavelength instead of by band, in single precision,
// in units of a power of two near the brightest value.
#pragma once

#include <array>
#include <vector>

#include "core/image/cell_fits.h"

namespace flare {

using TileColour = std::array<float, 3>;

inline float Luminance(const TileColour& rgb) {
    return 0.2126F * rgb[0] + 0.7152F * rgb[1] + 0.0722F * rgb[2];
}

class TileLight {
  public:
    // The ghost must outlive it.
    explicit TileLight(const GhostLight& ghost);

    // What a float of 1 stands for.
    double scale() const { return scale_; }

    // At a point of a cell, for each unit of the cell's own coordinates: of a traced wavelength, of
    // all bands together, and of one band (by the nearest point of the cell's lattice, and not for
    // each unit: only ratios between bands count).
    TileColour OfTraced(std::size_t k, const FittedCell& cell, float a, float b) const {
        return At(light_[k], cell, a, b);
    }
    TileColour OfAll(const FittedCell& cell, float a, float b) const {
        return At(light_[kTracedInTiles], cell, a, b);
    }
    TileColour OfBand(std::size_t band, const FittedCell& cell, float a, float b) const;

  private:
    TileColour At(const std::vector<float>& light, const FittedCell& cell, float a, float b) const;

    const GhostLight& ghost_;
    double scale_ = 1.0;
    std::array<std::vector<float>, kTracedInTiles + 1> light_;  // laid out as Band::light
};

}  // namespace flare
