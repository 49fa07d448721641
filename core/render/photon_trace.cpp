// SPDX-License-Identifier: Apache-2.0
#include "core/render/photon_trace.h"

#include <algorithm>
#include <cmath>

#include "core/render/philox.h"

namespace flare {
namespace {

constexpr double kGoldenRatio = 0.6180339887498949;
// The tracer's first hit is the place that was sampled, and no other crossing of the same line.
constexpr double kSamePlace_mm = 1e-6;

// Samples that share one run through the wavelengths.
constexpr std::int64_t kRow = 64;
constexpr double kEvenShare = 0.1;

// Place of sample number n on the front, in the unit square.
Vec2d FrontPlace(const PhotonBatch& batch, std::int64_t n, Vec2d random) {
    const PhotonStrata& strata = batch.strata;
    const std::int64_t even = strata.even;
    if (n < even * even) {
        return Vec2d(static_cast<double>(n % even) + random.x,
                     static_cast<double>(n / even) + random.y) /
               static_cast<double>(even);
    }
    n -= even * even;
    if (strata.fine > 0) {
        const std::int64_t fine = strata.fine, within = n % (fine * fine);
        const Vec2d place(static_cast<double>(within % fine) + random.x,
                          static_cast<double>(within / fine) + random.y);
        return batch.region.Place(static_cast<std::size_t>(n / (fine * fine)),
                                  place / static_cast<double>(fine));
    }
    const auto cells = static_cast<double>(batch.region.cell_count());
    const double at = (static_cast<double>(n) + random.x) / strata.few * cells;
    const double cell = std::min(std::floor(at), cells - 1.0);
    return batch.region.Place(static_cast<std::size_t>(cell), {at - cell, random.y});
}

}  // namespace

PhotonStrata PhotonStrata::For(double samples, const PhotonRegion& region) {
    PhotonStrata strata;
    const auto cells = static_cast<double>(region.cell_count());
    strata.even = std::max(2, static_cast<int>(std::sqrt(kEvenShare * samples)));
    if (region.cell_count() == 0) return strata;  // nothing was found: no reason to look harder
    const double rest = (1.0 - kEvenShare) * samples;
    strata.fine = static_cast<int>(std::sqrt(rest / cells));
    if (strata.fine == 0) strata.few = std::max(4, static_cast<int>(rest));
    return strata;
}

PhotonColors OneWavelength(double wavelength_nm, double irradiance) {
    return {{wavelength_nm}, {1.0}, {Vec3d(irradiance, 0.0, 0.0)}};
}

PhotonColors ColorsOf(const Spectrum& power, const ColorResponse& response) {
    constexpr int kStep = static_cast<int>(kSpectrumStep_nm);
    constexpr int kCount = (kSpectrumSamples - 1) * kStep + 1;
    PhotonColors colors;
    std::vector<double> chance;
    double all = 0.0;
    for (int k = 0; k < kCount; ++k) {
        // The product of power and response is taken as straight between samples; a sample at the
        // end stands for a whole step.
        const int i = std::min(k / kStep, kSpectrumSamples - 2);
        const double t = static_cast<double>(k - i * kStep) / kStep;
        const auto n = static_cast<std::size_t>(i);
        Vec3d light =
            (response[n] * (power[n] * (1.0 - t)) + response[n + 1] * (power[n + 1] * t)) /
            kSpectrumStep_nm;
        if (k == 0 || k == kCount - 1) light *= 0.5 * (kSpectrumStep_nm + 1.0);
        colors.wavelengths_nm.push_back(kSpectrumFirst_nm + k);
        colors.value.push_back(light);
        chance.push_back(std::abs(light.x) + std::abs(light.y) + std::abs(light.z));
        all += chance.back();
    }
    double sum = 0.0;
    for (std::size_t k = 0; k < chance.size(); ++k) {
        // A tenth evenly, for coatings that let through what the eye hardly sees.
        const double p = (all > 0.0 ? 0.9 * chance[k] / all : 0.9 / kCount) + 0.1 / kCount;
        colors.value[k] /= p;
        colors.cumulative.push_back(sum += p);
    }
    return colors;
}

// docs/conventions.md, "Image".
SensorMap SensorMapOf(const FlareRequest& request) {
    const ImageSpec& image = request.image;
    const Vec2d pitch = PixelPitch(request);
    return {pitch,
            {0.5 * image.width + image.center_offset_mm.x / pitch.x,
             0.5 * image.height - image.center_offset_mm.y / pitch.y}};
}

LandedPhotons TracePhotons(const Lens& lens, const Iris& iris, const PhotonBatch& batch,
                           const SensorMap& map, const PixelWindow& window, double margin) {
    LandedPhotons landed;
    TraceOptions options;
    options.iris = &iris;
    RayRecord record;
    const PhotonColors& colors = batch.colors;
    std::vector<InteractionList> lists(colors.wavelengths_nm.size());  // written out when needed
    const PhiloxKey key{static_cast<std::uint32_t>(batch.seed),
                        static_cast<std::uint32_t>(batch.seed >> 32)};
    // Samples a unit of the square: both kinds together are one density (Veach 1997, ch. 9: the
    // balance heuristic), whichever of them a sample came from.
    const double even_density = static_cast<double>(batch.strata.even) * batch.strata.even;
    const double region_density =
        batch.region.cell_count() > 0
            ? static_cast<double>(batch.strata.in_region(batch.region)) / batch.region.area()
            : 0.0;
    const Vec2d low(window.x - margin, window.y - margin);
    const Vec2d high(window.x + window.width + margin, window.y + window.height + margin);
    for (std::int64_t n = batch.first; n < batch.first + batch.count; ++n) {
        const PhiloxCounter random =
            Philox({static_cast<std::uint32_t>(n), batch.stream[0], batch.stream[1], 0}, key);
        const Vec2d front = FrontPlace(batch, n, {UnitFrom(random[0]), UnitFrom(random[1])});
        const std::optional<PhotonRay> start =
            batch.source.At(front, {UnitFrom(random[2]), UnitFrom(random[3])});
        if (!start) continue;
        // Wavelengths run through a row evenly; each row starts anywhere.
        const PhiloxCounter of_row = Philox(
            {static_cast<std::uint32_t>(n / kRow), batch.stream[0], batch.stream[1], 1}, key);
        double color = UnitFrom(of_row[0]) + kGoldenRatio * static_cast<double>(n % kRow);
        color -= std::floor(color);
        const auto above =
            std::upper_bound(colors.cumulative.begin(), colors.cumulative.end() - 1, color);
        const auto k = static_cast<std::size_t>(above - colors.cumulative.begin());
        if (lists[k].steps.empty()) {
            lists[k] = WriteOut(lens, batch.sequence, colors.wavelengths_nm[k]);
        }
        const TraceResult end = TraceRay(lists[k], start->ray, options, &record);
        if (end.fate != RayFate::kArrived) continue;
        if (std::abs(record.segment_mm.front() - kPhotonRun_mm) > kSamePlace_mm) continue;
        const double density = even_density + (batch.region.Contains(front) ? region_density : 0.0);
        const Vec3d light = colors.value[k] * (start->density * batch.source.area_mm2() / density *
                                               PathWeight(lens, lists[k], record));
        landed.flux_mm2 += light.x;
        const Vec2d pixel = map.Pixel(end.sensor_mm);
        if (!(pixel.x >= low.x && pixel.x < high.x && pixel.y >= low.y && pixel.y < high.y)) {
            continue;
        }
        landed.photons.push_back({pixel, light});
    }
    return landed;
}

}  // namespace flare
