// SPDX-License-Identifier: Apache-2.0
//
// Members of a JSON object with their places. Private to this layer.
#pragma once

#include <optional>
#include <string>

#include "core/base/document.h"
#include "core/base/result.h"

namespace flare {

// Null where there is none.
const DocumentNode* Member(const DocumentNode& node, const std::string& key);
// An error unless the member is there and a finite number.
Result<double> NumberMember(const DocumentNode& node, const std::string& key);
// Absent where the member is missing, null or something else.
std::optional<double> OptionalNumber(const DocumentNode& node, const std::string& key);
std::string TextMember(const DocumentNode& node, const std::string& key);
// An error unless the member is there and an array of 1 to 100 tables.
Result<const DocumentNode::Array*> SurfaceArray(const DocumentNode& node, const std::string& key);

}  // namespace flare
