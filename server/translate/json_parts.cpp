// SPDX-License-Identifier: Apache-2.0
#include "server/translate/json_parts.h"

namespace flare {

using wire::JsonWriter;

void WriteSequence(JsonWriter& json, const std::vector<int>& sequence) {
    json.Key("sequence").BeginRow();
    for (const int surface : sequence) json.Value(surface);
    json.End();
}

void WriteOptional(JsonWriter& json, const std::optional<double>& value) {
    if (value) {
        json.Value(*value);
    } else {
        json.Null();
    }
}

void WriteState(JsonWriter& json, const LensInState& lens) {
    json.BeginInlineObject().Key("focus_m");
    WriteOptional(json, lens.state.focus_m);
    json.Key("zoom_mm");
    WriteOptional(json, lens.state.zoom_mm);
    json.Member("focus_shift_mm", lens.lens->prescription().focus_shift_mm);
    json.Key("clamped").BeginArray();
    for (const StateClamp& clamp : lens.clamped) {
        json.BeginObject().Member("field", clamp.field);
        json.Member("from", clamp.from).Member("to", clamp.to).End();
    }
    json.End().End();
}

void WriteFourReflections(JsonWriter& json, const FourReflectionFacts& facts) {
    json.BeginInlineObject().Member("threshold", facts.threshold);
    json.Member("sequences", facts.sequences).Member("rendered", facts.rendered);
    json.Member("rendered_flux_mm2", facts.rendered_flux_mm2);
    json.Member("lost_flux_mm2", facts.lost_flux_mm2).End();
}

}  // namespace flare
