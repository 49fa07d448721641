// SPDX-License-Identifier: Apache-2.0
//
// The shape of a light: an image of where it shines, white where it is brightest, as shares of its
// light on a square of cells. The image stands upright in the scene around the light's direction,
// its longer side as wide as the light. It is kept on at most 64 cells a side, each the exact mean
// of what it covers. Immutable, shared by threads.
#pragma once

#include <memory>
#include <vector>

#include "core/base/vec.h"

namespace flare {

class SourcePicture {
  public:
    static constexpr int kMostSide = 64;

    // Values of an image, row by row from the top, finite and none below 0; the image stands in
    // the middle of a dark square. Null: it has no light.
    static std::shared_ptr<const SourcePicture> Of(int width, int height,
                                                   const std::vector<float>& values);

    int side() const { return side_; }
    // The share of the light in cell (i, j), i-th from the left and j-th from *below*; all of them
    // add up to 1.
    double At(int i, int j) const {
        return shares_[static_cast<std::size_t>(j) * static_cast<std::size_t>(side_) +
                       static_cast<std::size_t>(i)];
    }
    // Radius of a disc that has as much outline for its light, in half-widths of the square: how
    // fine the shape's finest parts are.
    double detail() const { return detail_; }

  private:
    SourcePicture(int side, std::vector<double> shares);

    int side_;
    std::vector<double> shares_;
    double detail_ = 0.0;
};

// What is right and up in the picture of a light that stands there, in camera axes: up is where a
// level camera's picture has it, straight above and below the lens the way that goes on from ahead.
struct UprightAxes {
    Vec3d right, up;
};
UprightAxes UprightAt(const Vec3d& direction);

}  // namespace flare
