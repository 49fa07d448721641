// SPDX-License-Identifier: Apache-2.0
//
// The importer of lenses with the JSON parser of the wire brought to it.
#pragma once

#include <optional>
#include <string_view>

#include "core/base/result.h"
#include "core/lens_import/lens_import.h"

namespace flare {

// As ImportLens. JSON is read as Python's json module writes it, with the bare words Infinity,
// -Infinity and NaN, which come out as texts and so as no numbers.
Result<ImportedLens> ImportLensFile(std::string_view text, std::optional<LensFormat> format);

}  // namespace flare
