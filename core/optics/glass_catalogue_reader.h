// SPDX-License-Identifier: Apache-2.0
//
// Reads one line of a glass catalogue (lenses/glass/README.md has the format). Private to
// glass_catalogue.cpp.
#pragma once

#include <string_view>

#include "core/base/result.h"
#include "core/optics/glass_catalogue.h"

namespace flare {

inline constexpr std::string_view kGlassColumns =
    "maker\tglass\tformula\trange_um\tcoefficients\tnd\tVd\tcode\tstatus\tk";

// `line` without its line end. Fails with code "bad_catalogue" and no place.
Result<GlassEntry> ReadGlassLine(std::string_view line);

}  // namespace flare
