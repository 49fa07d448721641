// SPDX-License-Identifier: Apache-2.0
//
// Where on the front surface the photons of one lamp and sequence are worth most: cells of a grid
// in which rays may pass all rims and the iris. Only where samples are taken more densely depends
// on it, never what they count: light outside is found too, with more noise.
#pragma once

#include <cstdint>
#include <vector>

#include "core/optics/iris.h"
#include "core/render/photon_source.h"

namespace flare {

class PhotonRegion {
  public:
    // By a few thousand unclipped rays at the d line: a cell is kept if the largest of a ray's
    // distances from the axis, each in units of what may pass there, is below 1 in it or can be by
    // how it changes to the next cells; the grid is then laid on the kept cells' box, and so on.
    // Until a ray has passed, the cells whose rays came through most surfaces are kept as well.
    PhotonRegion(const Lens& lens, const Iris& iris, const BounceSequence& sequence,
                 const PhotonSource& source);

    // In the unit square that PhotonSource takes places from.
    double area() const { return static_cast<double>(cells_.size()) * step_.x * step_.y; }
    bool Contains(Vec2d place) const;
    std::size_t cell_count() const { return cells_.size(); }
    // A place in cell number `cell`, from one in the unit square.
    Vec2d Place(std::size_t cell, Vec2d within) const;
    std::uint64_t rays() const { return rays_; }

  private:
    Vec2d low_{0.0, 0.0}, step_{1.0, 1.0};
    std::vector<int> cells_;          // numbers of those kept, row by row
    std::vector<std::uint8_t> kept_;  // by number
    std::uint64_t rays_ = 0;
};

}  // namespace flare
