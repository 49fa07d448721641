// SPDX-License-Identifier: Apache-2.0
#include "core/render/quality.h"

#include <algorithm>

#include "core/spectrum/spectrum.h"

namespace flare {

QualitySettings SettingsOf(QualityPreset preset) {
    QualitySettings settings;
    switch (preset) {
        case QualityPreset::kDraft:
            settings = {16, 8, 0.1, 0.03, 3, 14, 16.0, 8, 5e-3, {0.2, 0.15, 4.0, 64.0, 0.15}};
            settings.tiles = {0.1, 0.15};
            settings.tolerance = 0.05;
            settings.blur_tolerance = 0.03;
            settings.most_blur_side = 2;
            settings.least_blur_px = 2.0;
            break;
        case QualityPreset::kPreview:
            settings = {32, 8, 0.03, 0.01, 3, 21, 9.0, 14, 2e-3, {0.1, 0.08, 3.0, 48.0, 0.06}};
            settings.tiles = {0.04, 0.05};
            break;
        case QualityPreset::kFinal:
            settings = {64, 8, 0.01, 0.004, 3, 41, 1.5, 64, 4e-4, {0.05, 0.02, 1.0, 32.0, 0.03}};
            settings.tiles = {0.01, 0.02};
            settings.tolerance = 0.005;
            settings.blur_tolerance = 0.0025;
            settings.most_blur_side = 8;
            settings.least_blur_px = 5.0;
            break;
        case QualityPreset::kReference:
            settings = {128, 8,    0.003, 0.001, 4,
                        81,  0.75, 128,   1e-4,  {0.02, 0.01, 0.5, 24.0, 0.015}};
            settings.arithmetic = MeshArithmetic::kDouble;
            settings.tolerance = 0.001;
            settings.culled_share = 0.0;
            settings.blur_tolerance = 5e-4;
            settings.most_blur_side = 16;
            settings.least_blur_px = 12.0;
            break;
    }
    return settings;
}

std::size_t MostCoatingLayers(const Lens& lens) {
    std::size_t layers = 0;
    for (const LensSurface& surface : lens.surfaces()) {
        layers = std::max(layers, surface.coating.layers.size());
    }
    return layers;
}

int ColourBandsFor(const Lens& lens, const QualitySettings& settings) {
    const std::size_t layers = MostCoatingLayers(lens);
    constexpr int kAll = kSpectrumSamples;
    const int bands = settings.colour_bands;
    if (layers <= 1 || bands >= kAll) return bands;
    return layers <= 3 ? std::max(21, std::min(41, bands + 10))
                       : std::max(31, std::min(61, bands + 20));
}

}  // namespace flare
