// SPDX-License-Identifier: Apache-2.0
#include "server/translate/document_from_json.h"

namespace flare {

DocumentNode DocumentFromJson(const wire::JsonTree& tree) {
    DocumentNode node;
    node.where = tree.pointer;
    if (const auto* truth = std::get_if<bool>(&tree.value)) {
        node.value = *truth;
    } else if (const auto* number = std::get_if<double>(&tree.value)) {
        node.value = *number;
    } else if (const auto* text = std::get_if<std::string>(&tree.value)) {
        node.value = *text;
    } else if (const auto* items = std::get_if<wire::JsonTree::Array>(&tree.value)) {
        DocumentNode::Array array;
        array.reserve(items->size());
        for (const wire::JsonTree& item : *items) array.push_back(DocumentFromJson(item));
        node.value = std::move(array);
    } else if (const auto* members = std::get_if<wire::JsonTree::Object>(&tree.value)) {
        DocumentNode::Table table;
        for (const auto& [name, member] : *members) table.emplace(name, DocumentFromJson(member));
        node.value = std::move(table);
    }
    return node;
}

}  // namespace flare
