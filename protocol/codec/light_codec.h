// SPDX-License-Identifier: Apache-2.0
//
// What pictures and warming have in common besides the lens: the members "lights", "quality" and
// "model" of a message.
#pragma once

#include <vector>

#include "protocol/codec/reader.h"
#include "protocol/wire/flare_request.h"

namespace flare::wire {

// `spectral`: irradiances may be one number.
bool ReadLights(Reader& reader, const JsonView& at, bool spectral, std::vector<Light>& lights);
bool ReadQuality(Reader& reader, const JsonView& at, Preset& preset);
bool ReadModel(Reader& reader, const JsonView& at, Model& model);

}  // namespace flare::wire
