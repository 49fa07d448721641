// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/json_writer.h"
#include "server/translate/lens_json.h"

namespace flare {
namespace {

using wire::JsonWriter;

void WriteGhost(JsonWriter& json, const GhostEntry& ghost, const GhostListOptions& options,
                double total_flux_mm2) {
    json.BeginObject().Key("sequence").BeginRow();
    for (const int surface : ghost.sequence) json.Value(surface);
    json.End();
    json.Member("stop_crossings", static_cast<int>(ghost.crossings.size()));
    json.Key("abcd").BeginRow();
    json.Value(ghost.abcd.a).Value(ghost.abcd.b).Value(ghost.abcd.c).Value(ghost.abcd.d).End();
    if (!ghost.crossings.empty()) {
        const GhostCrossing& largest =
            ghost.crossings[static_cast<std::size_t>(ghost.largest_crossing)];
        json.Member("m", largest.m).Member("z_eff_mm", largest.z_eff_mm);
    }
    json.Key("crossings").BeginRow();
    for (const GhostCrossing& crossing : ghost.crossings) {
        json.BeginObject().Member("a1", crossing.a1).Member("m", crossing.m);
        json.Member("z_eff_mm", crossing.z_eff_mm).End();
    }
    json.End();
    json.Member("flux_mm2", ghost.flux_mm2);
    json.Member("share", total_flux_mm2 > 0.0 ? ghost.flux_mm2 / total_flux_mm2 : 0.0);
    json.Key("centroid_mm").BeginRow().Value(ghost.centroid_mm.x).Value(ghost.centroid_mm.y).End();
    if (options.with_peaks) json.Member("peak_irradiance", ghost.peak_irradiance);
    json.End();
}

}  // namespace

std::string GhostListJson(const Lens& lens, const GhostList& list, const GhostListOptions& options,
                          bool bare_glass) {
    JsonWriter json(JsonWriter::Style::kPretty);
    json.BeginObject().Member("lens", lens.name());
    json.Member("wavelength_nm", options.wavelength_nm);
    json.Member("f_number", options.f_number ? StopForFNumber(lens, *options.f_number).f_number
                                             : lens.first_order().f_number);
    json.Member("field_deg", options.field_deg);
    json.Member("bare_glass", bare_glass);
    json.Member("total_flux_mm2", list.total_flux_mm2);
    json.Key("ghosts").BeginArray();
    for (const GhostEntry& ghost : list.ghosts) {
        WriteGhost(json, ghost, options, list.total_flux_mm2);
    }
    json.End().End();
    return json.Take();
}

}  // namespace flare
