// SPDX-License-Identifier: Apache-2.0
//
// The body of POST /v1/warm in the core's words: a request whose lights are those to have meshes
// for, and whose picture nobody draws.
#pragma once

#include <string_view>

#include "core/base/result.h"
#include "core/render/flare_request.h"
#include "server/lens_library.h"

namespace flare {

// Errors are those of the codec, of the lens and of the values (CheckRequest).
Result<FlareRequest> WarmFromWire(std::string_view body, const LensLibrary& library);

}  // namespace flare
