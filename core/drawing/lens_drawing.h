// SPDX-License-Identifier: Apache-2.0
//
// A lens drawn to scale as SVG: the glass by its index, stop, pupils and sensor, the rays that form
// the image and the paths of ghosts, all of them exact rays; docs/drawing.md. One section, y-z, for
// a rotational lens, both for an anamorphic one. The shapes stand in groups whose coordinates are
// mm of lens space, (z, x or y), upright.
//
// A pure function: the same lens and options give the same bytes. Costs some ten thousand traced
// rays a section.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/optics/lens_state.h"
#include "core/tracing/bounce_sequence.h"

namespace flare {

inline constexpr std::size_t kMostDrawnGhosts = 4;

struct DrawingOptions {
    std::vector<BounceSequence> ghosts;  // two or more reflections each; each gets a colour
    // Of the light of the field beam and the ghosts; positive: above the axis. Absent: the field
    // beam goes to 0.7 of the image circle's radius if the file states one, and the ghosts, without
    // a field beam, are those of a light on the axis.
    std::optional<double> field_deg;
    std::optional<double> f_number;  // absent: wide open; clamped as StopForFNumber does
    LensState state;                 // that the lens has been set to, for the title
};

// Fails with "bad_value": `where` is "/ghosts/K", "/ghosts", "/field_deg" or "/f_number".
Result<std::string> DrawLens(const Lens& lens, const DrawingOptions& options);

}  // namespace flare
