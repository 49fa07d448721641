// SPDX-License-Identifier: Apache-2.0
//
// Which ghosts of a light need not be drawn. A ghost is left out for the light that it puts on the
// frame, not for its size or path: if it is among the faintest, which together hold no more than a
// set share of the frame's light, and is nowhere bright enough to be seen. A ghost near either
// limit is drawn with a weight between 0 and 1, continuous in what the samples say, so that nothing
// pops as a light or the iris moves; the light of what is left out or dimmed is added up.
//
// The rules of older renderers, which lose much more, exist for comparison: docs/accuracy.md.
#pragma once

#include <vector>

#include "core/render/flare_request.h"
#include "core/render/ghost_sample.h"

namespace flare {

struct CullLimits {
    double lost_share = 0.0;  // of the light on the frame that may be lost; 0: nothing is culled
    double peak = 0.0;        // weighted irradiance below which a ghost is not seen
};

// A weight for each ghost: 0 left out, 1 drawn as it is.
std::vector<double> CullByLight(const std::vector<GhostSample>& samples, const CullLimits& limits);

// Drops a ghost that crosses the stop three times, and one whose box is larger than half the frame;
// of the two rules those that `rule` names.
std::vector<double> CullByOldRules(const std::vector<GhostSample>& samples,
                                   const std::vector<int>& stop_crossings, double frame_px2,
                                   CullingRule rule = CullingRule::kReport);

}  // namespace flare
