// SPDX-License-Identifier: Apache-2.0
//
// How much memory a flare request takes while it is rendered: what admission reckons with.
#pragma once

#include <cstdint>
#include <string_view>

#include "protocol/wire/flare_request.h"

namespace flare {

// An upper estimate in bytes, from the size of the picture and the number of its channels.
std::uint64_t PictureBytes(const wire::FlareRequest& request);

// The same for a body; 0 if it does not decode.
std::uint64_t PictureBytesOfBody(std::string_view body);

}  // namespace flare
