// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/document.h"
#include "protocol/wire/json_tree.h"

namespace flare {

// The same tree with JSON pointers as places, so that one reader takes lens files and inline
// prescriptions alike.
DocumentNode DocumentFromJson(const wire::JsonTree& tree);

}  // namespace flare
