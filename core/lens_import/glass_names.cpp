// SPDX-License-Identifier: Apache-2.0
#include "core/lens_import/glass_names.h"

#include <algorithm>
#include <optional>

#include "core/lens_import/text_lines.h"
#include "core/optics/glass_catalogue.h"

namespace flare {

namespace {

std::string Squashed(std::string_view name) {
    std::string out = UpperCase(name);
    out.erase(std::remove_if(out.begin(), out.end(),
                             [](char c) { return c == '-' || c == ' ' || c == '_'; }),
              out.end());
    return out;
}

}  // namespace

Result<std::string> CatalogueName(std::string_view name, const std::vector<std::string>& makers) {
    const std::string wanted = Squashed(name);
    const std::vector<GlassEntry>& entries = BuiltInGlasses().entries();
    std::vector<const GlassEntry*> found;
    for (const GlassEntry& entry : entries) {
        if (Squashed(entry.name) == wanted) found.push_back(&entry);
    }
    for (const std::string& maker : makers) {
        for (const GlassEntry* entry : found) {
            if (entry->maker == UpperCase(maker)) return entry->full_name();
        }
    }
    if (found.size() == 1 && makers.empty()) return found.front()->full_name();
    std::string message = "the glass " + Quoted(name);
    if (!makers.empty()) {
        std::string asked;
        for (const std::string& maker : makers) asked += (asked.empty() ? "" : ", ") + maker;
        message += " is not in the catalogue of " + asked;
    } else if (found.empty()) {
        message += " is in no catalogue";
    }
    std::string others;
    for (const GlassEntry* entry : found) {
        others += (others.empty() ? "" : ", ") + entry->full_name();
    }
    if (!others.empty()) {
        message += makers.empty() ? " is made by several, and not the same: " : "; there are ";
        message += others;
    }
    return Error{found.size() > 1 ? "ambiguous_glass" : "unknown_glass", message, ""};
}

}  // namespace flare
