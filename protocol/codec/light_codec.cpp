// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/light_codec.h"

#include <algorithm>

#include "protocol/limits.h"

namespace flare::wire {
namespace {

bool ReadDirection(Reader& reader, const JsonView& at, Light& light) {
    std::array<double, 3>& direction = light.direction.emplace();
    if (!reader.Numbers(at, Range{}, direction)) return false;
    const bool zero = std::all_of(direction.begin(), direction.end(),
                                  [](double component) { return component == 0.0; });
    return !zero || reader.Refuse(at, "bad_value", "the direction has length zero");
}

bool ReadIrradiance(Reader& reader, const JsonView& at, bool spectral, Light& light) {
    const Range range = FromUpTo(0.0, limits::kMaxIrradiance);
    if (spectral && at.kind() == JsonKind::kNumber) {
        double value = 0.0;
        if (!reader.Number(at, range, value)) return false;
        light.irradiance = {value, value, value};
        return true;
    }
    if (!reader.Numbers(at, range, light.irradiance)) return false;
    const auto& e = light.irradiance;
    return !spectral || (e[0] == e[1] && e[1] == e[2]) ||
           reader.Refuse(at, "bad_value",
                         "in color_space \"spectral\" the irradiance is one number "
                         "(or three equal ones)");
}

bool ReadLight(Reader& reader, const JsonView& at, bool spectral, Light& light) {
    if (!reader.Object(at,
                       {"direction", "pixel", "distance_m", "irradiance", "angular_diameter_deg"},
                       {"temperature_k"})) {
        return false;
    }
    const std::optional<JsonView> direction = at.Find("direction");
    const std::optional<JsonView> pixel = at.Find("pixel");
    if (!direction == !pixel) {
        return reader.Refuse(at, direction ? "bad_value" : "missing_field",
                             "a light has exactly one of \"direction\" and \"pixel\"");
    }
    if (direction && !ReadDirection(reader, *direction, light)) return false;
    if (pixel &&
        !reader.Numbers(*pixel, Within(limits::kMaxPixelCoordinate), light.pixel.emplace())) {
        return false;
    }
    return IfGiven(at, "distance_m",
                   [&](const JsonView& v) {
                       return reader.Number(
                           v, FromUpTo(limits::kMinDistance_m, limits::kMaxDistance_m),
                           light.distance_m.emplace());
                   }) &&
           IfGiven(at, "irradiance",
                   [&](const JsonView& v) { return ReadIrradiance(reader, v, spectral, light); }) &&
           IfGiven(at, "angular_diameter_deg", [&](const JsonView& v) {
               double& diameter = light.angular_diameter_deg;
               return reader.Number(v, FromUpTo(0.0, limits::kMaxAngularDiameter_deg), diameter);
           });
}

bool ReadReflections(Reader& reader, const JsonView& at, int& reflections) {
    double count = 0.0;
    if (!reader.Number(at, Range{}, count)) return false;
    reflections = count == 4.0 ? 4 : 2;
    return count == 2.0 || count == 4.0 || reader.Refuse(at, "bad_value", "reflections is 2 or 4");
}

}  // namespace

bool ReadLights(Reader& reader, const JsonView& at, bool spectral, std::vector<Light>& lights) {
    if (!reader.Array(at, limits::kLights)) return false;
    lights.reserve(at.child_count());
    for (auto child = at.FirstChild(); child; child = child->NextSibling()) {
        if (!ReadLight(reader, *child, spectral, lights.emplace_back())) return false;
    }
    return true;
}

bool ReadQuality(Reader& reader, const JsonView& at, Preset& preset) {
    std::optional<JsonView> word;
    return reader.Object(at, {"preset"}, {"max_error", "time_budget_ms", "method"}) &&
           reader.Require(at, "preset", word) &&
           reader.OneOf<Preset>(*word,
                                {{"draft", Preset::kDraft},
                                 {"preview", Preset::kPreview},
                                 {"final", Preset::kFinal},
                                 {"reference", Preset::kReference}},
                                preset);
}

bool ReadModel(Reader& reader, const JsonView& at, Model& model) {
    return reader.Object(at, {"reflections", "four_reflection_threshold", "ringing",
                              "sensor_reflection", "culling"}) &&
           IfGiven(
               at, "reflections",
               [&](const JsonView& v) { return ReadReflections(reader, v, model.reflections); }) &&
           IfGiven(at, "four_reflection_threshold",
                   [&](const JsonView& v) {
                       return reader.Number(v, AboveZeroUpTo(limits::kMaxFourReflectionThreshold),
                                            model.four_reflection_threshold);
                   }) &&
           IfGiven(at, "ringing",
                   [&](const JsonView& v) {
                       return reader.OneOf<Ringing>(
                           v, {{"auto", Ringing::kAuto}, {"off", Ringing::kOff}}, model.ringing);
                   }) &&
           IfGiven(at, "culling",
                   [&](const JsonView& v) {
                       return reader.OneOf<Culling>(v,
                                                    {{"auto", Culling::kAuto},
                                                     {"none", Culling::kNone},
                                                     {"report", Culling::kReport}},
                                                    model.culling);
                   }) &&
           IfGiven(at, "sensor_reflection",
                   [&](const JsonView& v) { return reader.Boolean(v, model.sensor_reflection); });
}

}  // namespace flare::wire
