// SPDX-License-Identifier: Apache-2.0
//
// Reads a lens file. The text is TOML (lenses/FORMAT.md); the same tree may come from JSON (an
// inline prescription in a request). Unknown keys, wrong types, NaN, infinities and kinds of
// surface that are not built yet are errors that name the place.
#pragma once

#include <cstddef>
#include <string_view>

#include "core/base/document.h"
#include "core/base/result.h"
#include "core/optics/prescription.h"
#include "core/optics/prescription_faults.h"  // kMaxSurfaces

namespace flare {

// A longer text is refused unread.
inline constexpr std::size_t kMaxLensFileBytes = std::size_t{1} << 20;

// Error code "bad_lens" ("unsupported" for parts of the format that a later version reads); `where`
// is "line L, column C".
Result<Prescription> ReadPrescriptionToml(std::string_view text);

// The same from a parsed tree, whose nodes carry their own places.
Result<Prescription> ReadPrescription(const DocumentNode& root);

}  // namespace flare
