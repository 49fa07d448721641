// SPDX-License-Identifier: Apache-2.0
#include "server/translate/field_json.h"

#include "core/base/units.h"

namespace flare {
namespace {

void NullableMember(wire::JsonWriter& json, std::string_view name,
                    const std::optional<double>& value) {
    json.Key(name);
    if (value) {
        json.Value(*value);
    } else {
        json.Null();
    }
}

void WriteNumbers(wire::JsonWriter& json, std::string_view name,
                  const std::vector<double>& numbers) {
    json.Key(name).BeginRow();
    for (const double number : numbers) json.Value(number);
    json.End();
}

void WriteRow(wire::JsonWriter& json, const FieldRow& row, bool fisheye) {
    json.BeginInlineObject().Member("field_deg", DegreesFromRadians(row.field_rad));
    NullableMember(json, "image_height_mm", row.image_height_mm);
    NullableMember(json, "ideal_height_mm", row.ideal_height_mm);
    NullableMember(json, "distortion", row.distortion);
    if (fisheye) NullableMember(json, "f_theta_distortion", row.f_theta_distortion);
    NullableMember(json, "irradiance", row.irradiance);
    NullableMember(json, "relative_illumination", row.relative_illumination);
    json.Member("beam_area_mm2", row.beam_area_mm2).Member("beam_share", row.beam_share);
    json.Member("flux_mm2", row.flux_mm2);
    NullableMember(json, "transmittance_d", row.transmittance);
    WriteNumbers(json, "transmittance", row.transmittances);
    json.End();
}

}  // namespace

void WriteField(wire::JsonWriter& json, const Lens& lens, const FieldOptions& options) {
    const FieldData data = FieldDataOf(lens, options);
    json.Key("field").BeginObject().Member("f_number", data.f_number);
    WriteNumbers(json, "wavelengths_nm", data.wavelengths_nm);
    json.Key("tables").BeginArray();
    for (const FieldTable& table : data.tables) {
        json.BeginObject();
        if (!lens.rotational()) json.Member("section", table.section == Section::kX ? "x" : "y");
        json.Member("edge", Name(table.edge)).Key("rows").BeginArray();
        for (const FieldRow& row : table.rows) WriteRow(json, row, lens.prescription().fisheye);
        json.End().End();
    }
    json.End().End();
}

}  // namespace flare
