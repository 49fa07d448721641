// SPDX-License-Identifier: Apache-2.0
//
// The members "lens" or "prescription", "coatings", "f_number", "focus_m" and "zoom_mm" of a
// message.
#pragma once

#include "protocol/codec/reader.h"
#include "protocol/wire/lens_choice.h"

namespace flare::wire {

// `lens_may_lack`: something else may name the lens.
bool ReadLensChoice(Reader& reader, const JsonView& root, LensChoice& choice,
                    bool lens_may_lack = false);

}  // namespace flare::wire
