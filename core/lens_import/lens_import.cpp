// SPDX-License-Identifier: Apache-2.0
//
// A format is recognised by what only its files have: a root element, a member, a keyword that
// begins a line. Tables have nothing of the kind and are what is left if the first line that is no
// comment is numbers.
#include "core/lens_import/lens_import.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/lens_import/format_readers.h"
#include "core/lens_import/json_members.h"
#include "core/lens_import/lens_draft.h"
#include "core/lens_import/text_lines.h"

namespace flare {

namespace {

constexpr std::array<std::string_view, 10> kNames = {
    "zemax",         "codev",     "pbrt",   "table",    "flaresim",
    "openlensflare", "realflare", "lentil", "optiland", "rayoptics"};

// How far into a text the marks of a format are sought.
constexpr std::size_t kMaxSniffedLines = 400;

bool IsJson(LensFormat format) {
    return format == LensFormat::kRealflare || format == LensFormat::kLentil ||
           format == LensFormat::kOptiland || format == LensFormat::kRayOptics;
}

std::optional<LensFormat> JsonFormat(const DocumentNode& root) {
    if (Member(root, "lens_elements") != nullptr) return LensFormat::kRealflare;
    if (Member(root, "optical-elements-patent") != nullptr) return LensFormat::kLentil;
    if (Member(root, "surface_group") != nullptr) return LensFormat::kOptiland;
    if (Member(root, "optical_model") != nullptr) return LensFormat::kRayOptics;
    return std::nullopt;
}

bool IsComment(std::string_view line) {
    return line.front() == '#' || line.front() == '!' || line.substr(0, 2) == "//";
}

std::optional<LensFormat> TextFormat(std::string_view text) {
    std::vector<TextLine> lines = LinesOf(text);
    lines.resize(std::min(lines.size(), kMaxSniffedLines));
    if (!lines.empty() && lines.front().text.front() == '<') return LensFormat::kOpenLensFlare;
    std::optional<std::size_t> columns;
    for (const TextLine& line : lines) {
        if (IsComment(line.text)) continue;
        const std::vector<std::string_view> words = WordsOf(line.text, ",;|");
        if (words.empty()) continue;
        const std::string first = UpperCase(words.front());
        if (first == "SURF" && words.size() == 2) return LensFormat::kZemax;
        if (first == "SURFACES:") return LensFormat::kFlareSim;
        if ((first == "SO" || first == "S") && words.size() >= 3) return LensFormat::kCodeV;
        if (!columns && NumberIn(words.front()) && words.size() >= 4) columns = words.size();
    }
    if (!columns) return std::nullopt;
    return *columns == 4 ? LensFormat::kPbrt : LensFormat::kTable;
}

void AppendUtf8(std::string& out, unsigned unit) {
    if (unit < 0x80) {
        out += static_cast<char>(unit);
    } else if (unit < 0x800) {
        out += static_cast<char>(0xC0 | (unit >> 6));
        out += static_cast<char>(0x80 | (unit & 0x3F));
    } else {
        out += static_cast<char>(0xE0 | (unit >> 12));
        out += static_cast<char>(0x80 | ((unit >> 6) & 0x3F));
        out += static_cast<char>(0x80 | (unit & 0x3F));
    }
}

// Zemax writes UTF-16 as a rule. Only Latin letters matter here, so surrogates stay as they are.
std::string Utf8From(std::string_view text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const bool little = text.size() >= 2 && byte(0) == 0xFF && byte(1) == 0xFE;
    const bool big = text.size() >= 2 && byte(0) == 0xFE && byte(1) == 0xFF;
    if (!little && !big) {
        return std::string(text.substr(0, 3) == "\xEF\xBB\xBF" ? text.substr(3) : text);
    }
    std::string out;
    for (std::size_t i = 2; i + 1 < text.size(); i += 2) {
        AppendUtf8(out, little ? byte(i) | byte(i + 1) * 256u : byte(i) * 256u | byte(i + 1));
    }
    return out;
}

Error UnknownFormat() {
    std::string list;
    for (const std::string_view name : kNames)
        list += (list.empty() ? "" : ", ") + std::string(name);
    return {"unknown_format", "the content is that of none of the formats " + list, ""};
}

Result<LensDraft> ReadJson(const std::string& text, std::optional<LensFormat>& format,
                           const JsonParser& parse_json) {
    const Result<DocumentNode> root = parse_json(text);
    if (!root) return root.error();
    if (!format) format = JsonFormat(*root);
    if (!format) return UnknownFormat();
    switch (*format) {
        case LensFormat::kRealflare:
            return ReadRealflare(*root);
        case LensFormat::kLentil:
            return ReadLentil(*root);
        case LensFormat::kOptiland:
            return ReadOptiland(*root);
        default:
            return ReadRayOptics(*root);
    }
}

Result<LensDraft> ReadText(const std::string& text, LensFormat format) {
    switch (format) {
        case LensFormat::kZemax:
            return ReadZemax(text);
        case LensFormat::kCodeV:
            return ReadCodeV(text);
        case LensFormat::kFlareSim:
            return ReadFlareSim(text);
        case LensFormat::kOpenLensFlare:
            return ReadOpenLensFlare(text);
        default:
            return ReadTable(text);
    }
}

}  // namespace

std::string_view FormatName(LensFormat format) {
    return kNames[static_cast<std::size_t>(format)];
}

std::optional<LensFormat> FormatByName(std::string_view name) {
    const auto found = std::find(kNames.begin(), kNames.end(), name);
    if (found == kNames.end()) return std::nullopt;
    return static_cast<LensFormat>(found - kNames.begin());
}

const std::vector<std::string>& FormatNames() {
    static const std::vector<std::string> names(kNames.begin(), kNames.end());
    return names;
}

Result<ImportedLens> ImportLens(std::string_view bytes, std::optional<LensFormat> format,
                                const JsonParser& parse_json) {
    if (bytes.size() > kMaxImportBytes) {
        return Error{"bad_lens",
                     "the file has " + std::to_string(bytes.size()) + " bytes; the limit is " +
                         std::to_string(kMaxImportBytes),
                     ""};
    }
    const std::string text = Utf8From(bytes);
    if (text.find('\0') != std::string::npos) {
        return Error{"bad_lens", "the file is binary", ""};
    }
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    if (first == std::string::npos) return Error{"bad_lens", "the file is empty", ""};
    const bool json = format ? IsJson(*format) : text[first] == '{';
    if (!json && !format) {
        format = TextFormat(text);
        if (!format) return UnknownFormat();
    }
    Result<LensDraft> draft = json ? ReadJson(text, format, parse_json) : ReadText(text, *format);
    if (!draft) return draft.error();
    return FinishDraft(std::move(*draft), *format);
}

}  // namespace flare
