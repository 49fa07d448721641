// SPDX-License-Identifier: Apache-2.0
//
// Which form of the picture a client wants, and whether its body is JSON.
#pragma once

#include <optional>
#include <string_view>

#include "server/service.h"

namespace flare {

inline constexpr std::string_view kPictureTypes =
    "image/x-exr, image/png, application/x-flare-half";

// The form that an Accept field prefers; the first of kPictureTypes among equals, and where there
// is no field. nullopt if it wants none of them.
std::optional<ReplyFormat> FormatForAccept(std::optional<std::string_view> accept);

// "application/json", perhaps with charset=utf-8; an absent Content-Type passes for it.
bool IsJson(std::optional<std::string_view> content_type);

}  // namespace flare
