// SPDX-License-Identifier: Apache-2.0
//
// Reads coatings that are given layer by layer (lenses/FORMAT.md): in a lens file under
// [coatings.NAME], in a request, or alone in a file. Layers are listed from the low-index side. A
// thickness below 0, n of 0, a material that is not known, more than 100 layers and the like are
// errors of code "bad_lens" with their place.
#pragma once

#include <string>
#include <string_view>

#include "core/base/document.h"
#include "core/base/result.h"
#include "core/optics/coating_design.h"

namespace flare {

inline constexpr int kMaxCoatingDefinitions = 100;

// The table of one coating: `layers`, `notes`, `source`.
Result<CoatingDesign> ReadCoating(const DocumentNode& node, const std::string& name);

// A file of its own: the same and `name`. `where` is "line L, column C".
Result<CoatingDesign> ReadCoatingToml(std::string_view text);

// A table of coatings by name.
Result<CoatingDefinitions> ReadCoatingDefinitions(const DocumentNode& node);

}  // namespace flare
