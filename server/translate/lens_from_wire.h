// SPDX-License-Identifier: Apache-2.0
//
// The lens of a message: looked up or built, coated as asked, zoomed and focused.
#pragma once

#include <memory>

#include "core/base/result.h"
#include "core/optics/lens_state.h"
#include "protocol/wire/lens_choice.h"
#include "server/lens_library.h"

namespace flare {

// Errors stand at "/lens" or inside "/prescription" or "/coatings". A state outside the lens's
// range is no error: `clamped` says what was set instead.
Result<LensInState> LensFromWire(const wire::LensChoice& choice, const LensLibrary& library);

// The same for a lens that is there already, as Lens::Build made it.
Result<LensInState> LensAsAsked(const std::shared_ptr<const Lens>& base,
                                const wire::Coatings& coatings, const LensState& state);

}  // namespace flare
