// SPDX-License-Identifier: Apache-2.0
//
// One function an object of the request. Where a field has values that mean what is built and
// values that a later version brings, the first are taken and the second refused as "unsupported";
// no field is ever ignored.
#include "protocol/codec/flare_request_codec.h"

#include <algorithm>

#include "protocol/codec/curve_codec.h"
#include "protocol/codec/image_codec.h"
#include "protocol/codec/lens_codec.h"
#include "protocol/codec/light_codec.h"
#include "protocol/codec/reader.h"
#include "protocol/limits.h"

namespace flare::wire {
namespace {

bool ReadLayers(Reader& reader, const JsonView& at, Layers& layers) {
    layers = {false, false, false};
    if (!reader.Array(at, limits::kJsonMembers)) return false;
    for (auto child = at.FirstChild(); child; child = child->NextSibling()) {
        bool Layers::*layer = nullptr;
        if (!reader.OneOf<bool Layers::*>(*child,
                                          {{"ghosts", &Layers::ghosts},
                                           {"starburst", &Layers::starburst},
                                           {"bokeh", &Layers::bokeh}},
                                          layer)) {
            return false;
        }
        if (layers.*layer) return reader.Refuse(at, "bad_value", "a layer is asked for twice");
        layers.*layer = true;
    }
    return at.child_count() > 0 || reader.Refuse(at, "bad_value", "no layer is asked for");
}

bool ReadStarburst(Reader& reader, const JsonView& at, Starburst& starburst) {
    return reader.Object(at, {"core", "jitter_deg", "jitter_count", "seed"}) &&
           IfGiven(at, "core",
                   [&](const JsonView& v) { return reader.Boolean(v, starburst.core); }) &&
           IfGiven(at, "jitter_deg",
                   [&](const JsonView& v) {
                       return reader.Number(v, FromUpTo(0.0, limits::kMaxJitter_deg),
                                            starburst.jitter_deg);
                   }) &&
           IfGiven(at, "jitter_count",
                   [&](const JsonView& v) {
                       return reader.Integer(v, 1, limits::kMaxJitterCount, starburst.jitter_count);
                   }) &&
           IfGiven(at, "seed", [&](const JsonView& v) {
               return reader.Integer(v, 0, limits::kMaxSeed, starburst.seed);
           });
}

bool ReadSplit(Reader& reader, const JsonView& at, FlareRequest& request) {
    if (!reader.OneOf<Split>(
            at, {{"none", Split::kNone}, {"ghost", Split::kGhost}, {"light", Split::kLight}},
            request.split)) {
        return false;
    }
    if (request.split == Split::kGhost && !request.layers.ghosts) {
        return reader.Refuse(at, "bad_value", "there is no layer of ghosts to split");
    }
    if (request.split == Split::kLight && request.lights.size() > limits::kSplitLayers) {
        return reader.Refuse(
            at, "limit",
            "at most " + std::to_string(limits::kSplitLayers) + " lights can be split");
    }
    return true;
}

bool ReadArtistGhost(Reader& reader, const JsonView& at, bool spectral, ArtistGhost& ghost) {
    const Range range = FromUpTo(0.0, limits::kMaxArtistGain);
    std::optional<JsonView> sequence;
    return reader.Object(at, {"sequence", "gain", "tint", "mute"}) &&
           reader.Require(at, "sequence", sequence) &&
           ReadSequence(reader, *sequence, ghost.sequence) &&
           IfGiven(at, "gain",
                   [&](const JsonView& v) { return reader.Number(v, range, ghost.gain); }) &&
           IfGiven(at, "tint",
                   [&](const JsonView& v) {
                       return reader.Numbers(v, range, ghost.tint) &&
                              (!spectral ||
                               reader.Refuse(v, "bad_value",
                                             "a spectral picture has no red, green and blue to "
                                             "tint"));
                   }) &&
           IfGiven(at, "mute", [&](const JsonView& v) { return reader.Boolean(v, ghost.mute); });
}

bool ReadArtist(Reader& reader, const JsonView& at, FlareRequest& request) {
    std::optional<JsonView> ghosts;
    if (!reader.Object(at, {"ghosts"}) || !reader.Require(at, "ghosts", ghosts) ||
        !reader.Array(*ghosts, limits::kArtistGhosts)) {
        return false;
    }
    const bool spectral = request.color_space == ColorSpace::kSpectral;
    for (auto child = ghosts->FirstChild(); child; child = child->NextSibling()) {
        ArtistGhost ghost;
        if (!ReadArtistGhost(reader, *child, spectral, ghost)) return false;
        const auto same = [&](const ArtistGhost& other) {
            return other.sequence == ghost.sequence;
        };
        if (std::any_of(request.artist.begin(), request.artist.end(), same)) {
            return reader.RefuseMember(*child, "sequence", "bad_value", "the ghost is named twice");
        }
        request.artist.push_back(std::move(ghost));
    }
    return request.artist.empty() || request.layers.ghosts ||
           reader.Refuse(at, "bad_value", "there is no layer of ghosts");
}

bool ReadVisible(Reader& reader, const JsonView& at, Visible& visible) {
    std::optional<JsonView> floor;
    return reader.Object(at, {"exposure_stops", "noise_floor"}) &&
           reader.Require(at, "noise_floor", floor) &&
           reader.Number(*floor, AboveZeroUpTo(limits::kMaxNoiseFloor), visible.noise_floor) &&
           IfGiven(at, "exposure_stops", [&](const JsonView& v) {
               return reader.Number(v, Within(limits::kMaxExposure_stops), visible.exposure_stops);
           });
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
            return reader.OneOf<ColorSpace>(v,
                                            {{"lin_rec709", ColorSpace::kLinRec709},
                                             {"acescg", ColorSpace::kAcesCg},
                                             {"aces2065-1", ColorSpace::kAces2065},
                                             {"spectral", ColorSpace::kSpectral}},
                                            request.color_space);
        })) {
        return false;
    }
    if (const std::optional<JsonView> camera = root.Find("camera")) {
        if (request.color_space == ColorSpace::kSpectral) {
            return reader.Refuse(*camera, "bad_value",
                                 "a camera goes with a colour picture, not with \"spectral\"");
        }
        if (!ReadCamera(reader, *camera, request.camera.emplace())) return false;
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

bool ReadEncoder(Reader& reader, const JsonView& root, std::optional<EncoderChoice>& encoder) {
    const std::optional<JsonView> name = root.Find("encoder");
    for (const std::string_view other : {"encoder_time", "encoder_max_age_ms"}) {
        const std::optional<JsonView> member = root.Find(other);
        if (member && !name) {
            return reader.Refuse(*member, "bad_value",
                                 std::string(other) + " goes with \"encoder\"");
        }
    }
    if (!name) return true;
    EncoderChoice& choice = encoder.emplace();
    return reader.Text(*name, limits::kNameBytes, choice.name) &&
           IfGiven(root, "encoder_time",
                   [&](const JsonView& v) {
                       return reader.Number(v, FromUpTo(0.0, limits::kMaxEncoderTime_s),
                                            choice.time_s.emplace());
                   }) &&
           IfGiven(root, "encoder_max_age_ms", [&](const JsonView& v) {
               return reader.Number(v, FromUpTo(0.0, limits::kMaxEncoderAge_ms),
                                    choice.max_age_ms.emplace());
           });
}

bool ReadRequest(Reader& reader, const JsonView& root, FlareRequest& request) {
    std::optional<JsonView> image, lights;
    return reader.Object(
               root,
               {"lens",    "prescription", "coatings",       "f_number",     "focus_m",
                "zoom_mm", "iris",         "image",          "lights",       "layers",
                "units",   "color_space",  "wavelengths_nm", "quality",      "model",
                "output",  "starburst",    "encoder",        "encoder_time", "encoder_max_age_ms",
                "camera",  "split",        "artist",         "visible"},
               {}) &&
           ReadEncoder(reader, root, request.encoder) &&
           ReadLensChoice(reader, root, request.lens, request.encoder.has_value()) &&
           IfGiven(root, "iris",
                   [&](const JsonView& v) { return ReadIris(reader, v, request.iris); }) &&
           reader.Require(root, "image", image) && ReadImage(reader, *image, request.image) &&
           ReadColor(reader, root, request) &&
           CheckPictureSize(reader, *image, request.image,
                            std::max<std::size_t>(3, request.wavelengths_nm.size())) &&
           IfGiven(root, "layers",
                   [&](const JsonView& v) { return ReadLayers(reader, v, request.layers); }) &&
           IfGiven(
               root, "starburst",
               [&](const JsonView& v) { return ReadStarburst(reader, v, request.starburst); }) &&
           IfGiven(root, "quality",
                   [&](const JsonView& v) { return ReadQuality(reader, v, request.quality); }) &&
           reader.Require(root, "lights", lights) &&
           ReadLights(reader, *lights, request.color_space == ColorSpace::kSpectral,
                      request.lights) &&
           IfGiven(root, "split",
                   [&](const JsonView& v) { return ReadSplit(reader, v, request); }) &&
           IfGiven(root, "artist",
                   [&](const JsonView& v) { return ReadArtist(reader, v, request); }) &&
           IfGiven(root, "units",
                   [&](const JsonView& v) {
                       return reader.OneOf<Units>(v,
                                                  {{"scene_linear", Units::kSceneLinear},
                                                   {"sensor_irradiance", Units::kSensorIrradiance}},
                                                  request.units);
                   }) &&
           IfGiven(root, "model",
                   [&](const JsonView& v) { return ReadModel(reader, v, request.model); }) &&
           IfGiven(root, "visible",
                   [&](const JsonView& v) {
                       return ReadVisible(reader, v, request.visible.emplace());
                   }) &&
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
