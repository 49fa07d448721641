// SPDX-License-Identifier: Apache-2.0
//
// The rays of one point light that may enter the lens, as a family over a plane across the beam.
// The plane passes through the centre of the paraxial entrance pupil; (u, v) are mm in it, u in the
// meridional plane. The light is kept in a canonical place: it travels along (sin a, 0, cos a) in
// lens space; a rotationally symmetric lens gives every other azimuth by rotating the result. Works
// for any angle, also beyond 90 degrees, and for lights at infinity (inverse distance 0).
#pragma once

#include "core/optics/lens.h"
#include "core/tracing/trace_reference.h"

namespace flare {

class LightBundle {
  public:
    // `field_rad` 0..pi from the axis; `inverse_distance` 1/mm, from the entrance pupil's centre.
    LightBundle(const Lens& lens, double field_rad, double inverse_distance);

    Ray At(double u, double v) const;

    // Flux through the ray's surroundings per du dv, for E0 = 1 at the pupil's centre perpendicular
    // to the beam: 1 for light from infinity, (D / r)^3 for a point at distance D (inverse square
    // of the distance r and cosine to the plane).
    double FluxDensity(double u, double v) const;

    // Every ray that can meet surface 0 inside its rim lies in the square of this half-width about
    // (u, v) = (centre_u, 0). Rays more than atan(20) = 87 degrees off the line from a near light
    // to the pupil's centre are left out.
    double centre_u() const { return centre_u_; }
    double half_width() const { return half_width_; }

    double field_rad() const { return field_rad_; }
    double inverse_distance() const { return inverse_distance_; }

  private:
    void BoundFrontCap(const Lens& lens);

    double field_rad_, inverse_distance_;
    Vec3d pupil_, travel_, e1_, e2_;
    double centre_u_ = 0.0, half_width_ = 0.0;
};

}  // namespace flare
