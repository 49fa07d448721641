// SPDX-License-Identifier: Apache-2.0
//
// The names under which other programs know the glasses of the catalogue: without hyphens and
// blanks ("NBK7"), with the maker behind an underscore ("NBK7_SCHOTT") or in a list of their own.
// Private to this layer.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace flare {

// "MAKER NAME" of the glass of that name, hyphens and blanks aside. `makers` are asked in their
// order; empty: every maker, and then the name must be one maker's only. Errors: "unknown_glass"
// and "ambiguous_glass".
Result<std::string> CatalogueName(std::string_view name, const std::vector<std::string>& makers);

}  // namespace flare
