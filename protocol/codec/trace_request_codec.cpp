// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/trace_request_codec.h"

#include <algorithm>

#include "protocol/codec/lens_codec.h"
#include "protocol/codec/light_codec.h"
#include "protocol/codec/reader.h"
#include "protocol/limits.h"

namespace flare::wire {
namespace {

bool ReadRay(Reader& reader, const JsonView& at, TraceRay& ray) {
    std::optional<JsonView> origin, direction;
    if (!(reader.Object(at, {"origin", "direction"}) && reader.Require(at, "origin", origin) &&
          reader.Numbers(*origin, Range{}, ray.origin) &&
          reader.Require(at, "direction", direction) &&
          reader.Numbers(*direction, Range{}, ray.direction))) {
        return false;
    }
    const bool zero = std::all_of(ray.direction.begin(), ray.direction.end(),
                                  [](double component) { return component == 0.0; });
    return !zero || reader.Refuse(*direction, "bad_value", "the direction has length zero");
}

bool ReadRays(Reader& reader, const JsonView& at, std::vector<TraceRay>& rays) {
    if (!reader.Array(at, limits::kTraceRays)) return false;
    rays.reserve(at.child_count());
    for (auto child = at.FirstChild(); child; child = child->NextSibling()) {
        if (!ReadRay(reader, *child, rays.emplace_back())) return false;
    }
    return true;
}

bool ReadRequest(Reader& reader, const JsonView& root, TraceRequest& request) {
    enum class Precision { kDouble };
    Precision precision = Precision::kDouble;
    std::optional<JsonView> rays;
    return reader.Object(root,
                         {"lens", "prescription", "coatings", "f_number", "focus_m", "zoom_mm",
                          "wavelength_nm", "sequence", "precision", "clip", "rays"}) &&
           ReadLensChoice(reader, root, request.lens) &&
           IfGiven(root, "wavelength_nm",
                   [&](const JsonView& v) {
                       return reader.Number(
                           v, FromUpTo(limits::kMinWavelength_nm, limits::kMaxWavelength_nm),
                           request.wavelength_nm);
                   }) &&
           IfGiven(root, "sequence",
                   [&](const JsonView& v) { return ReadSequence(reader, v, request.sequence); }) &&
           IfGiven(root, "precision",
                   [&](const JsonView& v) {
                       return reader.OneOf<Precision>(v, {{"double", Precision::kDouble}},
                                                      precision, {"float"});
                   }) &&
           IfGiven(root, "clip",
                   [&](const JsonView& v) { return reader.Boolean(v, request.clip); }) &&
           reader.Require(root, "rays", rays) && ReadRays(reader, *rays, request.rays);
}

}  // namespace

Decoded<TraceRequest> DecodeTraceRequest(std::string_view body) {
    const Decoded<JsonDocument> parsed = JsonDocument::Parse(body);
    if (const Refusal* refusal = RefusalOf(parsed)) return *refusal;

    Reader reader;
    TraceRequest request;
    if (!ReadRequest(reader, std::get<JsonDocument>(parsed).root(), request)) {
        return reader.refusal();
    }
    return request;
}

}  // namespace flare::wire
