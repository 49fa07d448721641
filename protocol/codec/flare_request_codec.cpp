// SPDX-License-Identifier: Apache-2.0
//
// One function an object of the request. Where a field has values that mean what is built and
// values that a later version brings, the first are taken and the second refused as "unsupported";
// no field is ever ignored.
#include "protocol/codec/flare_request_codec.h"

#include <algorithm>

#include "protocol/codec/image_codec.h"
#include "protocol/codec/lens_codec.h"
#include "protocol/codec/reader.h"
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
               double diameter = 0.0;
               return reader.Number(v, Between(0.0, 360.0), diameter) &&
                      (diameter == 0.0 || reader.Unsupported(v));
           });
}

bool ReadLights(Reader& reader, const JsonView& at, bool spectral, std::vector<Light>& lights) {
    if (!reader.Array(at, limits::kLights)) return false;
    lights.reserve(at.child_count());
    for (auto child = at.FirstChild(); child; child = child->NextSibling()) {
        if (!ReadLight(reader, *child, spectral, lights.emplace_back())) return false;
    }
    return true;
}

bool ReadLayers(Reader& reader, const JsonView& at) {
    enum class Layer { kGhosts };
    if (!reader.Array(at, limits::kJsonMembers)) return false;
    for (auto child = at.FirstChild(); child; child = child->NextSibling()) {
        Layer layer = Layer::kGhosts;
        if (!reader.OneOf<Layer>(*child, {{"ghosts", Layer::kGhosts}}, layer,
                                 {"starburst", "bokeh"})) {
            return false;
        }
    }
    if (at.child_count() == 1) return true;
    return reader.Refuse(
        at, "bad_value",
        at.child_count() == 0 ? "no layer is asked for" : "a layer is asked for twice");
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

bool ReadReflections(Reader& reader, const JsonView& at, int& reflections) {
    double count = 0.0;
    if (!reader.Number(at, Range{}, count)) return false;
    reflections = count == 4.0 ? 4 : 2;
    return count == 2.0 || count == 4.0 || reader.Refuse(at, "bad_value", "reflections is 2 or 4");
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

bool ReadOutput(Reader& reader, const JsonView& at, Output& output) {
    return reader.Object(at, {"compression", "pixel"}) &&
           IfGiven(at, "compression",
                   [&](const JsonView& v) {
                       return reader.OneOf<Compression>(
                           v, {{"zip", Compression::kZip}, {"none", Compression::kNone}},
                           output.compression,
                           {"rle", "zips", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"});
                   }) &&
           IfGiven(at, "pixel", [&](const JsonView& v) {
               return reader.OneOf<PixelType>(
                   v, {{"half", PixelType::kHalf}, {"float", PixelType::kFloat}}, output.pixel);
           });
}

bool ReadWavelengths(Reader& reader, const JsonView& at, std::vector<double>& wavelengths_nm) {
    if (!reader.Array(at, limits::kWavelengths)) return false;
    if (at.child_count() == 0) return reader.Refuse(at, "bad_value", "no wavelength is given");
    for (auto child = at.FirstChild(); child; child = child->NextSibling()) {
        double wavelength_nm = 0.0;
        if (!reader.Number(*child, FromUpTo(limits::kMinWavelength_nm, limits::kMaxWavelength_nm),
                           wavelength_nm)) {
            return false;
        }
        if (std::find(wavelengths_nm.begin(), wavelengths_nm.end(), wavelength_nm) !=
            wavelengths_nm.end()) {
            return reader.Refuse(*child, "bad_value", "the wavelength stands twice");
        }
        wavelengths_nm.push_back(wavelength_nm);
    }
    return true;
}

bool ReadColor(Reader& reader, const JsonView& root, FlareRequest& request) {
    if (!IfGiven(root, "color_space", [&](const JsonView& v) {
            return reader.OneOf<ColorSpace>(
                v, {{"lin_rec709", ColorSpace::kLinRec709}, {"spectral", ColorSpace::kSpectral}},
                request.color_space, {"acescg", "aces2065-1"});
        })) {
        return false;
    }
    const std::optional<JsonView> wavelengths = root.Find("wavelengths_nm");
    if (request.color_space == ColorSpace::kSpectral) {
        if (wavelengths) return ReadWavelengths(reader, *wavelengths, request.wavelengths_nm);
        return reader.RefuseMember(root, "wavelengths_nm", "missing_field",
                                   "color_space \"spectral\" needs \"wavelengths_nm\"");
    }
    return !wavelengths || reader.Refuse(*wavelengths, "bad_value",
                                         "wavelengths_nm goes with color_space \"spectral\"");
}

bool ReadRequest(Reader& reader, const JsonView& root, FlareRequest& request) {
    std::optional<JsonView> image, lights;
    return reader.Object(root,
                         {"lens", "prescription", "coatings", "f_number", "focus_m", "zoom_mm",
                          "iris", "image", "lights", "layers", "units", "color_space",
                          "wavelengths_nm", "quality", "model", "output"},
                         {"encoder", "starburst"}) &&
           ReadLensChoice(reader, root, request.lens) &&
           IfGiven(root, "iris",
                   [&](const JsonView& v) { return ReadIris(reader, v, request.iris); }) &&
           reader.Require(root, "image", image) && ReadImage(reader, *image, request.image) &&
           ReadColor(reader, root, request) &&
           CheckPictureSize(reader, *image, request.image,
                            std::max<std::size_t>(3, request.wavelengths_nm.size())) &&
           reader.Require(root, "lights", lights) &&
           ReadLights(reader, *lights, request.color_space == ColorSpace::kSpectral,
                      request.lights) &&
           IfGiven(root, "layers", [&](const JsonView& v) { return ReadLayers(reader, v); }) &&
           IfGiven(root, "units",
                   [&](const JsonView& v) {
                       return reader.OneOf<Units>(v,
                                                  {{"scene_linear", Units::kSceneLinear},
                                                   {"sensor_irradiance", Units::kSensorIrradiance}},
                                                  request.units);
                   }) &&
           IfGiven(root, "quality",
                   [&](const JsonView& v) { return ReadQuality(reader, v, request.preset); }) &&
           IfGiven(root, "model",
                   [&](const JsonView& v) { return ReadModel(reader, v, request.model); }) &&
           IfGiven(root, "output",
                   [&](const JsonView& v) { return ReadOutput(reader, v, request.output); });
}

}  // namespace

Decoded<FlareRequest> DecodeFlareRequest(std::string_view body) {
    const Decoded<JsonDocument> parsed = JsonDocument::Parse(body);
    if (const Refusal* refusal = RefusalOf(parsed)) return *refusal;

    Reader reader;
    FlareRequest request;
    if (!ReadRequest(reader, std::get<JsonDocument>(parsed).root(), request)) {
        return reader.refusal();
    }
    return request;
}

}  // namespace flare::wire
