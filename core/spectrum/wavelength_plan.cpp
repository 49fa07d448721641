// SPDX-License-Identifier: Apache-2.0
#include "core/spectrum/wavelength_plan.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/check.h"
#include "core/base/units.h"

namespace flare {
namespace {

double InverseSquare(double wavelength_nm) {
    return 1.0 / (wavelength_nm * wavelength_nm);
}

struct Place {
    int low = 0;
    double share_high = 0.0;  // of the next one
};

// Where a wavelength lies between the ascending ones, in 1/lambda^2, ends included.
Place PlaceIn(const std::vector<double>& wavelengths, double wavelength) {
    const auto above = std::upper_bound(wavelengths.begin(), wavelengths.end(), wavelength);
    if (above == wavelengths.begin()) return {0, 0.0};
    const int low = static_cast<int>(above - wavelengths.begin()) - 1;
    if (above == wavelengths.end()) return {low, 0.0};
    const double a = InverseSquare(wavelengths[static_cast<std::size_t>(low)]);
    const double b = InverseSquare(*above);
    return {low, (InverseSquare(wavelength) - a) / (b - a)};
}

// Weights of the four evenly spaced points about a wavelength whose cubic gives a smooth function's
// value there; the nearest four at the ends, fewer where there are fewer.
std::vector<std::pair<int, double>> CubicShares(const std::vector<double>& points,
                                                double wavelength) {
    const int count = static_cast<int>(points.size());
    const int used = std::min(4, count);
    const double step = (points.back() - points.front()) / (count - 1);
    const double x = (wavelength - points.front()) / step;
    const int first = std::clamp(static_cast<int>(std::floor(x)) - 1, 0, count - used);
    std::vector<std::pair<int, double>> shares;
    for (int k = 0; k < used; ++k) {
        double weight = 1.0;
        for (int j = 0; j < used; ++j) {
            if (j != k) weight *= (x - first - j) / (k - j);
        }
        shares.emplace_back(first + k, weight);
    }
    return shares;
}

}  // namespace

std::vector<double> ChebyshevNodes(double low_nm, double high_nm, int count) {
    FLARE_CHECK(count >= 1);
    const double a = InverseSquare(low_nm);
    const double b = InverseSquare(high_nm);
    std::vector<double> nodes;
    for (int k = 0; k < count; ++k) {
        const double x = std::cos(kPi * (k + 0.5) / count);  // from +1 (short) to -1 (long)
        nodes.push_back(1.0 / std::sqrt(0.5 * (a + b) + 0.5 * (a - b) * x));
    }
    return nodes;
}

std::vector<double> NodeWeights(const std::vector<double>& nodes_nm, double wavelength_nm) {
    const double x = InverseSquare(wavelength_nm);
    std::vector<double> weights;
    for (std::size_t k = 0; k < nodes_nm.size(); ++k) {
        double weight = 1.0;
        for (std::size_t j = 0; j < nodes_nm.size(); ++j) {
            if (j == k) continue;
            const double xj = InverseSquare(nodes_nm[j]);
            weight *= (x - xj) / (InverseSquare(nodes_nm[k]) - xj);
        }
        weights.push_back(weight);
    }
    return weights;
}

std::vector<double> EvenInDispersion(double low_nm, double high_nm, int count) {
    FLARE_CHECK(count >= 2);
    const double a = InverseSquare(low_nm);
    const double b = InverseSquare(high_nm);
    std::vector<double> wavelengths;
    for (int k = 0; k < count; ++k) {
        wavelengths.push_back(1.0 / std::sqrt(a + (b - a) * k / (count - 1)));
    }
    return wavelengths;
}

std::vector<double> EvenInWavelength(double low_nm, double high_nm, int count) {
    FLARE_CHECK(count >= 2);
    std::vector<double> wavelengths;
    for (int k = 0; k < count; ++k) {
        wavelengths.push_back(low_nm + (high_nm - low_nm) * k / (count - 1));
    }
    return wavelengths;
}

std::vector<BandShare> BandShares(const std::vector<double>& drawn_nm,
                                  const std::vector<double>& colour_nm, const Spectrum& power,
                                  const ColorResponse& response) {
    std::map<std::pair<int, int>, Vec3d> shares;
    const auto add = [&](int drawn, int colour, double weight, const Vec3d& rgb) {
        if (weight == 0.0) return;
        // Imath vectors start out undefined.
        shares.try_emplace({drawn, colour}, 0.0, 0.0, 0.0).first->second += rgb * weight;
    };
    // Each 5 nm sample is spread over the 1 nm steps around it as a triangle of area 1; the two end
    // samples keep their half beyond the range at their own place.
    constexpr int kHalf = static_cast<int>(kSpectrumStep_nm);
    for (int i = 0; i < kSpectrumSamples; ++i) {
        const auto s = static_cast<std::size_t>(i);
        const Vec3d rgb = response[s] * power[s];
        for (int offset = -kHalf + 1; offset < kHalf; ++offset) {
            const double weight = (1.0 - std::abs(offset) / kSpectrumStep_nm) / kSpectrumStep_nm;
            const double wavelength = std::clamp(SampleWavelength(i) + offset, kSpectrumFirst_nm,
                                                 SampleWavelength(kSpectrumSamples - 1));
            const Place d = PlaceIn(drawn_nm, wavelength);
            for (const auto& [colour, share] : CubicShares(colour_nm, wavelength)) {
                add(d.low, colour, weight * (1.0 - d.share_high) * share, rgb);
                add(d.low + 1, colour, weight * d.share_high * share, rgb);
            }
        }
    }
    std::vector<BandShare> list;
    for (const auto& [key, rgb] : shares) list.push_back({key.first, key.second, rgb});
    return list;
}

}  // namespace flare
