// SPDX-License-Identifier: Apache-2.0
//
// What pictures and warming have in common besides the lens: the members "lights", "quality" and
// "model" of a message.
#pragma once

#include <vector>

#include "protocol/codec/reader.h"
#include "protocol/wire/flare_request.h"

namespace flare::wire {

// `spectral`: irradiances may be one number. `points`: only lights without extent are supported.
bool ReadLights(Reader& reader, const JsonView& at, bool spectral, bool points,
                std::vector<Light>& lights);
bool ReadQuality(Reader& reader, const JsonView& at, Quality& quality);
bool ReadModel(Reader& reader, const JsonView& at, Model& model);

}  // namespace flare::wire
