// SPDX-License-Identifier: Apache-2.0
//
// The field data of a lens as the member "field" of a JSON object: what a lens does with light from
// each field angle (core/tracing/field_data.h). What has no value at an angle is null.
#pragma once

#include "core/tracing/field_data.h"
#include "protocol/codec/json_writer.h"

namespace flare {

// Computes the data of the lens in its state, which takes 0.1 s and more, and writes the member.
void WriteField(wire::JsonWriter& json, const Lens& lens, const FieldOptions& options = {});

}  // namespace flare
