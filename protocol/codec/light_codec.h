// SPDX-License-Identifier: Apache-2.0
//
// What several messages have in common besides the lens: the members "lights", "quality", "model"
// and bounce sequences.
#pragma once

#include <vector>

#include "protocol/codec/reader.h"
#include "protocol/wire/flare_request.h"

namespace flare::wire {

// `spectral`: irradiances may be one number.
bool ReadLights(Reader& reader, const JsonView& at, bool spectral, std::vector<Light>& lights);
// Any surface numbers; whether there is such a path is for the lens to say.
bool ReadSequence(Reader& reader, const JsonView& at, std::vector<int>& sequence);
bool ReadQuality(Reader& reader, const JsonView& at, Quality& quality);
bool ReadModel(Reader& reader, const JsonView& at, Model& model);

}  // namespace flare::wire
