// SPDX-License-Identifier: Apache-2.0
#include "core/wave/propagation.h"

#include <cmath>

#include "core/base/check.h"
#include "core/base/units.h"

namespace flare {
namespace {

// Places in the order of SquareFourier: origin first, the negative half behind the positive one.
int Signed(int index, int side) {
    return index < side / 2 ? index : index - side;
}

// Between "origin in the middle" and "origin first": the same exchange both ways.
std::vector<Complex> Exchanged(const std::vector<Complex>& values, int side) {
    std::vector<Complex> out(values.size());
    const auto n = static_cast<std::size_t>(side);
    for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t i = 0; i < n; ++i) {
            out[((j + n / 2) % n) * n + (i + n / 2) % n] = values[j * n + i];
        }
    }
    return out;
}

// Multiplies by f(squared place) with places pitch apart; origin first.
template <class Function>
void MultiplyRadial(std::vector<Complex>& values, int side, double pitch, ThreadPool& threads,
                    const Function& f) {
    threads.For(side, [&](int j) {
        const double y = Signed(j, side) * pitch;
        for (int i = 0; i < side; ++i) {
            const double x = Signed(i, side) * pitch;
            values[static_cast<std::size_t>(j) * static_cast<std::size_t>(side) +
                   static_cast<std::size_t>(i)] *= f(x * x + y * y);
        }
    });
}

}  // namespace

double WaveField::energy_mm2() const {
    double sum = 0.0;
    for (const Complex& value : values) sum += std::norm(value);
    return sum * pitch_mm * pitch_mm;
}

Propagator PropagatorFor(const WaveField& field, double wavelength_mm, double z_mm) {
    return std::abs(z_mm) <= field.width_mm() * field.pitch_mm / wavelength_mm
               ? Propagator::kTransferFunction
               : Propagator::kChirp;
}

WaveField Propagate(const WaveField& field, double wavelength_mm, double z_mm, Propagator how,
                    ThreadPool& threads) {
    const int side = field.side;
    const SquareFourier fourier(side);
    WaveField out{side, field.pitch_mm, Exchanged(field.values, side)};
    if (how == Propagator::kTransferFunction) {
        // Goodman 4.2.3: multiply the spectrum by exp(-i pi lambda z |f|^2).
        fourier.Forward(out.values, threads);
        MultiplyRadial(out.values, side, 1.0 / field.width_mm(), threads, [&](double f2) {
            return std::polar(1.0, -kPi * wavelength_mm * z_mm * f2);
        });
        fourier.Inverse(out.values, threads);
    } else {
        // Goodman 4.2.2: one transform of the field times a chirp.
        FLARE_CHECK(z_mm != 0.0);
        const double in_phase = kPi / (wavelength_mm * z_mm);
        MultiplyRadial(out.values, side, field.pitch_mm, threads,
                       [&](double x2) { return std::polar(1.0, in_phase * x2); });
        // Light that runs backwards lands point-mirrored: the kernel's sign changes.
        if (z_mm > 0.0) {
            fourier.Forward(out.values, threads);
        } else {
            fourier.Inverse(out.values, threads);
            const double undo = static_cast<double>(side) * side;
            for (Complex& value : out.values) value *= undo;
        }
        out.pitch_mm = wavelength_mm * std::abs(z_mm) / field.width_mm();
        const Complex factor =
            field.pitch_mm * field.pitch_mm / (Complex(0.0, 1.0) * wavelength_mm * z_mm);
        MultiplyRadial(out.values, side, out.pitch_mm, threads,
                       [&](double x2) { return factor * std::polar(1.0, in_phase * x2); });
    }
    out.values = Exchanged(out.values, side);
    return out;
}

WaveField FraunhoferPattern(const WaveField& field, ThreadPool& threads) {
    WaveField out{field.side, 1.0 / field.width_mm(), Exchanged(field.values, field.side)};
    SquareFourier(field.side).Forward(out.values, threads);
    const double cell = field.pitch_mm * field.pitch_mm;
    for (Complex& value : out.values) value *= cell;
    out.values = Exchanged(out.values, field.side);
    return out;
}

}  // namespace flare
