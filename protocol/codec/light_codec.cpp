// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/light_codec.h"

#include <algorithm>

#include "protocol/codec/base64.h"
#include "protocol/codec/curve_codec.h"
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

// What the light's colour is made of, and how bright it is.
bool ReadColor(Reader& reader, const JsonView& at, bool spectral, Light& light) {
    for (const std::string_view name : {"temperature_k", "spectrum"}) {
        const std::optional<JsonView> member = at.Find(name);
        if (member && spectral) {
            return reader.Refuse(*member, "bad_value",
                                 "color_space \"spectral\" weights no wavelength: " +
                                     std::string(name) + " goes with a colour picture");
        }
    }
    const std::optional<JsonView> spectrum = at.Find("spectrum");
    if (spectrum && at.Find("temperature_k")) {
        return reader.Refuse(*spectrum, "bad_value",
                             "a light has a temperature or a spectrum, not both");
    }
    return IfGiven(at, "irradiance",
                   [&](const JsonView& v) { return ReadIrradiance(reader, v, spectral, light); }) &&
           IfGiven(at, "temperature_k",
                   [&](const JsonView& v) {
                       return reader.Number(
                           v, FromUpTo(limits::kMinTemperature_k, limits::kMaxTemperature_k),
                           light.temperature_k.emplace());
                   }) &&
           IfGiven(at, "spectrum", [&](const JsonView& v) {
               return ReadSpectrum(reader, v, light.spectrum.emplace());
           });
}

bool ReadShape(Reader& reader, const JsonView& at, Light& light) {
    if (at.kind() == JsonKind::kString || (at.kind() == JsonKind::kObject && at.Find("file"))) {
        return reader.Refuse(at, "bad_value",
                             "a shape is sent as {\"png_base64\": ...}; only flare render reads a "
                             "file named in its place");
    }
    std::optional<JsonView> png;
    std::string text;
    if (!reader.Object(at, {"png_base64"}) || !reader.Require(at, "png_base64", png) ||
        !reader.Text(*png, limits::kMaskTextBytes, text)) {
        return false;
    }
    light.shape_png = BytesFromBase64(text);
    return light.shape_png || reader.Refuse(*png, "bad_value", "the text is not base64");
}

