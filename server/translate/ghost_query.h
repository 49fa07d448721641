// SPDX-License-Identifier: Apache-2.0
//
// What a ghost list is asked for, by `flare ghosts` and GET /v1/lenses/NAME/ghosts alike.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/optics/lens_state.h"
#include "core/render/ghost_list.h"
#include "protocol/wire/lens_choice.h"

namespace flare {

struct GhostQuery {
    LensState state;
    wire::Coatings coatings;
    double field_deg = 0.0;  // -180..180; below 0: the light comes from the other side
    double azimuth_deg = 0.0;
    std::optional<double> f_number;       // absent: wide open
    std::optional<double> wavelength_nm;  // absent: the d line
    ModelSpec model;
};

struct RankedGhosts {
    LensInState lens;
    GhostList list;
};

// `base` as the library has it. An error's `where` is the name of the parameter: "coatings",
// "sensor_reflection", ...; or "" with code "bad_lens" where the lens cannot be set so.
Result<RankedGhosts> RankGhostsFor(const std::shared_ptr<const Lens>& base, const GhostQuery& query,
                                   const RenderContext& context);

// GET /v1/lenses/NAME/ghosts and `flare ghosts NAME --json`.
std::string GhostListJson(const RankedGhosts& ghosts, const GhostQuery& query);

}  // namespace flare
