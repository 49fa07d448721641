// SPDX-License-Identifier: Apache-2.0
//
// RGB spaces as the CIE 1931 xy of their primaries and white, and the linear map between two of
// them. Whites are adapted by the Bradford transform (Lam 1985; as in ICC.1:2010, annex E), so that
// (1, 1, 1) stays (1, 1, 1): a picture that is neutral in one space is neutral in the other. Values
// are never clipped; colours outside the space that is gone to come out with negative parts.
#pragma once

#include "core/base/vec.h"

namespace flare {

struct Chromaticities {
    Vec2d red, green, blue, white;

    friend bool operator==(const Chromaticities&, const Chromaticities&) = default;
};

// ITU-R BT.709; SMPTE ST 2065-1 (AP0); Academy S-2014-004 (AP1, ACEScg). The last two share ACES
// white, near D60.
const Chromaticities& Rec709Chromaticities();
const Chromaticities& Ap0Chromaticities();
const Chromaticities& Ap1Chromaticities();

// Rows of a matrix times a column of values.
class RgbMap {
  public:
    RgbMap(const Chromaticities& from, const Chromaticities& to);
    Vec3d operator()(const Vec3d& rgb) const {
        return {row_[0].dot(rgb), row_[1].dot(rgb), row_[2].dot(rgb)};
    }

  private:
    Vec3d row_[3];
};

}  // namespace flare
