// SPDX-License-Identifier: Apache-2.0
//
// The rays of one point light that may enter the lens, as a family over a plane across the beam.
// The plane passes through the centre of the paraxial entrance pupil; (u, v) are mm in it, u in the
// meridional plane (the one of light and axis). The light is kept in a canonical place
// (CanonicalPose): for a rotational lens it travels along (sin a, 0, cos a) in lens space, any
// other azimuth being a rotation of the result; for an anamorphic one its azimuth lies between the
// x and y axes, the other quadrants being mirror images. Works for any angle, also beyond 90
// degrees, and for lights at infinity (inverse distance 0).
#pragma once

#include "core/optics/lens.h"
#include "core/tracing/trace_reference.h"

namespace flare {

// How lens space is turned or mirrored to bring a light into its canonical place.
struct CanonicalPose {
    double azimuth_rad = 0.0;  // of the canonical light's travel: 0, or 0 .. pi/2 if anamorphic
    // The canonical x and y axes as they stand in lens space.
    Vec2d x_axis{1.0, 0.0}, y_axis{0.0, 1.0};

    Vec2d LensSpace(Vec2d canonical) const { return x_axis * canonical.x + y_axis * canonical.y; }
};

// For a light that travels with this azimuth, atan2 of its y and x directions, in lens space.
CanonicalPose PoseOf(const Lens& lens, double azimuth_rad);

class LightBundle {
  public:
    // `field_rad` 0..pi from the axis; `inverse_distance` 1/mm, from the entrance pupil's centre;
    // `azimuth_rad` of a canonical light.
    LightBundle(const Lens& lens, double field_rad, double inverse_distance,
                double azimuth_rad = 0.0);

    Ray At(double u, double v) const;
    // The same line, its origin moved along it to near the front vertex: for tracers in floats.
    Ray AtFront(double u, double v) const;
    // The ray through the same place of the plane once the light has turned about the pupil's
    // centre: its travel leans towards +u and +v by the components of `turn_rad`. What LightBundle
    // says of flux and rims is of the light that has not turned.
    Ray TurnedAtFront(double u, double v, Vec2d turn_rad) const;
    // Where a light travels that has turned so, in canonical lens space.
    Vec3d TurnedTravel(Vec2d turn_rad) const;
    // The turn that takes the light there; nothing is farther than half a circle.
    Vec2d TurnTo(const Vec3d& travel) const;

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
    // Is the lens, seen from the light, the same for v and -v?
    bool mirror_symmetric() const { return mirror_symmetric_; }
    // A place given across and along the meridional plane of this light, in canonical lens space.
    Vec2d Meridional(double along, double across) const {
        return Vec2d(cos_azimuth_, sin_azimuth_) * along +
               Vec2d(-sin_azimuth_, cos_azimuth_) * across;
    }

  private:
    void BoundFrontCap(const Lens& lens);

    double field_rad_, inverse_distance_;
    double cos_azimuth_ = 1.0, sin_azimuth_ = 0.0;
    bool mirror_symmetric_ = true;
    Vec3d pupil_, travel_, e1_, e2_;
    double to_front_ = 0.0;  // along travel_ from the pupil's centre to abreast of vertex 0
    double centre_u_ = 0.0, half_width_ = 0.0;
};

}  // namespace flare
