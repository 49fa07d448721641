// SPDX-License-Identifier: Apache-2.0
//
// The edge of the beam that forms a light's image, where the iris has a picture: its outlines taken
// back from the stop to the plane across the beam, cut by what blades and rims let through.
// Outlines are straightened to a quarter of the picture's cell; where they turn by more than 20
// degrees at once is a corner. Shades of grey are not in them. Some ten rays a point.
#pragma once

#include "core/render/beam_outline.h"

namespace flare {

// `beam` is what passes without the picture. Empty: no light passes, or the picture has no edges.
ApertureOutline FindMaskOutline(const Lens& lens, const LightBundle& bundle,
                                const CanonicalPose& pose, const StopPicture& picture,
                                const BeamOutline& beam, double wavelength_nm, ThreadPool& threads);

// Of all loops, holes subtracted.
double AreaOf(const ApertureOutline& outline);

}  // namespace flare
