// SPDX-License-Identifier: Apache-2.0
#include "server/translate/request_from_wire.h"

namespace flare {
namespace {

// Grows with every change of what the values mean or of their order here.
constexpr int kHashVersion = 1;

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
    hash.Add(static_cast<int>(image.projection));
}

void Add(Fingerprinter& hash, const wire::Light& light) {
    Add(hash, light.direction);
    Add(hash, light.pixel);
    Add(hash, light.distance_m);
    Add(hash, light.irradiance);
}

// What the picture and its header take from a lens beyond its surfaces.
void Add(Fingerprinter& hash, const Lens& lens) {
    const Prescription& prescription = lens.prescription();
    hash.Add(lens.fingerprint()).Add(lens.name()).Add(prescription.maker);
    hash.Add(prescription.fisheye);
    Add(hash, prescription.design_focal_mm);
}

}  // namespace

Fingerprint RequestHash(const wire::FlareRequest& request, const Lens& lens) {
    Fingerprinter hash;
    hash.Add("flare-request").Add(kHashVersion);
    Add(hash, lens);
    hash.Add(request.bare_glass);
    Add(hash, request.f_number);
    hash.Add(request.iris.blades).Add(request.iris.roundness).Add(request.iris.rotation_deg);
    Add(hash, request.image);
    hash.Add(static_cast<std::int64_t>(request.lights.size()));
    for (const wire::Light& light : request.lights) Add(hash, light);
    hash.Add(static_cast<int>(request.units)).Add(static_cast<int>(request.color_space));
    hash.Add(static_cast<std::int64_t>(request.wavelengths_nm.size()));
    for (const double wavelength_nm : request.wavelengths_nm) hash.Add(wavelength_nm);
    hash.Add(static_cast<int>(request.preset)).Add(static_cast<int>(request.ringing));
    hash.Add(static_cast<int>(request.output.compression));
    hash.Add(static_cast<int>(request.output.pixel));
    return hash.value();
}

}  // namespace flare
