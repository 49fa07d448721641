// SPDX-License-Identifier: Apache-2.0
#include "core/render/light_meshes.h"

#include <algorithm>

#include "core/render/quality.h"
#include "core/spectrum/wavelength_plan.h"

namespace flare {
namespace {

// A direct image may be smaller than a pixel, and there is but one a light.
constexpr double kDirectTolerance_mm = 0.002, kDirectMaskTolerance = 0.002;

// Few wavelengths are traced exactly; for more, positions come from a few traced nodes.
std::vector<double> TracedNodes(const FlareRequest& request, const QualitySettings& settings) {
    if (request.color != ColorMode::kSpectral) {
        return ChebyshevNodes(kTracedLow_nm, kTracedHigh_nm, settings.traced_wavelengths);
    }
    const std::vector<double>& list = request.wavelengths_nm;
    if (list.size() <= 3) return list;
    const auto [lo, hi] = std::minmax_element(list.begin(), list.end());
    return ChebyshevNodes(*lo, *hi, 4);
}

}  // namespace

void SetQuality(const QualitySettings& settings, MeshSpec& spec) {
    spec.wavelengths_nm =
        ChebyshevNodes(kTracedLow_nm, kTracedHigh_nm, settings.traced_wavelengths);
    spec.cells = settings.mesh_cells;
    spec.arithmetic = settings.arithmetic;
    spec.patch_cells = settings.patch_cells;
    spec.position_tolerance_mm = settings.position_tolerance_mm;
    spec.mask_tolerance = settings.mask_tolerance;
}

MeshSpec MeshSpecFor(const FlareRequest& request, const BounceSequence& sequence,
                     const PlacedLight& light) {
    const QualitySettings settings = SettingsOf(request);
    MeshSpec spec = MeshSpecOf(sequence, light);
    SetQuality(settings, spec);
    spec.wavelengths_nm = TracedNodes(request, settings);
    if (sequence.empty()) {
        spec.position_tolerance_mm = std::min(spec.position_tolerance_mm, kDirectTolerance_mm);
        spec.mask_tolerance = std::min(spec.mask_tolerance, kDirectMaskTolerance);
        spec.arithmetic = MeshArithmetic::kDouble;
    }
    return spec;
}

std::vector<MeshSpec> MeshSpecsFor(const FlareRequest& request, const PlacedLight& light) {
    std::vector<MeshSpec> specs;
    for (const BounceSequence& sequence :
         TwoReflectionSequences(*request.lens, request.model.sensor_reflection)) {
        specs.push_back(MeshSpecFor(request, sequence, light));
    }
    return specs;
}

}  // namespace flare
