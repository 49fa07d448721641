// SPDX-License-Identifier: Apache-2.0
#include "server/translate/request_from_wire.h"

namespace flare {
namespace {

// Grows with every change of what the values mean or of their order here.
constexpr int kHashVersion = 5;

void Add(Fingerprinter& hash, const std::optional<double>& value) {
    hash.Add(value.has_value());
    if (value) hash.Add(*value);
}

template <class T, std::size_t N>
void Add(Fingerprinter& hash, const std::array<T, N>& values) {
    for (const T& value : values) hash.Add(value);
}

template <class T, std::size_t N>
void Add(Fingerprinter& hash, const std::optional<std::array<T, N>>& values) {
    hash.Add(values.has_value());
    if (values) Add(hash, *values);
}

void Add(Fingerprinter& hash, const wire::Image& image) {
    hash.Add(image.width).Add(image.height).Add(image.sensor_width_mm);
    Add(hash, image.center_offset_mm);
    hash.Add(image.pixel_aspect);
    Add(hash, image.crop);
    Add(hash, image.overscan);
    hash.Add(static_cast<int>(image.projection)).Add(image.desqueeze);
}

void Add(Fingerprinter& hash, const std::optional<std::string>& text) {
    hash.Add(text.has_value());
    if (text) hash.Add(*text);
}

void Add(Fingerprinter& hash, const wire::Coatings& coatings) {
    hash.Add(coatings.none);
    Add(hash, coatings.default_name);
    hash.Add(static_cast<std::int64_t>(coatings.surfaces.size()));
    for (const auto& [surface, name] : coatings.surfaces) hash.Add(surface).Add(name);
}

void Add(Fingerprinter& hash, const wire::Quality& quality) {
    hash.Add(static_cast<int>(quality.preset));
    Add(hash, quality.tolerance);
    Add(hash, quality.max_error);
    Add(hash, quality.time_budget_ms);
    hash.Add(quality.photon.has_value());
    if (!quality.photon) return;
    const wire::Photon& photon = *quality.photon;
    hash.Add(photon.samples).Add(photon.seed).Add(static_cast<int>(photon.estimate));
    hash.Add(photon.kernel_px).Add(photon.nearest);
}

void Add(Fingerprinter& hash, const wire::Iris& iris) {
    hash.Add(iris.blades).Add(iris.roundness).Add(iris.rotation_deg);
    if (iris.irregularity > 0.0) hash.Add("irregular").Add(iris.irregularity).Add(iris.seed);
    if (iris.dust) {
        hash.Add("dust").Add(iris.dust->count).Add(iris.dust->size_mm);
        hash.Add(iris.dust->opacity).Add(iris.dust->seed);
    }
    if (iris.scratches) {
        hash.Add("scratches").Add(iris.scratches->count).Add(iris.scratches->length_mm);
        hash.Add(iris.scratches->width_mm).Add(iris.scratches->opacity).Add(iris.scratches->seed);
    }
    if (iris.mask) hash.Add("mask").Add(iris.mask->png).Add(static_cast<int>(iris.mask->scale));
}

void Add(Fingerprinter& hash, const wire::Model& model) {
    hash.Add(model.reflections).Add(model.four_reflection_threshold);
    hash.Add(model.sensor_reflection).Add(static_cast<int>(model.ringing));
    hash.Add(static_cast<int>(model.culling));
}

void Add(Fingerprinter& hash, const std::vector<double>& values) {
    hash.Add(static_cast<std::int64_t>(values.size()));
    for (const double value : values) hash.Add(value);
}

void Add(Fingerprinter& hash, const wire::Light& light) {
    Add(hash, light.direction);
    Add(hash, light.pixel);
    Add(hash, light.distance_m);
    Add(hash, light.irradiance);
    hash.Add(light.angular_diameter_deg);
    if (light.shape_png) hash.Add("shape").Add(*light.shape_png);
    Add(hash, light.temperature_k);
    hash.Add(light.spectrum.has_value());
    if (light.spectrum) {
        Add(hash, light.spectrum->wavelengths_nm);
        Add(hash, light.spectrum->values);
    }
}

void Add(Fingerprinter& hash, const wire::Starburst& starburst) {
    hash.Add(starburst.core).Add(starburst.jitter_deg);
    hash.Add(starburst.jitter_count).Add(starburst.seed);
}

void Add(Fingerprinter& hash, const wire::ArtistGhost& ghost) {
    hash.Add(static_cast<std::int64_t>(ghost.sequence.size()));
    for (const int surface : ghost.sequence) hash.Add(surface);
    hash.Add(ghost.gain);
    Add(hash, ghost.tint);
    hash.Add(ghost.mute);
}

// What the picture and its header take from a lens beyond its surfaces.
void Add(Fingerprinter& hash, const Lens& lens) {
    const Prescription& prescription = lens.prescription();
    hash.Add(lens.fingerprint()).Add(lens.name()).Add(prescription.maker);
    hash.Add(prescription.fisheye);
    Add(hash, prescription.design_focal_mm);
    hash.Add(static_cast<int>(prescription.design_section));
}

// What became of the state that was asked for: the lens's range decides, and that is no part of the
// lens as it was set.
void AddState(Fingerprinter& hash, const FlareRequest& translated) {
    Add(hash, translated.state.focus_m);
    Add(hash, translated.state.zoom_mm);
    hash.Add(static_cast<std::int64_t>(translated.state_clamped.size()));
    for (const StateClamp& clamp : translated.state_clamped) {
        hash.Add(clamp.field).Add(clamp.from).Add(clamp.to);
    }
}

}  // namespace

Fingerprint RequestHash(const wire::FlareRequest& request, const FlareRequest& translated) {
    Fingerprinter hash;
    hash.Add("flare-request").Add(kHashVersion);
    Add(hash, *translated.lens);
    AddState(hash, translated);
    Add(hash, request.lens.coatings);
    Add(hash, request.lens.f_number);
    Add(hash, request.lens.focus_m);
    Add(hash, request.lens.zoom_mm);
    Add(hash, request.iris);
    Add(hash, request.image);
    hash.Add(static_cast<std::int64_t>(request.lights.size()));
    for (const wire::Light& light : request.lights) Add(hash, light);
    hash.Add(static_cast<int>(request.units)).Add(static_cast<int>(request.color_space));
    Add(hash, request.wavelengths_nm);
    hash.Add(request.camera.has_value());
    if (request.camera) {
        Add(hash, request.camera->wavelengths_nm);
        Add(hash, request.camera->red);
        Add(hash, request.camera->green);
        Add(hash, request.camera->blue);
    }
    Add(hash, request.quality);
    Add(hash, request.model);
    hash.Add(request.layers.ghosts).Add(request.layers.starburst);
    if (request.layers.starburst) Add(hash, request.starburst);
    hash.Add(static_cast<int>(request.output.compression));
    hash.Add(static_cast<int>(request.output.pixel));
    if (request.layers.bokeh) hash.Add("bokeh");
    if (request.split != wire::Split::kNone) {
        hash.Add("split").Add(static_cast<int>(request.split));
    }
    if (request.visible) {
        hash.Add("visible").Add(request.visible->exposure_stops).Add(request.visible->noise_floor);
    }
    if (!request.artist.empty()) {
        hash.Add("artist").Add(static_cast<std::int64_t>(request.artist.size()));
        for (const wire::ArtistGhost& ghost : request.artist) Add(hash, ghost);
    }
    return hash.value();
}

}  // namespace flare
