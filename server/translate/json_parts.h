// SPDX-License-Identifier: Apache-2.0
//
// Parts that several of the JSON documents have in common. Each writes one value, under a key that
// the caller has set; WriteSequence sets its own.
#pragma once

#include <optional>
#include <vector>

#include "core/optics/lens_state.h"
#include "core/render/report.h"
#include "protocol/codec/json_writer.h"

namespace flare {

// "sequence": [9, 1]
void WriteSequence(wire::JsonWriter& json, const std::vector<int>& sequence);

// null for what is absent.
void WriteOptional(wire::JsonWriter& json, const std::optional<double>& value);

// {"focus_m" (null: infinity), "zoom_mm" (null: no zoom), "focus_shift_mm", "clamped":
// [{"field", "from", "to" (null: infinity)}]}. The shift is by unit focusing, of the sensor.
void WriteState(wire::JsonWriter& json, const LensInState& lens);

void WriteFourReflections(wire::JsonWriter& json, const FourReflectionFacts& facts);

}  // namespace flare
