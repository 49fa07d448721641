// SPDX-License-Identifier: Apache-2.0
//
// The members "lens" or "prescription", "coatings", "f_number", "focus_m" and "zoom_mm" of a
// message.
#pragma once

#include "protocol/codec/reader.h"
#include "protocol/wire/lens_choice.h"

namespace flare::wire {

bool ReadLensChoice(Reader& reader, const JsonView& root, LensChoice& choice);

}  // namespace flare::wire
