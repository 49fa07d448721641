// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/warm_request_codec.h"

#include <array>
#include <cmath>

#include "protocol/codec/image_codec.h"
#include "protocol/codec/lens_codec.h"
#include "protocol/codec/light_codec.h"
#include "protocol/codec/reader.h"
#include "protocol/limits.h"

namespace flare::wire {
namespace {

bool RefuseTooMany(Reader& reader, const JsonView& at) {
    return reader.Refuse(at, "limit",
                         "more than " + std::to_string(limits::kWarmLights) + " lights at once");
}

bool ReadField(Reader& reader, const JsonView& at, FieldAngles& field) {
    std::array<double, 3> values{};
    if (!reader.Numbers(at, Between(-180.0, 180.0), values)) return false;
    const auto& [from, to, step] = values;
    if (!(step > 0.0) || to < from) {
        return reader.Refuse(at, "bad_value",
                             "field_deg is [from, to, step], rising, step above 0");
    }
    // A step that fits all but a rounding error reaches the end.
    const double steps = std::floor((to - from) / step + 1e-9);
    if (steps + 1.0 > static_cast<double>(limits::kWarmLights)) return RefuseTooMany(reader, at);
    field = {from, to, step, static_cast<int>(steps) + 1};
    return true;
}

bool ReadWarmModel(Reader& reader, const JsonView& at, Model& model) {
    if (!ReadModel(reader, at, model)) return false;
    return model.reflections == 2 ||
           reader.RefuseMember(
               at, "reflections", "unsupported",
               "ghosts of four reflections are chosen when a picture asks for them");
}

bool ReadWarmQuality(Reader& reader, const JsonView& at, Quality& quality) {
    if (!ReadQuality(reader, at, quality)) return false;
    for (const char* const name : {"max_error", "time_budget_ms"}) {
        if (const std::optional<JsonView> given = at.Find(name)) {
            return reader.Refuse(*given, "bad_value",
                                 "meshes are those of a preset or a tolerance");
        }
    }
    return !quality.photon ||
           reader.RefuseMember(at, "method", "bad_value", "only a picture is made by photons");
}

bool ReadPlaces(Reader& reader, const JsonView& root, WarmRequest& request) {
    const std::optional<JsonView> lights = root.Find("lights"), field = root.Find("field_deg");
    if (!lights == !field) {
        return reader.RefuseMember(root, "lights", lights ? "bad_value" : "missing_field",
                                   "exactly one of \"lights\" and \"field_deg\" is needed");
    }
    if (field) return ReadField(reader, *field, request.field.emplace());
    if (const std::optional<JsonView> azimuth = root.Find("azimuth_deg")) {
        return reader.Refuse(*azimuth, "bad_value", "azimuth_deg goes with field_deg");
    }
    if (!ReadLights(reader, *lights, false, request.lights)) return false;
    if (request.lights.empty()) return reader.Refuse(*lights, "bad_value", "no light is given");
    if (request.lights.size() > limits::kWarmLights) return RefuseTooMany(reader, *lights);
    for (const Light& light : request.lights) {
        if (light.pixel && !request.image) {
            return reader.RefuseMember(root, "image", "missing_field",
                                       "a light placed by \"pixel\" needs \"image\"");
        }
    }
    return true;
}

bool ReadRequest(Reader& reader, const JsonView& root, WarmRequest& request) {
    return reader.Object(
               root, {"lens", "prescription", "coatings", "f_number", "focus_m", "zoom_mm", "image",
                      "lights", "field_deg", "azimuth_deg", "quality", "model"}) &&
           ReadLensChoice(reader, root, request.lens) &&
           IfGiven(root, "image",
                   [&](const JsonView& v) {
                       return ReadImage(reader, v, request.image.emplace()) &&
                              CheckPictureSize(reader, v, *request.image, 3);
                   }) &&
           IfGiven(
               root, "quality",
               [&](const JsonView& v) { return ReadWarmQuality(reader, v, request.quality); }) &&
           IfGiven(root, "model",
                   [&](const JsonView& v) { return ReadWarmModel(reader, v, request.model); }) &&
           IfGiven(root, "azimuth_deg",
                   [&](const JsonView& v) {
                       return reader.Number(v, Between(-360.0, 360.0), request.azimuth_deg);
                   }) &&
           ReadPlaces(reader, root, request);
}

}  // namespace

Decoded<WarmRequest> DecodeWarmRequest(std::string_view body) {
    const Decoded<JsonDocument> parsed = JsonDocument::Parse(body);
    if (const Refusal* refusal = RefusalOf(parsed)) return *refusal;

    Reader reader;
    WarmRequest request;
    if (!ReadRequest(reader, std::get<JsonDocument>(parsed).root(), request)) {
        return reader.refusal();
    }
    return request;
}

}  // namespace flare::wire
