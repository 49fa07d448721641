// SPDX-License-Identifier: Apache-2.0
#include "server/translate/lens_import_json.h"

#include <array>
#include <string>
#include <utility>

#include "protocol/codec/json_document.h"
#include "server/translate/document_from_json.h"

namespace flare {

namespace {

// Puts quotes around the words outside strings that JSON does not have, each as long as before, so
// that places in error messages stay true.
std::string WithoutPythonsNumbers(std::string_view text) {
    static constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kWords = {
        {{"-Infinity", "\"-infini\""}, {"Infinity", "\"infini\""}, {"NaN", "\"n\""}}};
    std::string out(text);
    bool in_string = false;
    for (std::size_t i = 0; i < out.size(); ++i) {
        if (in_string && out[i] == '\\') {
            ++i;
            continue;
        }
        if (out[i] == '"') in_string = !in_string;
        if (in_string) continue;
        for (const auto& [word, instead] : kWords) {
            if (out.compare(i, word.size(), word) != 0) continue;
            out.replace(i, word.size(), instead);
            i += word.size() - 1;
            break;
        }
    }
    return out;
}

Result<DocumentNode> ParseJson(std::string_view text) {
    const wire::Decoded<wire::JsonDocument> document =
        wire::JsonDocument::Parse(WithoutPythonsNumbers(text));
    if (const auto* refusal = std::get_if<wire::Refusal>(&document)) {
        return Error{refusal->code, refusal->message, refusal->where};
    }
    return DocumentFromJson(std::get_if<wire::JsonDocument>(&document)->root().Tree());
}

}  // namespace

Result<ImportedLens> ImportLensFile(std::string_view text, std::optional<LensFormat> format) {
    return ImportLens(text, format, ParseJson);
}

}  // namespace flare
