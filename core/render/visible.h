// SPDX-License-Identifier: Apache-2.0
//
// What need not be drawn because nobody can see it: the request's `visible` names an exposure and a
// noise floor, and all that is left out or simplified together changes no pixel of a layer, nor of
// their sum, by as much as the floor. docs/visible.md.
//
// The bound of a ghost is the largest irradiance that its sample found (ghost_sample.h), raised for
// what a sample may miss and for fringes. A picture of it, however crude, lies between nothing and
// that, so leaving it out changes a pixel by no more, and neither does drawing it without colour
// fringes, diffraction or blur. The floor is shared out: part for ghosts left out, part for details
// of others, part for the starburst's tails; and evenly among the lights. In each part the faintest
// go first, until their bounds add up to it: so it holds where all ghosts overlap.
#pragma once

#include <vector>

#include "core/render/ghost_plan.h"

namespace flare {

// Of the floor; the three add up to one.
inline constexpr double kUnseenGhosts = 0.5, kUnseenDetails = 0.25, kUnseenTails = 0.25;
// How much brighter than its sample a ghost may be, at focused ghosts: measured up to 26
// (docs/visible.md). And how much more light than sampled it may put into one pixel.
inline constexpr double kPeakDoubt = 64.0, kLightDoubt = 1.5;
// What fringes may add where they are brightest: a straight edge 1.37 times, corners and narrow
// apertures more.
inline constexpr double kFringePeak = 2.0;

// Marks ghosts of plan.drawn as unseen or plain, and adds up what that leaves out. `sequences` are
// those that the plan's indices count.
void LeaveOutUnseen(const FlareRequest& request, const PlacedLight& light, double scene_factor,
                    const std::vector<BounceSequence>& sequences, GhostPlan& plan);

// Adds one light's to the sums.
void AddUnseen(const VisibleFacts& one, VisibleFacts& all);

}  // namespace flare
