// SPDX-License-Identifier: Apache-2.0
//
// What the lens routes and `flare lens --json` print: JSON texts (ASCII, two-space indent,
// one newline at the end). Numbers are written so that reading them gives the same double. Lengths
// are mm, every z is from vertex 0 unless its name says otherwise.
#pragma once

#include <string>

#include "core/base/result.h"
#include "core/optics/lens_state.h"
#include "server/lens_library.h"

namespace flare {

// GET /v1/lenses/NAME and `flare lens show NAME --json`: the lens `shown`, which is `file`, the
// lens as its file has it, in some state. Focal length, pupils and the like are those of the
// section that the design speaks of; an anamorphic lens has both as "x" and "y". The rays of the
// field data take 0.1 s and more.
std::string LensJson(const Lens& file, const LensInState& shown, bool with_field);

// GET /v1/lenses and `flare lens list --json`: {"lenses":[{name, efl_mm, f_number, ...}],
// "broken":[{name, error}]}.
std::string LensListJson(const LensLibrary& library);

// The body of every refusal: {"error":{"code","message","where"}}.
std::string ErrorJson(const Error& error);

}  // namespace flare
