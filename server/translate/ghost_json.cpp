// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/json_writer.h"
#include "server/translate/lens_json.h"

namespace flare {
namespace {

using wire::JsonWriter;

void WriteSection(JsonWriter& json, const GhostSection& section) {
    const Abcd& m = section.abcd;
    json.Key("abcd").BeginRow().Value(m.a).Value(m.b).Value(m.c).Value(m.d).End();
    if (!section.crossings.empty()) {
        const GhostCrossing& largest =
            section.crossings[static_cast<std::size_t>(section.largest_crossing)];
        json.Member("m", largest.m).Member("z_eff_mm", largest.z_eff_mm);
    }
    json.Key("crossings").BeginRow();
    for (const GhostCrossing& crossing : section.crossings) {
        json.BeginObject().Member("a1", crossing.a1).Member("m", crossing.m);
        json.Member("z_eff_mm", crossing.z_eff_mm).End();
    }
    json.End();
}

void WriteGhost(JsonWriter& json, const GhostEntry& ghost, const GhostListOptions& options,
                double total_flux_mm2, bool rotational) {
    json.BeginObject().Key("sequence").BeginRow();
    for (const int surface : ghost.sequence) json.Value(surface);
    json.End();
    json.Member("stop_crossings", static_cast<int>(ghost.x.crossings.size()));
    WriteSection(json, ghost.x);
    if (!rotational) {
        // The members above are those of the x section.
        json.Key("y").BeginObject();
        WriteSection(json, ghost.y);
        json.End();
    }
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
                                             : lens.f_number());
    json.Member("field_deg", options.field_deg);
    json.Member("bare_glass", bare_glass);
    json.Member("azimuth_deg", options.azimuth_deg);
    json.Member("total_flux_mm2", list.total_flux_mm2);
    json.Key("ghosts").BeginArray();
    for (const GhostEntry& ghost : list.ghosts) {
        WriteGhost(json, ghost, options, list.total_flux_mm2, lens.rotational());
    }
    json.End().End();
    return json.Take();
}

}  // namespace flare
