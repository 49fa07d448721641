// SPDX-License-Identifier: Apache-2.0
//
// A ghost's light as tiles take it: by traced wavelength instead of by band, in the ghost's units.
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
    double scale() const { return ghost_.light_unit; }

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
    // Adds `factor` times the light of each band, as far as it leans on traced wavelength k, at a
    // point: [band][channel]. Over all k that is the band's light.
    void AddBands(std::size_t k, const FittedCell& cell, const std::array<float, 2>& at,
                  float factor, float* rgb) const;

  private:
    const GhostLight::Cell& From(const FittedCell& cell) const {
        return ghost_.cells[static_cast<std::size_t>(cell.cell)];
    }
    // Where a place in a cell lies in its lattice of light: the first of four points, and their
    // shares of the light there.
    struct InLattice {
        std::size_t point = 0, row = 0;  // points from row to row
        std::array<float, 4> shares{};
    };
    InLattice Find(const GhostLight::Cell& cell, float a, float b) const;
    // Of each unit of the cell's own coordinates.
    float AreaOf(const GhostLight::Cell& cell) const;
    // A point of the cell's lattice, by its place among all.
    std::array<float, kTileLights> Point(Of what, std::size_t k, std::size_t point,
                                         float area) const;

    static constexpr std::size_t kSums = 3 * (kTracedInTiles + 1);

    const GhostLight& ghost_;
    std::vector<float> sums_;  // [point][traced wavelength, or all bands][channel]
    // [traced wavelength][band][channel]: how bands lean on it
    std::array<std::vector<float>, kTracedInTiles> leans_;
};

}  // namespace flare
