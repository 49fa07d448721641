// SPDX-License-Identifier: Apache-2.0
//
// `flare trace`: exact rays through one bounce sequence, JSON in and JSON out (docs/protocol.md).
#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"
#include "server/lens_library.h"

namespace flare {

// {"state","f_number","rays":[{"fate","sensor_mm",...}]}, one entry for each ray of `input` in its
// order. Errors are
// those of the codec, of the lens and, at "/sequence", of a bounce sequence that the lens cannot
// have.
Result<std::string> TraceJson(std::string_view input, const LensLibrary& library);

}  // namespace flare
