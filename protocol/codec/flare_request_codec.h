// SPDX-License-Identifier: Apache-2.0
//
// The body of POST /v1/flare as text to plain values and nothing else: no lens is looked up here.
#pragma once

#include <string_view>

#include "protocol/wire/flare_request.h"
#include "protocol/wire/refusal.h"

namespace flare::wire {

// Strict (json_document.h); defaults are filled in, limits are checked. Refusal codes: "too_large",
// "bad_json", "duplicate_key", "unknown_field", "missing_field", "bad_type", "bad_value", "limit",
// "unsupported". Never throws, except for want of memory.
Decoded<FlareRequest> DecodeFlareRequest(std::string_view body);

}  // namespace flare::wire
