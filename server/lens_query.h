// SPDX-License-Identifier: Apache-2.0
//
// The queries of GET /v1/lenses/NAME and GET /v1/lenses/NAME/ghosts.
#pragma once

#include <string_view>

#include "core/base/result.h"
#include "server/translate/ghost_query.h"

namespace flare {

// Strict: an unknown, repeated or senseless parameter is an error whose `where` is "?name".
Result<LensState> ParseLensQuery(std::string_view query);
Result<GhostQuery> ParseGhostQuery(std::string_view query);

}  // namespace flare
