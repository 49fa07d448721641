// SPDX-License-Identifier: Apache-2.0
//
// The OpenAPI 3.1 document of the service (protocol/openapi.yaml), put into the program at build
// time, so that a daemon serves exactly the document it was built with.
#pragma once

#include <string_view>

namespace flare {

// The whole YAML text.
std::string_view OpenApiDocument();

}  // namespace flare
