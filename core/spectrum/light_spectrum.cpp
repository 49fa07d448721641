// SPDX-License-Identifier: Apache-2.0
//
// The least departure that is nowhere negative: minimise |s - s0|^2 over s >= 0 with A s = c, three
// equations. Its solution is s = max(0, s0 + A^T y), y being where the concave dual
//   c.y - |max(0, s0 + A^T y)|^2 / 2
// is largest: Newton's method in three unknowns, with steps halved until the dual grows. Where no
// real light has the colour the dual has no maximum, and y runs away.
#include "core/spectrum/light_spectrum.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "core/spectrum/cie_table.h"
#include "core/spectrum/primaries_table.h"

namespace flare {
namespace {

using Ratios = Spectrum;  // power over base

constexpr double kSecondRadiation_nmK = 1.438776877e7;
constexpr double kColourTolerance = 1e-10;  // of the largest channel
constexpr double kRounding = 1e-13;         // of the dual
constexpr int kNewtonSteps = 60;
constexpr int kBisections = 20;

double Largest(const Vec3d& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

// x of m x = b by Cramer's rule, m given by columns.
Vec3d Solve(const Vec3d (&m)[3], const Vec3d& b) {
    const double volume = m[0].dot(m[1].cross(m[2]));
    return Vec3d(b.dot(m[1].cross(m[2])), m[0].dot(b.cross(m[2])), m[0].dot(m[1].cross(b))) /
           volume;
}

double Primary(std::size_t sample, int channel) {
    const PrimariesRow& row = PrimariesTable()[sample];
    return channel == 0 ? row.red : channel == 1 ? row.green : row.blue;
}

class ColorFit {
  public:
    explicit ColorFit(const Spectrum& base) : base_(base) {
        for (std::size_t i = 0; i < base.size(); ++i) seen_[i] = Rec709Response()[i] * base[i];
        for (int k = 0; k < 3; ++k) {
            mixed_[k] = Vec3d(0.0);
            for (std::size_t i = 0; i < base.size(); ++i) mixed_[k] += seen_[i] * Primary(i, k);
        }
    }

    // The mix of primaries with this colour.
    Ratios Mix(const Vec3d& rgb) const {
        const Vec3d amount = Solve(mixed_, rgb);
        Ratios ratios;
        for (std::size_t i = 0; i < ratios.size(); ++i) {
            ratios[i] =
                amount.x * Primary(i, 0) + amount.y * Primary(i, 1) + amount.z * Primary(i, 2);
        }
        return ratios;
    }

    // The one nearest to the mix that is nowhere negative, if there is one.
    std::optional<Ratios> Nearest(const Vec3d& rgb) const {
        const Ratios mix = Mix(rgb);
        Vec3d y(0.0);
        double value = Dual(mix, rgb, y);
        for (int step = 0; step < kNewtonSteps; ++step) {
            Vec3d slope = rgb;
            Vec3d curve[3] = {Vec3d(0.0), Vec3d(0.0), Vec3d(0.0)};
            for (std::size_t i = 0; i < mix.size(); ++i) {
                const double s = mix[i] + seen_[i].dot(y);
                if (s <= 0.0) continue;
                slope -= seen_[i] * s;
                for (int k = 0; k < 3; ++k) curve[k] += seen_[i] * seen_[i][k];
            }
            if (Largest(slope) <= kColourTolerance * Largest(rgb)) return At(mix, y);
            const Vec3d move = Solve(curve, slope);
            if (!std::isfinite(move.x) || !std::isfinite(move.y) || !std::isfinite(move.z)) break;
            double length = 1.0;
            double next = Dual(mix, rgb, y + move);
            while (!(next >= value - kRounding * std::abs(value)) && length > 1e-6) {
                length *= 0.5;
                next = Dual(mix, rgb, y + move * length);
            }
            y += move * length;
            value = next;
        }
        return std::nullopt;
    }

    Spectrum Power(const Ratios& ratios) const {
        Spectrum power;
        for (std::size_t i = 0; i < power.size(); ++i) power[i] = base_[i] * ratios[i];
        return power;
    }

  private:
    Ratios At(const Ratios& mix, const Vec3d& y) const {
        Ratios ratios;
        for (std::size_t i = 0; i < ratios.size(); ++i) {
            ratios[i] = std::max(0.0, mix[i] + seen_[i].dot(y));
        }
        return ratios;
    }

    double Dual(const Ratios& mix, const Vec3d& rgb, const Vec3d& y) const {
        double squares = 0.0;
        for (const double s : At(mix, y)) squares += s * s;
        return rgb.dot(y) - 0.5 * squares;
    }

    const Spectrum& base_;
    std::array<Vec3d, kSpectrumSamples> seen_;  // colour of the base's power at each sample
    Vec3d mixed_[3];                            // colours of the base times each primary
};

bool NowhereNegative(const Ratios& ratios) {
    return std::all_of(ratios.begin(), ratios.end(), [](double r) { return r >= 0.0; });
}

}  // namespace

double Luminance(const Spectrum& power) {
    double luminance = 0.0;
    for (std::size_t i = 0; i < power.size(); ++i) luminance += CieTable()[i].y_bar * power[i];
    return luminance;
}

Spectrum BlackbodySpectrum(double kelvin) {
    Spectrum power;
    for (int i = 0; i < kSpectrumSamples; ++i) {
        const double nm = SampleWavelength(i);
        const double x = kSecondRadiation_nmK / (nm * kelvin);
        power[static_cast<std::size_t>(i)] = std::pow(nm / 560.0, -5.0) / std::expm1(x);
    }
    const double luminance = Luminance(power);
    for (double& value : power) value /= luminance;
    return power;
}

Spectrum SpectrumOfColor(const Spectrum& base, Vec3d rgb) {
    if (Largest(rgb) == 0.0) return Spectrum{};
    const ColorFit fit(base);
    const Ratios mix = fit.Mix(rgb);
    if (NowhereNegative(mix)) return fit.Power(mix);
    if (const std::optional<Ratios> real = fit.Nearest(rgb)) return fit.Power(*real);

    // Towards white of the strongest channel, as little as will do.
    const double most = std::max({rgb.x, rgb.y, rgb.z, 0.0});
    const Vec3d white(most, most, most);
    double low = 0.0, high = 1.0;  // shares of white: not enough, enough
    Vec3d real_rgb = white;
    Ratios real = fit.Mix(white);
    for (int k = 0; k < kBisections && high - low > 1e-3; ++k) {
        const double share = 0.5 * (low + high);
        const Vec3d trial = rgb + (white - rgb) * share;
        const std::optional<Ratios> found = fit.Nearest(trial);
        (found ? high : low) = share;
        if (!found) continue;
        real = *found;
        real_rgb = trial;
    }
    const Ratios rest = fit.Mix(rgb - real_rgb);
    for (std::size_t i = 0; i < real.size(); ++i) real[i] += rest[i];
    return fit.Power(real);
}

}  // namespace flare
