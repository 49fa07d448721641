// SPDX-License-Identifier: Apache-2.0
//
// One function for each format. Private to this layer; see lens_import.h.
#pragma once

#include <string_view>

#include "core/base/document.h"
#include "core/base/result.h"
#include "core/lens_import/lens_draft.h"

namespace flare {

Result<LensDraft> ReadZemax(std::string_view text);
Result<LensDraft> ReadCodeV(std::string_view text);
// PBRT and plain tables: the columns are found by their number or the line that names them.
Result<LensDraft> ReadTable(std::string_view text);
Result<LensDraft> ReadFlareSim(std::string_view text);
Result<LensDraft> ReadOpenLensFlare(std::string_view text);
Result<LensDraft> ReadRealflare(const DocumentNode& root);
Result<LensDraft> ReadLentil(const DocumentNode& root);
Result<LensDraft> ReadOptiland(const DocumentNode& root);
Result<LensDraft> ReadRayOptics(const DocumentNode& root);

}  // namespace flare
