// SPDX-License-Identifier: Apache-2.0
//
// The small grammar of HTTP and URLs that the routes need. ASCII only, whatever the locale.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace flare {

bool EqualIgnoringCase(std::string_view a, std::string_view b);
std::string_view TrimSpace(std::string_view text);  // spaces and tabs at both ends
std::vector<std::string_view> Split(std::string_view text, char separator);

// "%2F" to "/"; nullopt for a broken escape. "+" stays "+".
std::optional<std::string> DecodePercent(std::string_view text);

using Query = std::map<std::string, std::string>;

// "a=1&b=2". Each name once, each with a value. The error's `where` is "?name".
Result<Query> ParseQuery(std::string_view text);

// The whole text as one finite decimal number.
std::optional<double> ParseNumber(std::string_view text);

}  // namespace flare
