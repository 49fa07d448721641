// SPDX-License-Identifier: Apache-2.0
//
// Light as a scalar wave over a distance z in the Fresnel approximation (Goodman, Introduction to
// Fourier Optics, 4.2), on square grids of samples:
//
//   U(x2) = exp(ikz) / (i lambda z)  integral U(x1) exp{i pi |x2 - x1|^2 / (lambda z)} dx1
//
// without the constant phase exp(ikz). Two ways that are each valid where its own chirp is sampled
// often enough, W = side * pitch being the width of the grid:
//   transfer function   |z| <= W pitch / lambda   the same grid before and behind
//   chirp               |z| >= W pitch / lambda   one transform; pitch behind: lambda |z| / W
// (a chirp over an aperture 2a wide within W needs only |z| >= 2a pitch / lambda, and a transfer
// function that meets no light at the edge of its band may go farther; so they overlap). The grid
// is periodic: light that would leave it comes in again on the other side, so W must leave room.
// Lengths are mm. Negative z runs the light backwards. Both keep the energy, sum |U|^2 pitch^2.
#pragma once

#include <vector>

#include "core/base/parallel.h"
#include "core/wave/fourier.h"

namespace flare {

// Sample (i, j), at [j * side + i], stands at ((i - side / 2) pitch_mm, (j - side / 2) pitch_mm).
struct WaveField {
    int side = 0;
    double pitch_mm = 0.0;
    std::vector<Complex> values;

    Complex At(int i, int j) const {
        return values[static_cast<std::size_t>(j) * static_cast<std::size_t>(side) +
                      static_cast<std::size_t>(i)];
    }
    double width_mm() const { return side * pitch_mm; }
    double energy_mm2() const;
};

enum class Propagator { kTransferFunction, kChirp };

// By sampling: which one is valid over `z_mm` for light that fills the grid. Both at the limit.
Propagator PropagatorFor(const WaveField& field, double wavelength_mm, double z_mm);

// z_mm is not 0 for the chirp.
WaveField Propagate(const WaveField& field, double wavelength_mm, double z_mm, Propagator how,
                    ThreadPool& threads);

// The pattern far away or in a lens's focus, on directions: U(s) = integral U(x) exp(-2 pi i s.x)
// dx, the pitch behind being 1 / W in cycles a mm (of s = direction / lambda). Keeps the energy.
WaveField FraunhoferPattern(const WaveField& field, ThreadPool& threads);

}  // namespace flare
