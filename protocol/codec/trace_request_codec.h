// SPDX-License-Identifier: Apache-2.0
//
// The input of `flare trace`: strict JSON to plain values.
#pragma once

#include <string_view>

#include "protocol/wire/refusal.h"
#include "protocol/wire/trace_request.h"

namespace flare::wire {

// Refusal codes as in flare_request_codec.h.
Decoded<TraceRequest> DecodeTraceRequest(std::string_view body);

}  // namespace flare::wire
