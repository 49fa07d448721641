// SPDX-License-Identifier: Apache-2.0
#include "server/translate/report_json.h"

#include <algorithm>
#include <map>

#include "protocol/limits.h"
#include "server/translate/json_parts.h"

namespace flare {
namespace {

using wire::JsonWriter;

std::string_view PresetName(QualityPreset preset) {
    switch (preset) {
        case QualityPreset::kDraft:
            return "draft";
        case QualityPreset::kPreview:
            return "preview";
        case QualityPreset::kFinal:
            return "final";
        case QualityPreset::kReference:
            return "reference";
    }
    return "preview";
}

void WritePhoton(JsonWriter& json, const PhotonSpec& spec) {
    json.Member("method", "photon").Member("samples", static_cast<std::uint64_t>(spec.samples));
    json.Member("seed", spec.seed);
    switch (spec.estimate) {
        case PhotonEstimate::kPixel:
            json.Member("estimate", "pixel");
            break;
        case PhotonEstimate::kKernel:
            json.Member("estimate", "kernel").Member("kernel_px", spec.kernel_px);
            break;
        case PhotonEstimate::kNearest:
            json.Member("estimate", "nearest").Member("nearest", spec.nearest);
            break;
    }
}

void WriteQuality(JsonWriter& json, const Quality& quality,
                  const std::optional<PhotonSpec>& photon) {
    json.BeginInlineObject();
    if (quality.tolerance) {
        json.Member("tolerance", *quality.tolerance);
    } else if (quality.max_error) {
        json.Member("max_error", *quality.max_error);
    } else if (quality.time_budget_ms) {
        json.Member("time_budget_ms", *quality.time_budget_ms);
    } else {
        json.Member("preset", PresetName(quality.preset));
        if (photon) WritePhoton(json, *photon);
    }
    json.End();
}

void TextMember(JsonWriter& json, std::string_view name, const std::string& text) {
    if (!text.empty()) json.Member(name, text);
}

// The state as it was measured; what the lens made of it stands under "state" and "f_number".
void WriteEncoder(JsonWriter& json, const EncoderUse& use) {
    const LensReading& reading = use.timed.reading;
    json.Key("encoder").BeginInlineObject().Member("name", use.name).Member("kind", use.kind);
    json.Member("time_s", use.timed.time_s).Member("age_ms", use.age_ms);
    if (const auto& focus = reading[LensAxis::kFocus]) json.Member("focus_m", *focus);
    if (const auto& iris = reading[LensAxis::kIris]) {
        json.Member(reading.iris_is_t_stop ? "t_stop" : "f_number", *iris);
    }
    if (const auto& zoom = reading[LensAxis::kZoom]) json.Member("zoom_mm", *zoom);
    json.End();
}

void WriteHead(JsonWriter& json, const FlareRequest& request, const Report& report,
               const ReplyFacts& reply) {
    TextMember(json, "id", reply.id);
    TextMember(json, "request_hash", reply.request_hash);
    json.Member("lens", request.lens->name());
    TextMember(json, "content_type", reply.content_type);
    json.Member("width", reply.window.width).Member("height", reply.window.height);
    json.Member("bytes", reply.bytes);
    json.Key("state").BeginInlineObject().Key("focus_m");
    WriteOptional(json, report.facts.focus_m);
    json.Key("zoom_mm");
    WriteOptional(json, report.facts.zoom_mm);
    json.End();
    json.Member("f_number", report.facts.f_number);
    if (reply.encoder) WriteEncoder(json, *reply.encoder);
    json.Member("saturated_pixels", report.facts.saturated_pixels);
    if (!request.artist.empty()) {
        json.Member("artist_ghosts", static_cast<std::uint64_t>(request.artist.size()));
    }
    json.Member("culled_flux_mm2", report.facts.culled_flux_mm2);
    const EstimatedError& error = report.facts.estimated_error;
    json.Key("estimated_error").BeginInlineObject().Member("rel_l1", error.rel_l1);
    json.Member("culling", error.culling).Member("dispersion", error.dispersion);
    json.Member("colour", error.colour).Member("mesh", error.mesh);
    json.Member("pieces", error.pieces).Member("source", error.source).End();
    json.Key("plan");
    WriteQuality(json, request.quality, request.photon);
}

std::string_view CullingName(CullingRule rule) {
    switch (rule) {
        case CullingRule::kAuto:
            return "auto";
        case CullingRule::kNone:
            return "none";
        case CullingRule::kReport:
        case CullingRule::kReportSize:
        case CullingRule::kReportCrossings:
            return "report";
    }
    return "auto";
}

void WriteCulling(JsonWriter& json, const CullingFacts& culling) {
    json.Key("culling").BeginInlineObject().Member("culled", culling.culled);
    json.Member("faded", culling.faded).Member("frame_flux_mm2", culling.frame_flux_mm2);
    json.Member("lost_flux_mm2", culling.lost_flux_mm2).End();
}

void WriteUnseen(JsonWriter& json, std::string_view name, const UnseenFacts& facts) {
    json.Key(name).BeginInlineObject().Member("count", facts.count);
    json.Member("peak", facts.peak).Member("flux_mm2", facts.flux_mm2).End();
}

void WriteVisible(JsonWriter& json, const VisibleSpec& spec, const VisibleFacts& facts) {
    json.Key("visible").BeginObject().Member("exposure_stops", spec.exposure_stops);
    json.Member("noise_floor", spec.noise_floor).Member("floor", facts.floor);
    WriteUnseen(json, "ghosts", facts.ghosts);
    WriteUnseen(json, "four_reflections", facts.four_reflections);
    WriteUnseen(json, "details", facts.details);
    WriteUnseen(json, "starburst", facts.starburst);
    json.End();
}

void WriteWork(JsonWriter& json, const Work& work, const ReplyFacts& reply) {
    json.Key("work").BeginObject();
    json.Member("rays_traced", work.rays_traced).Member("ray_surfaces", work.ray_surfaces);
    json.Member("sampled_rays", work.sampled_rays);
    json.Member("cells", work.cells).Member("polygons", work.polygons);
    json.Member("fragments", work.fragments);
    json.Member("pixels", static_cast<std::uint64_t>(reply.window.pixels()));
    json.Member("mesh_cache_hits", work.mesh_hits).Member("mesh_cache_misses", work.mesh_misses);
    json.Member("mesh_disk_hits", work.mesh_disk_hits);
    json.Member("ghost_cache_hits", work.ghost_hits);
    json.Member("threads", reply.threads);
    if (work.search) {
        json.Key("search").BeginInlineObject().Member("pictures", work.search->pictures);
        json.Member("overruns", work.search->overruns);
        json.Member("total_ms", work.search->total_ms).End();
    }
    json.Key("time_ms").BeginInlineObject();
    json.Member("setup", work.setup_ms).Member("cull", work.cull_ms);
    json.Member("mesh", work.mesh_ms).Member("raster", work.raster_ms);
    json.Member("resolve", work.resolve_ms).Member("encode", reply.encode_ms);
    json.End().End();
}

void WriteRow(JsonWriter& json, std::string_view name, Vec2d v) {
    json.Key(name).BeginRow().Value(v.x).Value(v.y).End();
}

void WriteLights(JsonWriter& json, const std::vector<LightFacts>& lights) {
    json.Key("lights").BeginArray();
    for (const LightFacts& light : lights) {
        json.BeginInlineObject().Key("direction").BeginRow();
        json.Value(light.direction.x).Value(light.direction.y).Value(light.direction.z).End();
        json.Member("field_deg", light.field_deg);
        json.Member("chief_ray_arrives", light.chief_ray_arrives);
        if (light.chief_ray_arrives) {
            WriteRow(json, "sensor_mm", light.sensor_mm);
            WriteRow(json, "pixel", light.pixel);
        }
        json.End();
    }
    json.End();
}

// What physics ran, as against what was asked for.
void WriteModel(JsonWriter& json, const ModelSpec& model) {
    json.Key("model").BeginInlineObject().Member("reflections", model.reflections);
    json.Member("ringing", model.ringing ? "auto" : "off")
        .Member("sensor_reflection", model.sensor_reflection);
    json.Member("culling", CullingName(model.culling)).End();
}

// Why it rings, or does not; nothing for a ghost that was never drawn.
void WriteRinging(JsonWriter& json, const RingingFacts& facts) {
    if (facts.reason.empty()) return;
    json.Key("ringing").BeginInlineObject().Member("reason", facts.reason);
    json.Member("weight", facts.weight).Member("z_mm", facts.z_mm);
    json.Member("fresnel_number", facts.fresnel_number).Member("fringe_px", facts.fringe_px).End();
}

// Ghosts of four reflections can be a hundred thousand: all are counted, the first are listed.
void WriteGhosts(JsonWriter& json, const std::vector<GhostFacts>& ghosts) {
    json.Member("ghost_count", static_cast<std::uint64_t>(ghosts.size()));
    json.Key("ghosts").BeginArray();
    const std::size_t listed = std::min(ghosts.size(), limits::kReportGhosts);
    for (std::size_t i = 0; i < listed; ++i) {
        json.BeginInlineObject();
        WriteSequence(json, ghosts[i].sequence);
        json.Member("model", ghosts[i].model).Member("flux_mm2", ghosts[i].flux_mm2);
        json.Member("source_directions", ghosts[i].source_directions);
        WriteRinging(json, ghosts[i].ringing);
        json.End();
    }
    json.End();
}

void WriteStarburst(JsonWriter& json, const StarburstSpec& spec, const StarburstFacts& facts) {
    json.Key("starburst").BeginInlineObject().Member("core", facts.core);
    json.Member("lights", facts.lights).Member("flux_mm2", facts.flux_mm2);
    json.Member("core_share", facts.core_share).Member("jitter_deg", spec.jitter_deg);
    json.Member("jitter_count", spec.jitter_count).Member("seed", spec.seed).End();
}

void WriteBokeh(JsonWriter& json, const BokehFacts& facts) {
    json.Key("bokeh").BeginInlineObject().Member("lights", facts.lights);
    json.Member("flux_mm2", facts.flux_mm2).End();
}

// What an artist has made of the ghosts: the picture is not what the lens does.
void WriteArtist(JsonWriter& json, const std::vector<ArtistGhost>& ghosts) {
    json.Key("artist").BeginArray();
    for (const ArtistGhost& ghost : ghosts) {
        json.BeginInlineObject();
        WriteSequence(json, ghost.sequence);
        json.Member("gain", ghost.gain).Key("tint").BeginRow();
        json.Value(ghost.tint.x).Value(ghost.tint.y).Value(ghost.tint.z).End();
        json.Member("mute", ghost.mute).End();
    }
    json.End();
}

void WriteClamped(JsonWriter& json, const std::vector<std::string>& clamped) {
    json.Key("clamped").BeginArray();
    for (const std::string& text : clamped) json.Value(text);
    json.End();
}

}  // namespace

std::string ColorSpaceName(const FlareRequest& request) {
    if (request.camera) return "camera";
    switch (request.color) {
        case ColorMode::kLinRec709:
            return "lin_rec709";
        case ColorMode::kAcesCg:
            return "acescg";
        case ColorMode::kAces2065:
            return "aces2065-1";
        case ColorMode::kSpectral:
            return "spectral";
    }
    return "lin_rec709";
}

std::string ReportJson(const FlareRequest& request, const Report& report, const ReplyFacts& reply) {
    const Facts& facts = report.facts;
    JsonWriter json(JsonWriter::Style::kPretty);
    json.BeginObject();
    WriteHead(json, request, report, reply);
    json.Member("working_f_number", facts.working_f_number).Member("t_axis", facts.t_axis);
    json.Member("units",
                request.units == Units::kSceneLinear ? "scene_linear" : "sensor_irradiance");
    json.Member("scene_linear_factor", facts.scene_linear_factor);
    json.Member("squeeze", facts.squeeze).Member("desqueezed", request.image.desqueeze);
    json.Member("color_space", ColorSpaceName(request));
    json.Key("quality");
    WriteQuality(json, reply.asked, request.photon);
    WriteModel(json, request.model);
    WriteClamped(json, facts.clamped);
    json.Member("light_count", static_cast<std::uint64_t>(request.lights.size()));
    WriteLights(json, facts.lights);
    WriteCulling(json, facts.culling);
    if (facts.four_reflections) {
        json.Key("four_reflections");
        WriteFourReflections(json, *facts.four_reflections);
    }
    if (facts.visible) WriteVisible(json, *request.visible, *facts.visible);
    if (facts.photon) {
        json.Key("photon").BeginInlineObject().Member("rays", facts.photon->rays);
        json.Member("landed", facts.photon->landed).Member("rel_l1", facts.photon->rel_l1).End();
    }
    if (facts.starburst) WriteStarburst(json, request.starburst, *facts.starburst);
    if (facts.bokeh) WriteBokeh(json, *facts.bokeh);
    if (!request.artist.empty()) WriteArtist(json, request.artist);
    WriteGhosts(json, facts.ghosts);
    WriteWork(json, report.work, reply);
    json.End();
    return json.Take();
}

std::string ReportSummaryJson(const FlareRequest& request, const Report& report,
                              const ReplyFacts& reply) {
    // The clamped values are the one part without a bound of its own: they go if there are too
    // many.
    for (const bool with_clamped : {true, false}) {
        JsonWriter json(JsonWriter::Style::kCompact);
        json.BeginObject();
        WriteHead(json, request, report, reply);
        if (with_clamped) {
            WriteClamped(json, report.facts.clamped);
        } else {
            json.Member("clamped_count", static_cast<std::uint64_t>(report.facts.clamped.size()));
        }
        json.Member("ghosts", static_cast<std::uint64_t>(report.facts.ghosts.size()));
        WriteWork(json, report.work, reply);
        json.End();
        std::string text = json.Take();
        if (text.size() <= limits::kReportSummaryBytes) return text;
    }
    return "{}";
}

}  // namespace flare
