// SPDX-License-Identifier: Apache-2.0
//
// The query of GET /v1/lenses/NAME/ghosts.
#pragma once

#include <optional>
#include <string_view>

#include "core/base/result.h"

namespace flare {

struct GhostQuery {
    double field_deg = 0.0;
    std::optional<double> f_number;       // absent: wide open
    std::optional<double> wavelength_nm;  // absent: the d line
    bool bare_glass = false;              // coatings=none
};

// Strict: an unknown, repeated or senseless parameter is an error whose `where` is "?name".
Result<GhostQuery> ParseGhostQuery(std::string_view query);

}  // namespace flare
