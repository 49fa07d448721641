// SPDX-License-Identifier: Apache-2.0
//
// What the lens routes answer, as JSON text. Errors are those of the library and of the ghost list.
#pragma once

#include <string>

#include "core/base/result.h"
#include "server/lens_library.h"
#include "server/service.h"
#include "server/translate/ghost_query.h"

namespace flare {

Result<std::string> ServeLens(const std::string& name, const LensState& state,
                              const LensLibrary& lenses);

Result<std::string> ServeGhosts(const std::string& name, const GhostQuery& query,
                                const ServiceContext& context);

}  // namespace flare
