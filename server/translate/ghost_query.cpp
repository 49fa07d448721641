// SPDX-License-Identifier: Apache-2.0
#include "server/translate/ghost_query.h"

#include <cmath>

#include "server/translate/json_parts.h"
#include "server/translate/lens_from_wire.h"

namespace flare {
namespace {

using wire::JsonWriter;

// The core counts field angles from 0: what is below turns the light round the axis.
GhostListOptions OptionsOf(const GhostQuery& query) {
    GhostListOptions options;
    if (query.wavelength_nm) options.wavelength_nm = *query.wavelength_nm;
    options.f_number = query.f_number;
    options.field_deg = std::abs(query.field_deg);
    options.azimuth_deg = query.azimuth_deg;
    if (query.field_deg < 0.0) options.azimuth_deg += query.azimuth_deg > 0.0 ? -180.0 : 180.0;
    options.model = query.model;
    return options;
}

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

void WriteGhost(JsonWriter& json, const GhostEntry& ghost, double total_flux_mm2, bool rotational) {
    json.BeginObject();
    WriteSequence(json, ghost.sequence);
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
    json.Member("peak_irradiance", ghost.peak_irradiance).End();
}

}  // namespace

Result<RankedGhosts> RankGhostsFor(const std::shared_ptr<const Lens>& base, const GhostQuery& query,
                                   const RenderContext& context) {
    Result<LensInState> lens = LensAsAsked(base, query.coatings, query.state);
    if (!lens) {
        Error error = lens.error();
        error.where = error.code == "bad_lens" ? "" : "coatings";
        return error;
    }
    Result<GhostList> list = RankGhosts(lens->lens, OptionsOf(query), context);
    if (!list) return list.error();
    return RankedGhosts{std::move(*lens), std::move(*list)};
}

std::string GhostListJson(const RankedGhosts& ghosts, const GhostQuery& query) {
    const Lens& lens = *ghosts.lens.lens;
    const GhostList& list = ghosts.list;
    JsonWriter json(JsonWriter::Style::kPretty);
    json.BeginObject().Member("lens", lens.name());
    json.Key("state");
    WriteState(json, ghosts.lens);
    json.Member("wavelength_nm", query.wavelength_nm.value_or(kLineD));
    json.Member("f_number",
                query.f_number ? StopForFNumber(lens, *query.f_number).f_number : lens.f_number());
    json.Member("field_deg", query.field_deg).Member("azimuth_deg", query.azimuth_deg);
    json.Member("bare_glass", query.coatings.none);
    if (query.coatings.default_name) json.Member("coatings", *query.coatings.default_name);
    json.Key("model").BeginInlineObject().Member("reflections", query.model.reflections);
    json.Member("sensor_reflection", query.model.sensor_reflection).End();
    json.Member("total_flux_mm2", list.total_flux_mm2);
    if (list.four_reflections) {
        json.Key("four_reflections");
        WriteFourReflections(json, *list.four_reflections);
    }
    json.Key("ghosts").BeginArray();
    for (const GhostEntry& ghost : list.ghosts) {
        WriteGhost(json, ghost, list.total_flux_mm2, lens.rotational());
    }
    json.End().End();
    return json.Take();
}

}  // namespace flare
