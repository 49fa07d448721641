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

    // Does the light go bilinearly from corner to corner of the cell?
    bool Even(const FittedCell& cell) const { return From(cell).light_cuts == 1; }
    // What is asked for at a point, for each unit of the cell's own coordinates: red, green and
    // blue of traced wavelength k, of all bands together, or both after each other.
    enum class Of { kTraced, kAll, kBoth };
    // At the cell's corners.
    LightCorners Corners(Of what, std::size_t k, const FittedCell& cell) const;
    // At a point, of any cell.
    std::array<float, kTileLights> At(Of what, std::size_t k, const FittedCell& cell, float a,
                                      float b) const;
    // Of one band at a point, by the nearest point of the cell's lattice, and not for each unit:
    // only ratios between bands count.
    TileColour OfBand(std::size_t band, const FittedCell& cell, float a, float b) const;

  private:
    const GhostLight::Cell& From(const FittedCell& cell) const {
        return ghost_.cells[static_cast<std::size_t>(cell.cell)];
    }
    // A point of the cell's lattice, by its place among all.
    std::array<float, kTileLights> Point(Of what, std::size_t k, std::size_t at, float area) const;

    const GhostLight& ghost_;
    double scale_ = 1.0;
    std::array<std::vector<float>, kTracedInTiles + 1> light_;  // laid out as Band::light
};

}  // namespace flare
