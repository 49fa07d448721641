// SPDX-License-Identifier: Apache-2.0
//
// Bytes as text (RFC 4648, section 4), with padding. Pure.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace flare::wire {

std::string Base64(std::string_view bytes);
// Empty if the text is anything but base64 in its one canonical form.
std::optional<std::string> BytesFromBase64(std::string_view text);

}  // namespace flare::wire
