// SPDX-License-Identifier: Apache-2.0
#include "core/spectrum/sampled_curve.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/check.h"

namespace flare {
namespace {

class Curve {
  public:
    Curve(const std::vector<double>& x, const std::vector<double>& y) : x_(x), y_(y) {}

    double At(double x) const {
        const auto above = std::upper_bound(x_.begin(), x_.end(), x);
        if (above == x_.begin()) return 0.0;
        const auto high = static_cast<std::size_t>(above - x_.begin());
        if (above == x_.end()) return x == x_.back() ? y_.back() : 0.0;
        const double t = (x - x_[high - 1]) / (x_[high] - x_[high - 1]);
        return y_[high - 1] + (y_[high] - y_[high - 1]) * t;
    }

    // The mean under a triangle of half-width `half` about `centre`: the integrand is quadratic
    // between neighbouring points of curve and triangle, so Simpson's rule is exact there.
    double Mean(double centre, double half) const {
        std::vector<double> knots{centre - half, centre, centre + half};
        for (auto at = std::upper_bound(x_.begin(), x_.end(), centre - half);
             at != x_.end() && *at < centre + half; ++at) {
            knots.push_back(*at);
        }
        std::sort(knots.begin(), knots.end());
        // Within an open interval the curve may jump at its first and last point only.
        const double inset = 1e-9;
        const auto value = [&](double x) {
            return At(x) * std::max(0.0, 1.0 - std::abs(x - centre) / half);
        };
        double sum = 0.0;
        for (std::size_t k = 1; k < knots.size(); ++k) {
            const double a = knots[k - 1], b = knots[k];
            if (b - a <= 2.0 * inset) continue;
            sum += (value(a + inset) + 4.0 * value(0.5 * (a + b)) + value(b - inset)) * (b - a);
        }
        return sum / (6.0 * half);
    }

  private:
    const std::vector<double>& x_;
    const std::vector<double>& y_;
};

}  // namespace

Spectrum SpectrumOfCurve(const std::vector<double>& wavelengths_nm,
                         const std::vector<double>& values) {
    FLARE_CHECK(!wavelengths_nm.empty() && wavelengths_nm.size() == values.size());
    bool fine = false;
    for (std::size_t i = 1; i < wavelengths_nm.size(); ++i) {
        fine = fine || wavelengths_nm[i] - wavelengths_nm[i - 1] < kSpectrumStep_nm;
    }
    const Curve curve(wavelengths_nm, values);
    Spectrum spectrum;
    for (int i = 0; i < kSpectrumSamples; ++i) {
        const double wavelength = SampleWavelength(i);
        spectrum[static_cast<std::size_t>(i)] =
            fine ? curve.Mean(wavelength, kSpectrumStep_nm) : curve.At(wavelength);
    }
    return spectrum;
}

}  // namespace flare
