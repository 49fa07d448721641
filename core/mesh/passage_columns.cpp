// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/mesh/passage_columns.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h must come before highway.h.
#include <hwy/highway.h>

#include "core/mesh/passage_columns-inl.h"

#if HWY_ONCE

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/units.h"
#include "core/mesh/passage_columns.h"

namespace flare {

HWY_EXPORT(MultiplyFits);

namespace {

// Of a factor, relative to its largest value over the range.
constexpr double kFitError = 1e-5;

// Squared cosines that come lower than this are next to the critical angle.
constexpr double kCritical = 1e-3;

constexpr std::size_t kPadding = 64;  // a multiple of every vector's lanes

constexpr std::size_t kPoints = PathInColumns::kTerms;

using Values = std::array<double, kPoints>;

// Roots of the Chebyshev polynomial of degree kPoints, and the matrix that turns values there into
// the terms of the polynomial through them.
struct Interpolation {
    Values at{};
    std::array<Values, kPoints> terms{};  // [term][point]
    // Some of the places where a polynomial is farthest off: extremes of the next Chebyshev
    // polynomial.
    std::array<double, kPoints / 2 + 2> checks{};

    Interpolation() {
        for (std::size_t k = 0; k < checks.size(); ++k) {
            const std::size_t extreme = std::min(2 * k, kPoints);
            checks[k] = std::cos(kPi * static_cast<double>(extreme) / static_cast<double>(kPoints));
        }
        constexpr auto n = static_cast<double>(kPoints);
        // T_0, T_1, ... by their terms.
        std::array<Values, kPoints> chebyshev{};
        chebyshev[0][0] = chebyshev[1][1] = 1.0;
        for (std::size_t m = 2; m < kPoints; ++m) {
            for (std::size_t t = 0; t < kPoints; ++t) {
                chebyshev[m][t] =
                    (t > 0 ? 2.0 * chebyshev[m - 1][t - 1] : 0.0) - chebyshev[m - 2][t];
            }
        }
        for (std::size_t k = 0; k < kPoints; ++k) {
            const double angle = kPi * (static_cast<double>(k) + 0.5) / n;
            at[k] = std::cos(angle);
            for (std::size_t m = 0; m < kPoints; ++m) {
                const double c =
                    (m == 0 ? 1.0 : 2.0) / n * std::cos(static_cast<double>(m) * angle);
                for (std::size_t t = 0; t < kPoints; ++t) terms[t][k] += c * chebyshev[m][t];
            }
        }
    }
};

}  // namespace

void PassageColumns::Resize(std::size_t nodes, std::size_t passages_of_each,
                            std::size_t ray_count) {
    rays = ray_count;
    stride = (ray_count + kPadding - 1) / kPadding * kPadding;
    passages = passages_of_each;
    values.resize(nodes * passages * stride);
}

PassageRange::PassageRange(std::size_t passages)
    : lowest(passages, 1e30F), highest(passages, -1e30F), spread(passages, 0.0F) {}

void PassageRange::Add(const std::vector<const float*>& nodes) {
    const float* const first = nodes.front();
    for (const float* const node : nodes) {
        for (std::size_t s = 0; s < lowest.size(); ++s) {
            lowest[s] = std::min(lowest[s], node[s]);
            highest[s] = std::max(highest[s], node[s]);
            spread[s] = std::max(spread[s], std::abs(node[s] - first[s]));
        }
    }
}

PathInColumns::PathInColumns(const TransmissionTables::Path& path,
                             std::vector<std::vector<double>> node_weights,
                             const PassageRange& range)
    : path_(path), node_weights_(std::move(node_weights)), fits_(bands()), asked_(bands()) {
    for (std::size_t step = 0; step < path.steps(); ++step) {
        if (!path.Acts(step)) continue;
        // Between rays and beyond the traced wavelengths values go a little farther.
        const auto lowest = static_cast<double>(range.lowest[step]);
        const auto highest = static_cast<double>(range.highest[step]);
        const double margin =
            0.1 * (highest - lowest) + static_cast<double>(range.spread[step]) + 1e-5;
        const double lo = lowest - margin;
        const double hi = std::min(highest + margin, 1.0);
        for (std::size_t band = 0; band < bands(); ++band) {
            Fit fit;
            if (lo > kCritical && lo < hi && Choose(band, step, lo, hi, fit)) {
                fits_[band].push_back(fit);
            } else {
                asked_[band].push_back(step);
            }
        }
    }
}

bool PathInColumns::Choose(std::size_t band, std::size_t step, double lo, double hi,
                           Fit& fit) const {
    static const Interpolation interpolation;
    for (const bool root : {false, true}) {
        const double from = root ? std::sqrt(lo) : lo;
        const double to = root ? std::sqrt(hi) : hi;
        const double middle = 0.5 * (from + to);
        const double half = 0.5 * (to - from);
        const auto exact = [&](double x) {
            const double value = middle + half * x;
            return path_.Factor(static_cast<int>(band), step, root ? value * value : value);
        };
        Values samples{};
        double largest = 0.0;
        for (std::size_t k = 0; k < kPoints; ++k) {
            samples[k] = exact(interpolation.at[k]);
            largest = std::max(largest, std::abs(samples[k]));
        }
        Values terms{};
        for (std::size_t t = 0; t < kPoints; ++t) {
            for (std::size_t k = 0; k < kPoints; ++k) {
                terms[t] += interpolation.terms[t][k] * samples[k];
            }
        }
        bool good = true;
        for (std::size_t k = 0; k < interpolation.checks.size() && good; ++k) {
            const double x = interpolation.checks[k];
            double sum = 0.0;
            for (std::size_t t = kPoints; t-- > 0;) sum = sum * x + terms[t];
            good = std::abs(sum - exact(x)) <= kFitError * largest;
        }
        if (!good) continue;
        fit.step = step;
        fit.root = root;
        fit.middle = static_cast<float>(middle);
        fit.inverse_half = static_cast<float>(1.0 / half);
        for (std::size_t t = 0; t < kPoints; ++t) fit.terms[t] = static_cast<float>(terms[t]);
        return true;
    }
    return false;
}

void PathInColumns::Weights(std::size_t band, const PassageColumns& rays,
                            std::vector<float>& out) const {
    const std::vector<double>& node_weights = node_weights_[band];
    const std::vector<float> weights(node_weights.begin(), node_weights.end());
    out.resize(rays.stride);
    const std::vector<Fit>& fits = fits_[band];
    HWY_DYNAMIC_DISPATCH(MultiplyFits)
    (fits.data(), fits.size(), weights.data(), weights.size(), rays, out.data());

    const auto passage_at = [&](std::size_t passage, std::size_t ray) {
        double value = 0.0;
        for (std::size_t n = 0; n < node_weights.size(); ++n) {
            const std::size_t row = n * rays.passages + passage;
            value += node_weights[n] * static_cast<double>(rays.values[row * rays.stride + ray]);
        }
        return value;
    };
    const int number = static_cast<int>(band);
    for (const std::size_t step : asked_[band]) {
        for (std::size_t k = 0; k < rays.rays; ++k) {
            out[k] *= static_cast<float>(path_.Factor(number, step, passage_at(step, k)));
        }
    }
    const std::vector<double> absorptions = path_.AbsorptionsPerMm(number);
    if (absorptions.empty()) return;
    for (std::size_t k = 0; k < rays.rays; ++k) {
        double absorbed = 0.0;
        for (std::size_t a = 0; a < absorptions.size(); ++a) {
            absorbed += absorptions[a] * passage_at(path_.steps() + a, k);
        }
        out[k] *= static_cast<float>(std::exp(-absorbed));
    }
}

std::size_t PathInColumns::asked() const {
    std::size_t sum = 0;
    for (const std::vector<std::size_t>& steps : asked_) sum += steps.size();
    return sum;
}

}  // namespace flare
#endif  // HWY_ONCE
