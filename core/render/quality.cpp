// SPDX-License-Identifier: Apache-2.0
#include "core/render/quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/spectrum/spectrum.h"

namespace flare {

namespace {

// Ordered from coarse to fine; the presets are among them.
std::vector<QualitySettings> MakeAnchors() {
    std::vector<QualitySettings> anchors(5);
    anchors[0] = {16, 8, 0.1, 0.03, 3, 14, 48.0, 4, 2e-2, {0.4, 0.4, 6.0, 64.0, 0.2}};
    anchors[0].tiles = {0.3, 0.3};
    anchors[0].tolerance = kMaxTolerance;
    anchors[0].blur_tolerance = 0.1;
    anchors[0].most_blur_side = 1;
    anchors[0].least_blur_px = 1.5;
    anchors[0].culled_share = 0.5;
    // Draft, preview, final.
    anchors[1] = {16, 8, 0.1, 0.03, 3, 14, 16.0, 8, 5e-3, {0.2, 0.15, 4.0, 64.0, 0.15}};
    anchors[1].tiles = {0.1, 0.15};
    anchors[1].tolerance = 0.05;
    anchors[1].blur_tolerance = 0.03;
    anchors[1].most_blur_side = 2;
    anchors[1].least_blur_px = 2.0;
    anchors[2] = {24, 8, 0.05, 0.02, 3, 21, 5.0, 14, 2e-3, {0.1, 0.08, 3.0, 48.0, 0.06}};
    anchors[2].tiles = {0.04, 0.1};
    anchors[2].tolerance = 0.02;
    anchors[3] = {48, 8, 0.015, 0.006, 3, 41, 1.5, 64, 4e-4, {0.05, 0.02, 1.0, 32.0, 0.03}};
    anchors[3].tiles = {0.01, 0.03};
    anchors[3].tolerance = 0.005;
    anchors[3].blur_tolerance = 0.0025;
    anchors[3].most_blur_side = 8;
    anchors[3].least_blur_px = 5.0;
    anchors[4] = {128, 8, 0.003, 0.001, 3, 81, 0.75, 128, 1e-4, {0.02, 0.01, 0.5, 24.0, 0.015}};
    anchors[4].tiles = {0.002, 0.005};
    anchors[4].tolerance = kMinTolerance;
    anchors[4].blur_tolerance = 5e-4;
    anchors[4].most_blur_side = 16;
    anchors[4].least_blur_px = 12.0;
    return anchors;
}

const std::vector<QualitySettings>& Anchors() {
    static const std::vector<QualitySettings> anchors = MakeAnchors();
    return anchors;
}

// As dense as the finest tolerance, but exact: doubles, polygons, every ghost.
QualitySettings Reference() {
    QualitySettings settings = Anchors().back();
    settings.traced_wavelengths = 4;
    settings.tiles.reset();
    settings.arithmetic = MeshArithmetic::kDouble;
    settings.culled_share = 0.0;
    return settings;
}

// Geometrically from a to b as t goes from 0 to 1.
double Mix(double a, double b, double t) {
    return a * std::pow(b / a, t);
}

int Mix(int a, int b, double t) {
    return static_cast<int>(std::lround(Mix(static_cast<double>(a), static_cast<double>(b), t)));
}

}  // namespace

constexpr double kFinerMesh = 0.5;  // from here on the mesh is the finer anchor's

QualitySettings SettingsFor(double tolerance) {
    const std::vector<QualitySettings>& anchors = Anchors();
    tolerance = std::clamp(tolerance, kMinTolerance, kMaxTolerance);
    std::size_t n = 0;
    while (n + 2 < anchors.size() && tolerance <= anchors[n + 1].tolerance) ++n;
    const QualitySettings& a = anchors[n];
    const QualitySettings& b = anchors[n + 1];
    if (tolerance == a.tolerance) return a;
    if (tolerance == b.tolerance) return b;
    const double t = std::log(tolerance / a.tolerance) / std::log(b.tolerance / a.tolerance);
    // A mesh of twice the cells costs three times as much.
    QualitySettings mixed = t < kFinerMesh ? a : b;
    mixed.tolerance = tolerance;
    mixed.culled_share = Mix(a.culled_share, b.culled_share, t);
    mixed.colour_bands = Mix(a.colour_bands, b.colour_bands, t);
    mixed.dispersion_step_px = Mix(a.dispersion_step_px, b.dispersion_step_px, t);
    mixed.most_drawn = Mix(a.most_drawn, b.most_drawn, t);
    mixed.light_tolerance = Mix(a.light_tolerance, b.light_tolerance, t);
    mixed.walk.position_px = Mix(a.walk.position_px, b.walk.position_px, t);
    mixed.walk.density_step = Mix(a.walk.density_step, b.walk.density_step, t);
    mixed.walk.smallest_px = Mix(a.walk.smallest_px, b.walk.smallest_px, t);
    mixed.walk.largest_px = Mix(a.walk.largest_px, b.walk.largest_px, t);
    mixed.walk.mask_step = Mix(a.walk.mask_step, b.walk.mask_step, t);
    mixed.blur_tolerance = Mix(a.blur_tolerance, b.blur_tolerance, t);
    mixed.most_blur_side = Mix(a.most_blur_side, b.most_blur_side, t);
    mixed.least_blur_px = Mix(a.least_blur_px, b.least_blur_px, t);
    mixed.tiles->light = Mix(a.tiles->light, b.tiles->light, t);
    mixed.tiles->edge_px = Mix(a.tiles->edge_px, b.tiles->edge_px, t);
    return mixed;
}

QualitySettings SettingsOf(const Quality& quality) {
    if (quality.tolerance) return SettingsFor(*quality.tolerance);
    switch (quality.preset) {
        case QualityPreset::kDraft:
            return Anchors()[1];
        case QualityPreset::kPreview:
            return Anchors()[2];
        case QualityPreset::kFinal:
            return Anchors()[3];
        case QualityPreset::kReference:
            return Reference();
    }
    return {};
}

QualitySettings SettingsOf(const FlareRequest& request) {
    return request.settings ? *request.settings : SettingsOf(request.quality);
}

double RelativeCost(double tolerance) {
    struct Row {
        double tolerance, cost;
    };
    static constexpr std::array kRows{Row{0.25, 1.0},   Row{0.1, 1.4},    Row{0.05, 1.7},
                                      Row{0.03, 2.3},   Row{0.025, 3.6},  Row{0.02, 4.2},
                                      Row{0.0135, 5.5}, Row{0.008, 7.5},  Row{0.0065, 14.0},
                                      Row{0.005, 18.0}, Row{0.001, 150.0}};
    tolerance = std::clamp(tolerance, kMinTolerance, kMaxTolerance);
    std::size_t n = 0;
    while (n + 2 < kRows.size() && tolerance < kRows[n + 1].tolerance) ++n;
    const Row& a = kRows[n];
    const Row& b = kRows[n + 1];
    const double t = std::log(tolerance / a.tolerance) / std::log(b.tolerance / a.tolerance);
    return Mix(a.cost, b.cost, t);
}

std::size_t MostCoatingLayers(const Lens& lens) {
    std::size_t layers = 0;
    for (const LensSurface& surface : lens.surfaces()) {
        layers = std::max(layers, surface.coating.layers.size());
    }
    return layers;
}

namespace {

// Fringes of the lens's thickest coating from 380 to 780 nm, at normal incidence.
double MostCoatingFringes(const Lens& lens) {
    double most = 0.0;
    for (const LensSurface& surface : lens.surfaces()) {
        double optical_nm = 0.0;
        for (const CoatingLayer& layer : surface.coating.layers) {
            optical_nm += layer.material.Index(550.0).real() * layer.thickness_nm;
        }
        most = std::max(most, 2.0 * optical_nm * (1.0 / 380.0 - 1.0 / 780.0));
    }
    return most;
}

}  // namespace

int ColourBandsFor(const Lens& lens, const QualitySettings& settings) {
    const std::size_t layers = MostCoatingLayers(lens);
    constexpr int kAll = kSpectrumSamples;
    const int bands = settings.colour_bands;
    if (layers == 0 || bands >= kAll) return bands;
    const int fringes = static_cast<int>(std::min<double>(kAll, 8.0 * MostCoatingFringes(lens)));
    if (layers == 1) return std::max(bands, fringes);
    return std::max(fringes, layers <= 3 ? std::max(21, std::min(41, bands + 10))
                                         : std::max(31, std::min(61, bands + 20)));
}

}  // namespace flare
