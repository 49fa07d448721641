// SPDX-License-Identifier: Apache-2.0
//
// A small picture of a random lens: the bytes choose lens, iris, lights, frame and quality.
// Whatever they choose is refused in words or drawn with finite numbers, and what is light is not
// negative.
#include <fuzzer/FuzzedDataProvider.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "core/base/check.h"
#include "core/render/renderer.h"
#include "tests/support/random_lens.h"

namespace flare {
namespace {

// random_lens.h's numbers from the fuzzer's bytes: two bytes a number keep inputs short.
class Bytes {
  public:
    Bytes(const std::uint8_t* data, std::size_t size) : bytes_(data, size) {}

    double Uniform(double lo, double hi) {
        return lo + (hi - lo) * (bytes_.ConsumeIntegral<std::uint16_t>() / 65535.0);
    }
    int Below(int count) { return bytes_.ConsumeIntegralInRange(0, count - 1); }
    bool OneIn(int count) { return Below(count) == count - 1; }

  private:
    FuzzedDataProvider bytes_;
};

double OneOf(Bytes& bytes, std::initializer_list<double> values) {
    return values.begin()[bytes.Below(static_cast<int>(values.size()))];
}

LightSpec AnyLight(Bytes& bytes) {
    LightSpec light;
    if (bytes.OneIn(4)) {
        light.pixel = Vec2d(bytes.Uniform(-20.0, 40.0), bytes.Uniform(-20.0, 40.0));
    } else {
        const double field = bytes.OneIn(4)
                                 ? OneOf(bytes, {0.0, 1e-9, 1.5607, 1.5707963, 3.1415927})
                                 : bytes.Uniform(0.0, 0.6);
        const double azimuth = bytes.OneIn(2) ? 0.0 : bytes.Uniform(-3.2, 3.2);
        light.direction = Vec3d(std::sin(field) * std::cos(azimuth),
                                std::sin(field) * std::sin(azimuth), std::cos(field));
    }
    if (bytes.OneIn(3)) light.distance_m = std::exp(bytes.Uniform(-7.0, 40.0));
    const double e = bytes.OneIn(4) ? OneOf(bytes, {0.0, 1e-300, 1e-40, 1e30}) : 1.0;
    light.irradiance = Vec3d(e, e, e);
    if (bytes.OneIn(4)) light.angular_diameter_deg = bytes.Uniform(0.0, 5.0);
    return light;
}

FlareRequest AnyRequest(Bytes& bytes, std::shared_ptr<const Lens> lens) {
    FlareRequest request;
    request.lens = std::move(lens);
    request.image.width = 1 + bytes.Below(24);
    request.image.height = 1 + bytes.Below(24);
    request.image.sensor_width_mm = std::exp(bytes.Uniform(-4.0, 6.0));
    if (bytes.OneIn(4)) request.image.pixel_aspect = std::exp(bytes.Uniform(-4.0, 4.0));
    if (bytes.OneIn(2)) request.f_number = std::exp(bytes.Uniform(-1.0, 6.0));
    if (bytes.OneIn(2)) {
        request.iris.blades = 3 + bytes.Below(30);
        request.iris.roundness = bytes.Uniform(0.0, 1.0);
        request.iris.rotation_deg = bytes.Uniform(-400.0, 400.0);
        request.iris.irregularity = bytes.Uniform(0.0, 1.0);
    }
    if (bytes.OneIn(2)) {
        request.color = ColorMode::kSpectral;
        request.wavelengths_nm = {bytes.Uniform(300.0, 1100.0)};
    }
    request.units = bytes.OneIn(2) ? Units::kSceneLinear : Units::kSensorIrradiance;
    request.model.ringing = bytes.OneIn(4);
    if (bytes.OneIn(6)) {
        request.model.reflections = 4;
        request.model.four_reflection_threshold = 0.1;
    }
    const double tolerances[] = {0.25, 0.05};
    request.quality = Quality::Tolerance(tolerances[bytes.Below(2)]);
    request.layers.bokeh = bytes.OneIn(8);
    for (int n = bytes.Below(2); n >= 0; --n) request.lights.push_back(AnyLight(bytes));
    return request;
}

void ExpectSound(const FlareRequest& request, const Rendering& rendering) {
    // Colours outside the gamut have negative channels; a wavelength's light has not, but for what
    // running sums of floats leave over around blurred sources.
    const bool blurred =
        std::any_of(request.lights.begin(), request.lights.end(),
                    [](const LightSpec& light) { return light.angular_diameter_deg > 0.0; });
    const bool may_be_negative = blurred || request.color != ColorMode::kSpectral;
    for (const ImagePlane& plane : rendering.image.planes) {
        for (const float value : plane.values) {
            FLARE_CHECK(std::isfinite(value) && (may_be_negative || value >= 0.0F));
        }
    }
    for (const GhostFacts& ghost : rendering.report.facts.ghosts) {
        FLARE_CHECK(std::isfinite(ghost.flux_mm2) && ghost.flux_mm2 >= 0.0);
    }
}

}  // namespace
}  // namespace flare

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace flare;
    if (size > 512) return 0;
    Bytes bytes(data, size);
    testing::RandomLensKind kind;
    kind.most_surfaces = 3;
    kind.any_shape = bytes.OneIn(3);
    kind.dispersion = bytes.OneIn(2);
    kind.coatings = bytes.OneIn(2);
    const auto lens = Lens::Build(testing::RandomPrescription(bytes, kind));
    if (!lens) {
        FLARE_CHECK(!lens.error().message.empty());
        return 0;
    }
    const FlareRequest request = AnyRequest(bytes, *lens);
    static ThreadPool threads(1);
    TracingMeshProvider meshes;
    const Result<Rendering> rendering =
        Render(request, {threads, meshes, CancelToken(), [] { return 0.0; }});
    if (!rendering) {
        FLARE_CHECK(!rendering.error().message.empty() && !rendering.error().code.empty());
        return 0;
    }
    ExpectSound(request, *rendering);
    return 0;
}
