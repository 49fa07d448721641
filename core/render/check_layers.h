// SPDX-License-Identifier: Apache-2.0
//
// What a request says of its layers: splitting them, and an artist's hand on single ghosts.
#pragma once

#include <optional>

#include "core/base/result.h"
#include "core/render/flare_request.h"

namespace flare {

// The empty optional says that both are sound; the request has a lens. Errors name the field.
std::optional<Error> CheckLayers(const FlareRequest& request);

}  // namespace flare
