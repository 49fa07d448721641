// SPDX-License-Identifier: Apache-2.0
//
// Reads lenses that other programs wrote into prescriptions. Which format a text has is seen from
// its content. What a file says and a prescription cannot hold, and every guess that had to be
// made, is listed in `remarks`; what would change the lens (a mirror, a tilt, a glass nobody knows)
// is an error instead. Numbers are taken as they stand: whether they make a lens is for the lint
// (prescription_check.h). What each format means is in docs/importing.md.
//
// Texts are at most kMaxImportBytes and 100 surfaces long. No function here throws or recurses on
// the text. JSON is parsed by a function that the caller brings; XML by pugixml, without entities
// from outside.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/document.h"
#include "core/base/result.h"
#include "core/optics/prescription.h"

namespace flare {

enum class LensFormat {
    kZemax,          // .zmx, sequential
    kCodeV,          // .seq
    kPbrt,           // .dat: radius, gap, index, aperture
    kTable,          // columns named by a line above them
    kFlareSim,       // .lens
    kOpenLensFlare,  // XML
    kRealflare,      // JSON
    kLentil,         // JSON
    kOptiland,       // JSON
    kRayOptics,      // .roa, JSON
};

inline constexpr std::size_t kMaxImportBytes = std::size_t{4} << 20;

// "zemax", "codev", "pbrt", "table", "flaresim", "openlensflare", "realflare", "lentil",
// "optiland", "rayoptics".
std::string_view FormatName(LensFormat format);
std::optional<LensFormat> FormatByName(std::string_view name);
// All names, in the order above.
const std::vector<std::string>& FormatNames();

struct ImportedLens {
    LensFormat format = LensFormat::kTable;
    Prescription prescription;         // its `notes` hold the remarks too
    std::vector<std::string> remarks;  // whole sentences, for people
};

using JsonParser = std::function<Result<DocumentNode>(std::string_view)>;

// `format` absent: seen from the content. Errors have the code "bad_lens", "unknown_format",
// "unsupported" (mirrors, tilts, thin lenses, ...) or that of the JSON parser; `where` is "line L"
// or a JSON pointer.
Result<ImportedLens> ImportLens(std::string_view text, std::optional<LensFormat> format,
                                const JsonParser& parse_json);

}  // namespace flare
