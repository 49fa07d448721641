// SPDX-License-Identifier: Apache-2.0
#include "core/lens_import/json_members.h"

#include <cmath>

#include "core/optics/prescription_faults.h"

namespace flare {

const DocumentNode* Member(const DocumentNode& node, const std::string& key) {
    if (node.table() == nullptr) return nullptr;
    const auto found = node.table()->find(key);
    return found == node.table()->end() ? nullptr : &found->second;
}

Result<double> NumberMember(const DocumentNode& node, const std::string& key) {
    const DocumentNode* member = Member(node, key);
    if (member == nullptr) return Error{"bad_lens", "there is no \"" + key + "\" here", node.where};
    if (member->number() == nullptr || !std::isfinite(*member->number())) {
        return Error{"bad_lens", "\"" + key + "\" is no finite number", member->where};
    }
    return *member->number();
}

std::optional<double> OptionalNumber(const DocumentNode& node, const std::string& key) {
    const DocumentNode* member = Member(node, key);
    if (member == nullptr || member->number() == nullptr || !std::isfinite(*member->number())) {
        return std::nullopt;
    }
    return *member->number();
}

std::string TextMember(const DocumentNode& node, const std::string& key) {
    const DocumentNode* member = Member(node, key);
    return member == nullptr || member->string() == nullptr ? "" : *member->string();
}

Result<const DocumentNode::Array*> SurfaceArray(const DocumentNode& node, const std::string& key) {
    const DocumentNode* member = Member(node, key);
    if (member == nullptr) return Error{"bad_lens", "there is no \"" + key + "\" here", node.where};
    const DocumentNode::Array* rows = member->array();
    if (rows == nullptr || rows->empty() || rows->size() > static_cast<std::size_t>(kMaxSurfaces)) {
        return Error{
            "bad_lens",
            "\"" + key + "\" must be an array of 1 to " + std::to_string(kMaxSurfaces) + " tables",
            member->where};
    }
    for (const DocumentNode& row : *rows) {
        if (row.table() == nullptr) {
            return Error{"bad_lens", "this surface is no table", row.where};
        }
    }
    return rows;
}

}  // namespace flare
