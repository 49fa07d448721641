// SPDX-License-Identifier: Apache-2.0
#include "core/prescription/toml_document.h"

#include <string>
#include <utility>

// toml++ 3.3 asserts (or, with NDEBUG and clang, assumes) what an outside text can break, as "[}]"
// does, and then handles the case properly a few lines on. So its assertions are turned off
// whatever NDEBUG says; the reader's tests and fuzzing under the sanitizers stand in for them.
#define TOML_EXCEPTIONS 0
#define TOML_ASSERT(expression) static_cast<void>(0)
#pragma push_macro("NDEBUG")
#undef NDEBUG
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

namespace flare {

namespace {

std::string PlaceText(const toml::source_position& place) {
    return "line " + std::to_string(place.line) + ", column " + std::to_string(place.column);
}

DocumentNode FromToml(const toml::node& node, const std::string& place_if_none) {
    DocumentNode out;
    const toml::source_position place = node.source().begin;
    out.where = place.line > 0 ? PlaceText(place) : place_if_none;
    if (const toml::table* table = node.as_table()) {
        DocumentNode::Table children;
        for (const auto& [key, child] : *table) {
            const toml::source_position key_place = key.source().begin;
            children.emplace(
                std::string(key.str()),
                FromToml(child, key_place.line > 0 ? PlaceText(key_place) : out.where));
        }
        out.value = std::move(children);
    } else if (const toml::array* array = node.as_array()) {
        DocumentNode::Array children;
        for (const toml::node& child : *array) children.push_back(FromToml(child, out.where));
        out.value = std::move(children);
    } else if (const auto* text = node.as_string()) {
        out.value = text->get();
    } else if (const auto* real = node.as_floating_point()) {
        out.value = real->get();
    } else if (const auto* integer = node.as_integer()) {
        out.value = static_cast<double>(integer->get());
    } else if (const auto* boolean = node.as_boolean()) {
        out.value = boolean->get();
    }  // else a date or a time: no key of a lens file takes one
    return out;
}

}  // namespace

Result<DocumentNode> ParseToml(std::string_view text, const char* error_code) {
    const toml::parse_result parsed = toml::parse(text);
    if (!parsed) {
        return Error{error_code, "not TOML: " + std::string(parsed.error().description()),
                     PlaceText(parsed.error().source().begin)};
    }
    return FromToml(parsed.table(), "line 1, column 1");
}

}  // namespace flare
