// SPDX-License-Identifier: Apache-2.0
#include "server/translate/trace_from_wire.h"

#include <cmath>

#include "core/optics/paraxial.h"
#include "core/tracing/trace_reference.h"
#include "protocol/codec/trace_request_codec.h"
#include "server/translate/json_parts.h"
#include "server/translate/lens_from_wire.h"
#include "server/translate/request_from_wire.h"

namespace flare {
namespace {

using wire::JsonWriter;

void WritePoint(JsonWriter& json, Vec2d p) {
    json.BeginRow().Value(p.x).Value(p.y).End();
}

void WriteRay(JsonWriter& json, const Lens& lens, const InteractionList& list,
              const TraceResult& result, const RayRecord& record) {
    json.BeginInlineObject().Member("fate", Name(result.fate));
    json.Key("sensor_mm");
    if (result.fate == RayFate::kArrived) {
        WritePoint(json, result.sensor_mm);
    } else {
        json.Null();
    }
    json.Key("stops_mm").BeginRow();
    for (const Vec2d& crossing : record.stop_mm) WritePoint(json, crossing);
    json.End();
    json.Member("max_rim_ratio", std::sqrt(result.max_rim_ratio2));
    json.Member("weight", PathWeight(lens, list, record));
    json.Member("path_mm", result.path_mm);
    json.Member("out_of_order", result.out_of_order);
    if (result.fate == RayFate::kArrived) {
        const Vec3d& exit = result.exit_direction;
        json.Key("exit_direction").BeginRow().Value(exit.x).Value(exit.y).Value(exit.z).End();
    } else if (result.ended_at >= 0) {
        json.Member("ended_at_surface",
                    list.steps[static_cast<std::size_t>(result.ended_at)].surface);
    }
    json.End();
}

}  // namespace

Result<std::string> TraceJson(std::string_view input, const LensLibrary& library) {
    const wire::Decoded<wire::TraceRequest> decoded = wire::DecodeTraceRequest(input);
    if (const wire::Refusal* refusal = wire::RefusalOf(decoded)) {
        return Error{refusal->code, refusal->message, refusal->where};
    }
    const auto& request = std::get<wire::TraceRequest>(decoded);
    const Result<LensInState> found = LensFromWire(request.lens, library);
    if (!found) return found.error();
    const Lens& lens = *found->lens;
    if (std::optional<Error> error = CheckSequence(lens, request.sequence)) {
        error->where = "/sequence";
        return *error;
    }
    const InteractionList list = WriteOut(lens, request.sequence, request.wavelength_nm);

    // An f-number sets a round iris; without one the stop's own rim is the iris.
    std::optional<Iris> iris;
    double f_number = lens.f_number();
    if (request.lens.f_number) {
        const auto& stop = lens.surfaces()[static_cast<std::size_t>(lens.stop_index())];
        const StopSetting setting = StopForFNumber(lens, *request.lens.f_number);
        f_number = setting.f_number;
        iris.emplace(IrisShape{}, setting.semi_diameter_mm, stop.semi_diameter_mm);
    }
    TraceOptions options;
    options.clip = request.clip;
    options.iris = iris ? &*iris : nullptr;

    JsonWriter json(JsonWriter::Style::kPretty);
    json.BeginObject().Key("state");
    WriteState(json, *found);
    json.Member("f_number", f_number).Key("rays").BeginArray();
    RayRecord record;
    for (const wire::TraceRay& ray : request.rays) {
        const Vec3d origin(ray.origin[0], ray.origin[1], ray.origin[2]);
        const Vec3d direction = DirectionFromWire(ray.direction).normalized();
        const TraceResult result = TraceRay(list, {origin, direction}, options, &record);
        WriteRay(json, lens, list, result, record);
    }
    json.End().End();
    return json.Take();
}

}  // namespace flare
