// SPDX-License-Identifier: Apache-2.0
//
// Finds the tolerance (quality.h) for a request that names an error or a time instead.
//
// max_error: the scene is surveyed first: every ghost is sampled and located on its mesh, which
// rendering needs anyway, and from that the estimate (error_estimate.h) at any tolerance follows
// without drawing. The coarsest whose estimate is kErrorMargin of the error is drawn; should its
// own estimate be larger after all, a finer one is. Depends on the request alone, so equal requests
// give equal bytes.
//
// time_budget_ms: the coarsest plan is drawn first, so that there is a picture; how long it took
// says what finer ones may take, and the finest that should fit is drawn next, then once more from
// two times. A plan that overruns is called off and the last finished picture is the answer. The
// plan depends on the machine; asked for by its tolerance, it gives the same bytes again.
#pragma once

#include <functional>

#include "core/render/renderer.h"

namespace flare {

// Of max_error, what the estimate may be: 97 of 100 measured errors were within 1.18 of theirs,
// most of them half (docs/accuracy.md).
inline constexpr double kErrorMargin = 0.85;

// Draws a request whose quality is a plan.
using PlanRenderer = std::function<Result<Rendering>(const FlareRequest&, const RenderContext&)>;

// The request's max_error or time_budget_ms decides; times are those of rendering alone, by the
// context's clock. Errors: the renderer's.
Result<Rendering> RenderSearched(const FlareRequest& request, const RenderContext& context,
                                 const PlanRenderer& render);

}  // namespace flare
