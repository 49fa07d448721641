// SPDX-License-Identifier: Apache-2.0
//
// The body of POST /v1/warm as text to plain values and nothing else: no lens is looked up here.
#pragma once

#include <string_view>

#include "protocol/wire/refusal.h"
#include "protocol/wire/warm_request.h"

namespace flare::wire {

// As strict as DecodeFlareRequest, with the same codes.
Decoded<WarmRequest> DecodeWarmRequest(std::string_view body);

}  // namespace flare::wire
