// SPDX-License-Identifier: Apache-2.0
//
// What the lens routes and `flare lens|ghosts --json` print: JSON texts (ASCII, two-space indent,
// one newline at the end). Numbers are written so that reading them gives the same double. Lengths
// are mm, every z is from vertex 0 unless its name says otherwise.
#pragma once

#include <string>

#include "core/base/result.h"
#include "core/optics/lens.h"
#include "core/render/ghost_list.h"
#include "server/lens_library.h"

namespace flare {

// GET /v1/lenses/NAME and, with the field data, whose rays take 0.2 s and more, `flare lens show
// NAME
// --json`.
std::string LensJson(const Lens& lens, bool with_field = false);

// GET /v1/lenses and `flare lens list --json`: {"lenses":[{name, efl_mm, f_number, ...}],
// "broken":[{name, error}]}.
std::string LensListJson(const LensLibrary& library);

// GET /v1/lenses/NAME/ghosts and `flare ghosts NAME --json`. `options` are those the list was made
// with; `bare_glass` says whether coatings were left out.
std::string GhostListJson(const Lens& lens, const GhostList& list, const GhostListOptions& options,
                          bool bare_glass);

// The body of every refusal: {"error":{"code","message","where"}}.
std::string ErrorJson(const Error& error);

}  // namespace flare
