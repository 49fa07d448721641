// SPDX-License-Identifier: Apache-2.0
//
// Would the edges of a ghost show diffraction fringes, and by which model should they be drawn? A
// first-order answer for light from infinity, at one passage through the stop: the ghost is the
// Fresnel pattern of the stop after z_eff = B2 A1 / A, magnified by m = A / A1 (Collins' integral
// with the front's curvature C1 / A1; docs/physics/wave.md).
//
// A fringe is the distance from the geometric edge to the first maximum. Three things wash it out:
// the source's disc, which moves the edge by d(sensor) / d(angle) at a fixed stop point; the pixel;
// and the bandwidth, which scales the pattern by the root of the wavelength.
#pragma once

#include "core/tracing/paraxial_ghost.h"

namespace flare {

// Where Fresnel's integrals have their first maximum behind a straight edge, in v.
inline constexpr double kFirstFringe = 1.2172;
// From this Fresnel number on the edge is straight on the scale of its fringes.
inline constexpr double kManyFresnelZones = 50.0;

struct RingingConditions {
    double aperture_radius_mm = 0.0;  // of the opening in the stop
    double wavelength_nm = 550.0;
    double source_rad = 0.0;  // angular diameter of the light
    double pixel_mm = 0.0;
    double relative_bandwidth = 0.0;  // of what one plane of the picture sums up
};

enum class RingingModel {
    kGeometric,    // nothing to be seen: a sharp or blurred edge
    kEdgeProfile,  // many fringes' worth of aperture: Fresnel's integrals along the edge
    kPropagation,  // the pattern as a whole: propagate the aperture
};

enum class RingingReason {
    kVisible,
    kStopInFocus,  // the sensor, or the light, is conjugate to the stop: its image is sharp, or
                   // the beam is a point there and no edge cuts it
    kSource,
    kPixel,
    kBandwidth
};

struct GhostRinging {
    double m = 0.0;
    double z_eff_mm = 0.0;
    double fresnel_number = 0.0;  // a^2 / (lambda |z_eff|); infinite if z_eff is 0
    double fringe_mm = 0.0;       // on the sensor
    double blur_mm = 0.0;         // of the source's disc there
    double fringes = 0.0;         // that the bandwidth leaves, of those within the aperture
    RingingModel model = RingingModel::kGeometric;
    RingingReason reason = RingingReason::kVisible;
};

// At the path's passage `crossing` through the stop. In a ghost that is in focus (A = 0) z_eff is
// infinite, the Fraunhofer case, and the fringe the first bright ring of the aperture's pattern.
GhostRinging RingingOf(const ParaxialPath& path, std::size_t crossing,
                       const RingingConditions& conditions);

}  // namespace flare
