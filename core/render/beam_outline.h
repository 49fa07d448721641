// SPDX-License-Identifier: Apache-2.0
//
// The edge of the beam that forms a light's image: what rims and iris let through on the direct
// path, in the plane across the beam (LightBundle), by exact rays. Off the axis it is the cat's eye
// that the stop and the rims make together.
//
// The edge is found along 256 directions from the beam's middle, and where one aperture takes over
// from another the corner is found by bisection: a ray for every step, some ten thousand in all. It
// must be seen whole from the middle, as every beam is whose apertures are convex.
#pragma once

#include <optional>

#include "core/base/parallel.h"
#include "core/tracing/light_bundle.h"
#include "core/wave/aperture_outline.h"

namespace flare {

struct BeamOutline {
    EdgeLoop edge;  // (u, v), mm
    Vec2d middle{0.0, 0.0};
    double area_mm2 = 0.0;
};

// `pose` turns the canonical light's stop places into the iris's. Empty: no ray passes, or so small
// a part of the front (1/64 in both directions, away from the chief ray) that it was not met.
std::optional<BeamOutline> FindBeamOutline(const Lens& lens, const LightBundle& bundle,
                                           const CanonicalPose& pose, const Iris& iris,
                                           double wavelength_nm, ThreadPool& threads);

// The mean over the beam of its transmittance and of the light per area of the bundle's plane.
double BeamTransmittance(const Lens& lens, const LightBundle& bundle, const BeamOutline& beam,
                         double wavelength_nm);

}  // namespace flare
