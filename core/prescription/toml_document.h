// SPDX-License-Identifier: Apache-2.0
//
// The text of a TOML file as a DocumentNode tree, each node with its place ("line 4, column 9"), so
// that one reader serves files and parts of a request alike.
#pragma once

#include <string_view>

#include "core/base/document.h"
#include "core/base/result.h"

namespace flare {

// A syntax error has the given code; its `where` is "line L, column C".
Result<DocumentNode> ParseToml(std::string_view text, const char* error_code);

}  // namespace flare
