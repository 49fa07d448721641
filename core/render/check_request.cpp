// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/render/check_layers.h"
#include "core/render/lights.h"
#include "core/render/renderer.h"
#include "core/tracing/bounce_sequence.h"

namespace flare {
namespace {

Error Bad(std::string where, std::string message, std::string code = "bad_value") {
    return {std::move(code), std::move(message), std::move(where)};
}

// Room for sums of lights; the wire has 1e30.
constexpr double kMaxIrradiance = 1e300;

bool Finite(const Vec3d& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

std::optional<Error> CheckWindow(const ImageSpec& image) {
    if (image.crop) {
        const auto& [x, y, w, h] = *image.crop;
        if (x < 0 || y < 0 || w < 1 || h < 1 || w > image.width - x || h > image.height - y) {
            return Bad("/image/crop", "the crop must be a non-empty window inside the frame");
        }
    }
    for (std::size_t i = 0; i < 4; ++i) {
        if (image.overscan[i] < 0 || image.overscan[i] > kMaxImageSide) {
            return Bad("/image/overscan/" + std::to_string(i),
                       "overscan must be 0 to " + std::to_string(kMaxImageSide) + " pixels");
        }
    }
    const bool overscans = std::any_of(image.overscan.begin(), image.overscan.end(),
                                       [](int pixels) { return pixels > 0; });
    if (image.crop && overscans)
        return Bad("/image/overscan", "crop and overscan exclude each other");
    return std::nullopt;
}

// Width and height of what is drawn: the crop, or the frame with its overscan.
std::pair<long long, long long> DrawnSize(const ImageSpec& image) {
    if (image.crop) return {(*image.crop)[2], (*image.crop)[3]};
    return {image.width + image.overscan[0] + image.overscan[2],
            image.height + image.overscan[1] + image.overscan[3]};
}

std::optional<Error> CheckImage(const ImageSpec& image, int channels) {
    for (const auto& [side, where] :
         {std::pair{image.width, "/image/width"}, {image.height, "/image/height"}}) {
        if (side < 1) return Bad(where, "must be at least 1 pixel");
        if (side > kMaxImageSide) {
            return Bad(where, "must be at most " + std::to_string(kMaxImageSide) + " pixels",
                       "too_large");
        }
    }
    if (!(image.sensor_width_mm > 0.0) || !(image.sensor_width_mm <= 1e4)) {
        return Bad("/image/sensor_width_mm", "must be above 0 and at most 10000 mm");
    }
    if (!(image.pixel_aspect >= 1e-2) || !(image.pixel_aspect <= 1e2)) {
        return Bad("/image/pixel_aspect", "must be 0.01 to 100");
    }
    for (const double offset : {image.center_offset_mm.x, image.center_offset_mm.y}) {
        if (!(std::abs(offset) <= 1e4))
            return Bad("/image/center_offset_mm", "must be within +-10000 mm");
    }
    if (auto error = CheckWindow(image)) return error;
    const auto [width, height] = DrawnSize(image);
    if (width * height * std::max(1, channels / 3) > kMaxImagePixels) {
        return Bad("/image",
                   "the picture has more than " + std::to_string(kMaxImagePixels) + " pixels",
                   "too_large");
    }
    return std::nullopt;
}

std::optional<Error> CheckLight(const LightSpec& light, std::size_t index, bool spectral) {
    const std::string place = "/lights/" + std::to_string(index);
    if (light.direction.has_value() == light.pixel.has_value()) {
        return Bad(place, "a light has either a direction or a pixel");
    }
    if (light.direction) {
        const Vec3d& d = *light.direction;
        if (!Finite(d)) return Bad(place + "/direction", "must be finite");
        if (d.x == 0.0 && d.y == 0.0 && d.z == 0.0)
            return Bad(place + "/direction", "must not be zero");
    }
    if (light.pixel && !(std::abs(light.pixel->x) <= 1e6 && std::abs(light.pixel->y) <= 1e6)) {
        return Bad(place + "/pixel", "must be within +-1000000");
    }
    if (light.distance_m && !(*light.distance_m > 0.0 && std::isfinite(*light.distance_m))) {
        return Bad(place + "/distance_m", "must be above 0");
    }
    for (const double e : {light.irradiance.x, light.irradiance.y, light.irradiance.z}) {
        if (!(e >= 0.0 && e <= kMaxIrradiance)) {
            return Bad(place + "/irradiance", "must be 0 to 1e300");
        }
    }
    if (light.temperature_k &&
        !(*light.temperature_k >= kMinTemperature_k && *light.temperature_k <= kMaxTemperature_k)) {
        return Bad(place + "/temperature_k", "must be 500 to 1000000");
    }
    if (light.temperature_k && light.spectrum) {
        return Bad(place + "/spectrum", "a light has a temperature or a spectrum, not both");
    }
    if (spectral && (light.temperature_k || light.spectrum)) {
        return Bad(
            place + (light.spectrum ? "/spectrum" : "/temperature_k"),
            "a spectral picture holds each wavelength for irradiance 1: nothing is weighted");
    }
    return std::nullopt;
}

std::optional<Error> CheckStarburst(const FlareRequest& request) {
    if (!request.layers.ghosts && !request.layers.starburst && !request.layers.bokeh)
        return Bad("/layers", "no layer is asked for");
    const StarburstSpec& spec = request.starburst;
    if (!(spec.jitter_deg >= 0.0 && spec.jitter_deg <= kMaxJitter_deg)) {
        return Bad("/starburst/jitter_deg", "must be 0 to 180");
    }
    if (spec.jitter_count < 1 || spec.jitter_count > kMaxJitterCount) {
        return Bad("/starburst/jitter_count", "must be 1 to " + std::to_string(kMaxJitterCount));
    }
    for (std::size_t i = 0; i < request.lights.size(); ++i) {
        const double diameter = request.lights[i].angular_diameter_deg;
        const std::string place = "/lights/" + std::to_string(i) + "/angular_diameter_deg";
        if (!(diameter >= 0.0 && diameter <= kMaxAngularDiameter_deg)) {
            return Bad(place, "must be 0 to 20");
        }
        if (request.lights[i].shape && !(diameter > 0.0)) {
            return Bad("/lights/" + std::to_string(i) + "/shape",
                       "a shape needs its width, angular_diameter_deg");
        }
        if (diameter > 0.0 && request.layers.bokeh) {
            return Bad(place, "the bokeh of lights that are no points is not built", "unsupported");
        }
    }
    return std::nullopt;
}

std::optional<Error> CheckWavelengths(const FlareRequest& request) {
    if (request.color != ColorMode::kSpectral) return std::nullopt;
    if (request.camera) return Bad("/camera", "a camera goes with a colour picture");
    const std::vector<double>& list = request.wavelengths_nm;
    if (list.empty())
        return Bad("/wavelengths_nm", "a spectral request names at least one wavelength");
    if (list.size() > static_cast<std::size_t>(kMaxWavelengths)) {
        return Bad("/wavelengths_nm",
                   "at most " + std::to_string(kMaxWavelengths) + " wavelengths");
    }
    for (std::size_t i = 0; i < list.size(); ++i) {
        const std::string place = "/wavelengths_nm/" + std::to_string(i);
        if (!(list[i] >= 300.0 && list[i] <= 1100.0)) return Bad(place, "must be 300 to 1100 nm");
        if (std::count(list.begin(), list.end(), list[i]) > 1) return Bad(place, "is named twice");
    }
    return std::nullopt;
}

std::optional<Error> CheckQuality(const Quality& quality) {
    const auto given = [](const std::optional<double>& value) { return value ? 1 : 0; };
    if (given(quality.tolerance) + given(quality.max_error) + given(quality.time_budget_ms) > 1) {
        return Bad("/quality", "names more than one of tolerance, max_error and time_budget_ms");
    }
    const auto within = [](const std::optional<double>& value) {
        return !value || (*value >= kMinTolerance && *value <= kMaxTolerance);
    };
    if (!within(quality.tolerance)) return Bad("/quality/tolerance", "must be 0.001 to 0.25");
    if (!within(quality.max_error)) return Bad("/quality/max_error", "must be 0.001 to 0.25");
    if (quality.time_budget_ms &&
        !(*quality.time_budget_ms > 0.0 && *quality.time_budget_ms <= kMaxTimeBudget_ms)) {
        return Bad("/quality/time_budget_ms", "must be above 0 and at most 600000");
    }
    return std::nullopt;
}

std::optional<Error> CheckModel(const FlareRequest& request) {
    const ModelSpec& model = request.model;
    if (model.reflections != 2 && model.reflections != 4) {
        return Bad("/model/reflections", "must be 2 or 4");
    }
    if (!(model.four_reflection_threshold > 0.0 &&
          model.four_reflection_threshold <= kMaxFourReflectionThreshold)) {
        return Bad("/model/four_reflection_threshold", "must be above 0 and at most 1000000");
    }
    if (model.sensor_reflection && !request.lens->sensor()) {
        return Bad("/model/sensor_reflection",
                   "the lens \"" + request.lens->name() +
                       "\" has no reflecting sensor: its last surface is not of kind \"sensor\"");
    }
    return std::nullopt;
}

std::optional<Error> CheckPhoton(const FlareRequest& request, long long values) {
    if (!request.photon) return std::nullopt;
    const PhotonSpec& spec = *request.photon;
    if (request.quality != QualityPreset::kReference) {
        return Bad("/quality/method", "photons are a method of the preset \"reference\"");
    }
    if (request.model.reflections == 4) {
        return Bad("/model/reflections", "photons of four reflections are not built",
                   "unsupported");
    }
    if (spec.samples < kMinPhotonSamples || spec.samples > kMaxPhotonSamples) {
        return Bad("/quality/samples", "must be 64 to 100000000");
    }
    if (!(spec.kernel_px >= kMinPhotonKernel_px && spec.kernel_px <= kMaxPhotonKernel_px)) {
        return Bad("/quality/kernel_px", "must be 0.5 to 64");
    }
    if (spec.nearest < kMinPhotonNearest || spec.nearest > kMaxPhotonNearest) {
        return Bad("/quality/nearest", "must be 2 to 10000");
    }
    if (static_cast<double>(values) > kMaxPhotonValues) {
        return Bad("/image", "a picture by photons has at most 16777216 pixels times channels",
                   "limit");
    }
    const double passes = request.color == ColorMode::kSpectral
                              ? static_cast<double>(request.wavelengths_nm.size())
                              : 1;
    const double ghosts = static_cast<double>(
        TwoReflectionSequences(*request.lens, request.model.sensor_reflection).size());
    if (ghosts * static_cast<double>(request.lights.size()) > kMaxPhotonPaths) {
        return Bad("/lights", "photons take at most 65536 ghosts of all lights together", "limit");
    }
    if (ghosts * passes * static_cast<double>(request.lights.size()) *
            static_cast<double>(spec.samples) >
        kMaxPhotonRays) {
        return Bad("/quality/samples",
                   "samples times ghosts, lights and wavelengths are more than 2e10 rays", "limit");
    }
    return std::nullopt;
}

}  // namespace

std::optional<Error> CheckRequest(const FlareRequest& request) {
    if (request.lens == nullptr) return Bad("/lens", "a request names a lens");
    if (request.f_number && !(*request.f_number > 0.0 && *request.f_number <= 1e4)) {
        return Bad("/f_number", "must be above 0 and at most 10000");
    }
    if (auto error = CheckModel(request)) return error;
    if (auto error = CheckStarburst(request)) return error;
    if (auto error = CheckQuality(request.quality)) return error;
    if (auto error = CheckLayers(request)) return error;
    const IrisShape& iris = request.iris;
    if (iris.blades != 0 && (iris.blades < 3 || iris.blades > 32)) {
        return Bad("/iris/blades", "must be 0 (round) or 3 to 32");
    }
    if (!(iris.roundness >= 0.0 && iris.roundness <= 1.0))
        return Bad("/iris/roundness", "must be 0 to 1");
    if (!(std::abs(iris.rotation_deg) <= 36'000.0)) {
        return Bad("/iris/rotation_deg", "must be within +-36000 degrees");
    }
    if (!(iris.irregularity >= 0.0 && iris.irregularity <= 1.0))
        return Bad("/iris/irregularity", "must be 0 to 1");
    if (iris.mask && !(iris.mask->area_mm2() > 0.0)) return Bad("/iris/mask", "lets no light pass");
    const int channels =
        request.color == ColorMode::kSpectral
            ? static_cast<int>(std::min<std::size_t>(request.wavelengths_nm.size(), 100'000))
            : 3;
    if (auto error = CheckImage(request.image, channels)) return error;
    // Files cannot say more, and a lens's sections can differ by any factor.
    const double shown_aspect = ShownPixelAspect(request);
    if (!(shown_aspect >= 1e-4) || !(shown_aspect <= 1e4)) {
        return Bad("/image/pixel_aspect",
                   "with the lens's squeeze the picture's pixel aspect is not within 0.0001 to "
                   "10000");
    }
    if (auto error = CheckWavelengths(request)) return error;
    if (request.lights.size() > static_cast<std::size_t>(kMaxLights)) {
        return Bad("/lights", "at most " + std::to_string(kMaxLights) + " lights", "too_large");
    }
    for (std::size_t i = 0; i < request.lights.size(); ++i) {
        if (auto error = CheckLight(request.lights[i], i, request.color == ColorMode::kSpectral))
            return error;
    }
    const auto [w, h] = DrawnSize(request.image);
    return CheckPhoton(request, w * h * channels);
}

}  // namespace flare
