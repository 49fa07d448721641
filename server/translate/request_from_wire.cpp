// SPDX-License-Identifier: Apache-2.0
#include "server/translate/request_from_wire.h"

#include <algorithm>
#include <cmath>

#include "core/optics/stop_dirt.h"
#include "core/spectrum/light_spectrum.h"
#include "core/spectrum/sampled_curve.h"
#include "server/translate/lens_from_wire.h"
#include "server/translate/mask_from_wire.h"

namespace flare {
namespace {

Projection ProjectionFromWire(wire::Projection projection) {
    switch (projection) {
        case wire::Projection::kDefault:
            return Projection::kAuto;
        case wire::Projection::kRectilinear:
            return Projection::kRectilinear;
        case wire::Projection::kLens:
            return Projection::kLens;
    }
    return Projection::kAuto;
}

QualityPreset PresetFromWire(wire::Preset preset) {
    switch (preset) {
        case wire::Preset::kDraft:
            return QualityPreset::kDraft;
        case wire::Preset::kPreview:
            return QualityPreset::kPreview;
        case wire::Preset::kFinal:
            return QualityPreset::kFinal;
        case wire::Preset::kReference:
            return QualityPreset::kReference;
    }
    return QualityPreset::kPreview;
}

ImageSpec ImageFromWire(const wire::Image& image) {
    ImageSpec spec;
    spec.width = image.width;
    spec.height = image.height;
    spec.sensor_width_mm = image.sensor_width_mm;
    spec.center_offset_mm = Vec2d(image.center_offset_mm[0], image.center_offset_mm[1]);
    spec.pixel_aspect = image.pixel_aspect;
    spec.crop = image.crop;
    spec.overscan = image.overscan;
    spec.projection = ProjectionFromWire(image.projection);
    spec.desqueeze = image.desqueeze;
    return spec;
}

CullingRule CullingFromWire(wire::Culling culling) {
    switch (culling) {
        case wire::Culling::kAuto:
            return CullingRule::kAuto;
        case wire::Culling::kNone:
            return CullingRule::kNone;
        case wire::Culling::kReport:
            return CullingRule::kReport;
    }
    return CullingRule::kAuto;
}

ModelSpec ModelFromWire(const wire::Model& model) {
    return {model.reflections, model.four_reflection_threshold, model.sensor_reflection,
            CullingFromWire(model.culling), model.ringing == wire::Ringing::kAuto};
}

PhotonSpec PhotonFromWire(const wire::Photon& photon) {
    PhotonSpec spec;
    spec.samples = photon.samples;
    spec.seed = static_cast<std::uint64_t>(photon.seed);
    spec.estimate = photon.estimate == wire::PhotonEstimate::kPixel    ? PhotonEstimate::kPixel
                    : photon.estimate == wire::PhotonEstimate::kKernel ? PhotonEstimate::kKernel
                                                                       : PhotonEstimate::kNearest;
    spec.kernel_px = photon.kernel_px;
    spec.nearest = photon.nearest;
    return spec;
}

ColorMode ColorFromWire(wire::ColorSpace space) {
    switch (space) {
        case wire::ColorSpace::kLinRec709:
            return ColorMode::kLinRec709;
        case wire::ColorSpace::kAcesCg:
            return ColorMode::kAcesCg;
        case wire::ColorSpace::kAces2065:
            return ColorMode::kAces2065;
        case wire::ColorSpace::kSpectral:
            return ColorMode::kSpectral;
    }
    return ColorMode::kLinRec709;
}

// Of luminance 1. Scaled first, so that no sum overflows or vanishes.
std::shared_ptr<const Spectrum> SpectrumFromWire(const wire::SampledSpectrum& curve) {
    std::vector<double> values = curve.values;
    const double largest = *std::max_element(values.begin(), values.end());
    for (double& value : values) value /= largest;
    Spectrum power = SpectrumOfCurve(curve.wavelengths_nm, values);
    const double luminance = Luminance(power);
    if (!(luminance > 0.0)) return nullptr;
    for (double& value : power) value /= luminance;
    return std::make_shared<const Spectrum>(power);
}

SplitBy SplitFromWire(wire::Split split) {
    switch (split) {
        case wire::Split::kNone:
            return SplitBy::kNone;
        case wire::Split::kGhost:
            return SplitBy::kGhost;
        case wire::Split::kLight:
            return SplitBy::kLight;
    }
    return SplitBy::kNone;
}

// Null: clean.
std::shared_ptr<const StopPicture> DirtFromWire(const wire::Iris& iris, const Lens& lens) {
    StopDust dust;
    if (iris.dust) {
        dust = {iris.dust->count, iris.dust->size_mm, iris.dust->opacity,
                static_cast<std::uint64_t>(iris.dust->seed)};
    }
    StopScratches scratches;
    if (iris.scratches) {
        const wire::IrisScratches& of = *iris.scratches;
        scratches = {of.count, of.length_mm, of.width_mm, of.opacity,
                     static_cast<std::uint64_t>(of.seed)};
    }
    const auto stop = static_cast<std::size_t>(lens.stop_index());
    const double rim_mm = lens.surfaces()[stop].semi_diameter_mm;
    return DirtyStop(MarksOf(dust, scratches, rim_mm), rim_mm);
}

LightSpec LightFromWire(const wire::Light& light) {
    LightSpec spec;
    if (light.direction) spec.direction = DirectionFromWire(*light.direction);
    if (light.pixel) spec.pixel = Vec2d((*light.pixel)[0], (*light.pixel)[1]);
    spec.distance_m = light.distance_m;
    spec.irradiance = Vec3d(light.irradiance[0], light.irradiance[1], light.irradiance[2]);
    spec.temperature_k = light.temperature_k;
    if (light.spectrum) spec.spectrum = SpectrumFromWire(*light.spectrum);
    spec.angular_diameter_deg = light.angular_diameter_deg;
    return spec;
}

}  // namespace

Vec3d DirectionFromWire(const std::array<double, 3>& direction) {
    const double largest =
        std::max({std::abs(direction[0]), std::abs(direction[1]), std::abs(direction[2])});
    Vec3d scaled(direction[0], direction[1], direction[2]);
    if (largest > 1e-100 && largest < 1e100) return scaled;
    const int exponent = std::ilogb(largest);
    return Vec3d(std::scalbn(scaled.x, -exponent), std::scalbn(scaled.y, -exponent),
                 std::scalbn(scaled.z, -exponent));
}

Result<FlareRequest> RequestFromWire(const wire::FlareRequest& request,
                                     const LensLibrary& library) {
    Result<LensInState> lens = LensFromWire(request.lens, library);
    if (!lens) return lens.error();

    FlareRequest translated;
    translated.lens = std::move(lens->lens);
    translated.state = lens->state;
    translated.state_clamped = std::move(lens->clamped);
    translated.model = ModelFromWire(request.model);
    translated.layers = {request.layers.ghosts, request.layers.starburst, request.layers.bokeh};
    translated.split = SplitFromWire(request.split);
    for (const wire::ArtistGhost& ghost : request.artist) {
        translated.artist.push_back({ghost.sequence, ghost.gain,
                                     Vec3d(ghost.tint[0], ghost.tint[1], ghost.tint[2]),
                                     ghost.mute});
    }
    const wire::Starburst& starburst = request.starburst;
    translated.starburst = {starburst.core, starburst.jitter_deg, starburst.jitter_count,
                            static_cast<std::uint64_t>(starburst.seed)};
    translated.f_number = request.lens.f_number;
    const wire::Iris& iris = request.iris;
    translated.iris = {iris.blades, iris.roundness, iris.rotation_deg, iris.irregularity,
                       static_cast<std::uint64_t>(iris.seed)};
    if (iris.mask) {
        Result<std::shared_ptr<const StopPicture>> mask = MaskFromWire(*iris.mask);
        if (!mask) return mask.error();
        translated.iris.mask = std::move(*mask);
        translated.iris.mask_scale =
            iris.mask->scale == wire::IrisMaskScale::kStop ? MaskScale::kStop : MaskScale::kArea;
    }
    if (std::shared_ptr<const StopPicture> dirt = DirtFromWire(iris, *translated.lens)) {
        translated.iris.mask = std::move(dirt);
        translated.iris.mask_scale = MaskScale::kStop;
    }
    translated.image = ImageFromWire(request.image);
    translated.lights.reserve(request.lights.size());
    for (const wire::Light& light : request.lights) {
        translated.lights.push_back(LightFromWire(light));
        if (light.shape_png) {
            Result<std::shared_ptr<const SourcePicture>> shape =
                ShapeFromWire(*light.shape_png, translated.lights.size() - 1);
            if (!shape) return shape.error();
            translated.lights.back().shape = std::move(*shape);
        }
        if (light.spectrum && !translated.lights.back().spectrum) {
            return Error{"bad_value", "the spectrum has no light that the eye sees",
                         "/lights/" + std::to_string(translated.lights.size() - 1) + "/spectrum"};
        }
    }
    translated.units =
        request.units == wire::Units::kSceneLinear ? Units::kSceneLinear : Units::kSensorIrradiance;
    translated.color = ColorFromWire(request.color_space);
    if (request.camera) {
        const wire::Camera& camera = *request.camera;
        const std::optional<ColorResponse> response =
            ResponseOf({camera.wavelengths_nm, camera.red, camera.green, camera.blue});
        if (!response) {
            return Error{"bad_value", "a channel of the camera sees nothing of white light",
                         "/camera"};
        }
        translated.camera = std::make_shared<const ColorResponse>(*response);
    }
    translated.wavelengths_nm = request.wavelengths_nm;
    translated.quality = PresetFromWire(request.quality.preset);
    translated.quality.tolerance = request.quality.tolerance;
    translated.quality.max_error = request.quality.max_error;
    translated.quality.time_budget_ms = request.quality.time_budget_ms;
    if (request.visible) {
        translated.visible = {request.visible->exposure_stops, request.visible->noise_floor};
    }
    if (request.quality.photon) translated.photon = PhotonFromWire(*request.quality.photon);
    return translated;
}

}  // namespace flare
