// SPDX-License-Identifier: Apache-2.0
//
// The propagators' error on the axis of a circular aperture against 4 sin^2(pi N_F / 2), over the
// Fresnel number, as CSV: each way by itself, as a share of the peak 4, on a grid of 1024 samples a
// side and 2.5 radii wide; and the error in the energy.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/base/units.h"
#include "core/wave/coverage.h"
#include "core/wave/propagation.h"

int main() {
    using namespace flare;
    constexpr int kSide = 1024;
    constexpr double kWavelength_mm = 550e-6;
    Loop circle;
    for (int i = 0; i < 4000; ++i) {
        const double angle = 2.0 * kPi * i / 4000;
        circle.push_back({std::cos(angle), std::sin(angle)});
    }
    WaveField disc{kSide, 2.5 / kSide, {}};
    const std::vector<double> mask = Sharpened(Coverage({circle}, kSide, disc.pitch_mm), kSide);
    disc.values.assign(mask.begin(), mask.end());
    ThreadPool threads(2);
    std::printf("fresnel_number,share_of_peak,energy,propagator\n");
    constexpr int kNumbers = 40;
    for (int i = 0; i <= kNumbers; ++i) {
        const double n = 0.1 * std::pow(2560.0, static_cast<double>(i) / kNumbers);
        const double z = 1.0 / (kWavelength_mm * n);
        const double expected = 4.0 * std::pow(std::sin(0.5 * kPi * n), 2);
        for (const Propagator how : {Propagator::kChirp, Propagator::kTransferFunction}) {
            // A transfer function's light comes in again from the other side.
            if (how == Propagator::kTransferFunction && n < 20.0) continue;
            const WaveField out = Propagate(disc, kWavelength_mm, z, how, threads);
            const double value = std::norm(out.At(kSide / 2, kSide / 2));
            std::printf("%.5g,%.3g,%.3g,%s\n", n, std::max(1e-9, std::abs(value - expected) / 4.0),
                        std::abs(out.energy_mm2() / disc.energy_mm2() - 1.0),
                        how == Propagator::kChirp ? "chirp" : "transfer function");
        }
    }
    return 0;
}