bool ReadLight(Reader& reader, const JsonView& at, bool spectral, Light& light) {
    if (!reader.Object(at, {"direction", "pixel", "distance_m", "irradiance",
                            "angular_diameter_deg", "shape", "temperature_k", "spectrum"})) {
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
           ReadColor(reader, at, spectral, light) &&
           IfGiven(at, "angular_diameter_deg",
                   [&](const JsonView& v) {
                       double& diameter = light.angular_diameter_deg;
                       return reader.Number(v, FromUpTo(0.0, limits::kMaxAngularDiameter_deg),
                                            diameter);
                   }) &&
           IfGiven(at, "shape", [&](const JsonView& v) { return ReadShape(reader, v, light); }) &&
           (!light.shape_png || light.angular_diameter_deg > 0.0 ||
            reader.RefuseMember(at, "shape", "bad_value",
                                "a shape needs its width, angular_diameter_deg"));
}

bool ReadPhoton(Reader& reader, const JsonView& at, Photon& photon) {
    return IfGiven(at, "samples",
                   [&](const JsonView& v) {
                       return reader.Integer(v, limits::kMinPhotonSamples,
                                             limits::kMaxPhotonSamples, photon.samples);
                   }) &&
           IfGiven(at, "seed",
                   [&](const JsonView& v) {
                       return reader.Integer(v, 0, limits::kMaxSeed, photon.seed);
                   }) &&
           IfGiven(at, "estimate",
                   [&](const JsonView& v) {
                       return reader.OneOf<PhotonEstimate>(v,
                                                           {{"pixel", PhotonEstimate::kPixel},
                                                            {"kernel", PhotonEstimate::kKernel},
                                                            {"nearest", PhotonEstimate::kNearest}},
                                                           photon.estimate);
                   }) &&
           IfGiven(at, "kernel_px",
                   [&](const JsonView& v) {
                       return reader.Number(
                           v, FromUpTo(limits::kMinPhotonKernel_px, limits::kMaxPhotonKernel_px),
                           photon.kernel_px);
                   }) &&
           IfGiven(at, "nearest", [&](const JsonView& v) {
               return reader.Integer(v, limits::kMinPhotonNearest, limits::kMaxPhotonNearest,
                                     photon.nearest);
           });
}

// How a reference is made: "method" and what goes with photons.
bool ReadMethod(Reader& reader, const JsonView& at, Quality& quality) {
    bool photons = false;
    const std::optional<JsonView> method = at.Find("method");
    if (method) {
        if (!reader.OneOf<bool>(*method, {{"mesh", false}, {"photon", true}}, photons))
            return false;
        if (quality.preset != Preset::kReference) {
            return reader.Refuse(*method, "bad_value",
                                 "a method goes with the preset \"reference\"");
        }
    }
    for (const std::string_view name : {"samples", "seed", "estimate", "kernel_px", "nearest"}) {
        const std::optional<JsonView> member = at.Find(name);
        if (member && !photons) {
            return reader.Refuse(*member, "bad_value",
                                 std::string(name) + " goes with the method \"photon\"");
        }
    }
    return !photons || ReadPhoton(reader, at, quality.photon.emplace());
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
    std::size_t shapes = 0;
    for (auto child = at.FirstChild(); child; child = child->NextSibling()) {
        if (!ReadLight(reader, *child, spectral, lights.emplace_back())) return false;
        shapes += lights.back().shape_png ? 1 : 0;
        if (shapes > limits::kShapes) {
            return reader.RefuseMember(
                *child, "shape", "limit",
                "at most " + std::to_string(limits::kShapes) + " lights may have a shape");
        }
    }
    return true;
}

bool ReadSequence(Reader& reader, const JsonView& at, std::vector<int>& sequence) {
    if (!reader.Array(at, limits::kBounces)) return false;
    constexpr int kLargestIndex = static_cast<int>(limits::kSurfaces) - 1;
    for (auto child = at.FirstChild(); child; child = child->NextSibling()) {
        if (!reader.Integer(*child, 0, kLargestIndex, sequence.emplace_back())) return false;
    }
    return true;
}

bool ReadQuality(Reader& reader, const JsonView& at, Quality& quality) {
    if (!reader.Object(at, {"preset", "tolerance", "max_error", "time_budget_ms", "method",
                            "samples", "seed", "estimate", "kernel_px", "nearest"})) {
        return false;
    }
    int given = 0;
    for (const char* const name : {"preset", "tolerance", "max_error", "time_budget_ms"}) {
        given += at.Find(name) ? 1 : 0;
    }
    if (given != 1) {
        return reader.RefuseMember(at, "preset", given == 0 ? "missing_field" : "bad_value",
                                   "a quality is one of \"preset\", \"tolerance\", \"max_error\" "
                                   "and \"time_budget_ms\"");
    }
    const auto number = [&](const char* name, Range range, std::optional<double>& value) {
        return IfGiven(at, name,
                       [&](const JsonView& v) { return reader.Number(v, range, value.emplace()); });
    };
    return IfGiven(at, "preset",
                   [&](const JsonView& v) {
                       return reader.OneOf<Preset>(v,
                                                   {{"draft", Preset::kDraft},
                                                    {"preview", Preset::kPreview},
                                                    {"final", Preset::kFinal},
                                                    {"reference", Preset::kReference}},
                                                   quality.preset);
                   }) &&
           number("tolerance", Between(limits::kMinTolerance, limits::kMaxTolerance),
                  quality.tolerance) &&
           number("max_error", Between(limits::kMinTolerance, limits::kMaxTolerance),
                  quality.max_error) &&
           number("time_budget_ms", AboveZeroUpTo(limits::kMaxTimeBudget_ms),
                  quality.time_budget_ms) &&
           ReadMethod(reader, at, quality);
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
