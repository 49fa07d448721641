// SPDX-License-Identifier: Apache-2.0
#include "core/wave/edge_profile.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/check.h"
#include "core/base/units.h"

namespace flare {
namespace {

// Fresnel's integrals on a lattice, by Simpson's rule.
class KnifeTable {
  public:
    static constexpr double kEnd = 30.0;

    KnifeTable() {
        constexpr std::size_t kCount = static_cast<std::size_t>(kEnd / kStep) + 1;
        values_.reserve(2 * kCount);
        std::vector<std::array<double, 2>> integrals = {{0.0, 0.0}};
        for (std::size_t i = 1; i < kCount; ++i) {
            const double b = static_cast<double>(i) * kStep;
            const double a = b - kStep;
            const double m = b - 0.5 * kStep;
            const auto simpson = [&](auto f) {
                const auto at = [&](double t) { return f(0.5 * kPi * t * t); };
                return kStep / 6.0 * (at(a) + 4.0 * at(m) + at(b));
            };
            integrals.push_back(
                {integrals.back()[0] + simpson([](double p) { return std::cos(p); }),
                 integrals.back()[1] + simpson([](double p) { return std::sin(p); })});
        }
        const auto add = [&](double sign, const std::array<double, 2>& cs) {
            const double c = sign * cs[0] + 0.5;
            const double s = sign * cs[1] + 0.5;
            values_.push_back(0.5 * (c * c + s * s));
        };
        for (std::size_t i = kCount; i-- > 1;) add(-1.0, integrals[i]);
        for (const auto& cs : integrals) add(1.0, cs);
    }

    double At(double v) const {
        const double place = (v + kEnd) / kStep;
        const auto i = std::min(static_cast<std::size_t>(place), values_.size() - 2);
        const double f = place - static_cast<double>(i);
        return (1.0 - f) * values_[i] + f * values_[i + 1];
    }

  private:
    static constexpr double kStep = 0.005;
    std::vector<double> values_;
};

double Sinc(double x) {
    return std::abs(x) < 1e-6 ? 1.0 : std::sin(x) / x;
}

// From 1 down to 0 between a and b.
double FadeOut(double x, double a, double b) {
    const double s = std::clamp((x - a) / (b - a), 0.0, 1.0);
    return 1.0 - s * s * (3.0 - 2.0 * s);
}

class TableMaker {
  public:
    explicit TableMaker(const EdgeProfileSpec& spec) : spec_(spec) {
        const auto count =
            static_cast<std::size_t>(std::ceil((spec.dark_t + spec.lit_t) / spec.step_t));
        for (std::size_t i = 0; i < count; ++i) {
            t_.push_back(-spec.dark_t + (static_cast<double>(i) + 0.5) * spec.step_t);
        }
    }

    std::vector<float> Run() {
        for (const double t : t_) profile_.push_back(Pattern(t));
        if (spec_.source_t > 0.0) Blur();
        spec_.disc_fresnel_number > 0.0 ? KeepDisc() : KeepMoments();
        std::vector<float> sums = {0.0F};
        double sum = 0.0;
        for (std::size_t i = 0; i < t_.size(); ++i) {
            sum += spec_.weight * profile_[i] + (1.0 - spec_.weight) * SharpCell(i);
            sums.push_back(static_cast<float>(sum));
        }
        return sums;
    }

  private:
    // The share of cell i behind the edge.
    double SharpCell(std::size_t i) const {
        return std::clamp(t_[i] / spec_.step_t + 0.5, 0.0, 1.0);
    }

    double Pattern(double t) const {
        const double inside = spec_.disc_fresnel_number > 0.0 ? Disc(t) : Straight(t);
        return inside * FadeOut(-t, 0.6 * spec_.dark_t, spec_.dark_t);
    }

    // A band moves the phase pi v^2 / 2 of a fringe by its share of the wavelength.
    double Straight(double t) const {
        const double v = t * std::sqrt(spec_.wavelength_ratio);
        const double fringes =
            (KnifeEdge(v) - 1.0) * Sinc(0.25 * kPi * v * std::abs(v) * spec_.relative_bandwidth);
        if (t <= 0.0) return KnifeEdge(v);
        return 1.0 + fringes * FadeOut(t, 0.75 * spec_.lit_t, spec_.lit_t);
    }

    double Disc(double t) const {
        constexpr int kWavelengths = 3;
        const double whole = std::sqrt(2.0 * spec_.disc_fresnel_number);  // the radius in t
        const double rho = std::abs(1.0 - t / whole);
        const int count = spec_.relative_bandwidth > 0.0 ? kWavelengths : 1;
        double sum = 0.0;
        for (int k = 0; k < count; ++k) {
            const double off = (k + 0.5) / count - 0.5;
            const double ratio = spec_.wavelength_ratio * (1.0 + off * spec_.relative_bandwidth);
            sum += DiscPattern(spec_.disc_fresnel_number * ratio, rho);
        }
        return sum / count;
    }

    // By the source's disc seen from its side: a half ellipse.
    void Blur() {
        constexpr int kPoints = 15;
        std::vector<double> out;
        const double last = profile_.back();
        for (const double t : t_) {
            double sum = 0.0;
            double weights = 0.0;
            for (int k = 0; k < kPoints; ++k) {
                const double off = (k + 0.5) / kPoints * 2.0 - 1.0;
                const double weight = std::sqrt(1.0 - off * off);
                const double place = (t + off * spec_.source_t + spec_.dark_t) / spec_.step_t - 0.5;
                weights += weight;
                if (place <= 0.0) continue;
                const auto i = static_cast<std::size_t>(place);
                if (i + 1 >= profile_.size()) {
                    sum += weight * last;
                    continue;
                }
                const double f = place - static_cast<double>(i);
                sum += weight * ((1.0 - f) * profile_[i] + f * profile_[i + 1]);
            }
            out.push_back(sum / weights);
        }
        profile_ = std::move(out);
    }

    // What the cut tails held goes back into the lit side, so that integral and first moment are
    // those of the sharp edge.
    void KeepMoments() {
        double m0 = 0.0, m1 = 0.0;
        double s0 = 0.0, s1 = 0.0, s2 = 0.0;
        for (std::size_t i = 0; i < t_.size(); ++i) {
            m0 += SharpCell(i) - profile_[i];
            m1 += (SharpCell(i) - profile_[i]) * t_[i];
            s0 += Bump(t_[i]);
            s1 += Bump(t_[i]) * t_[i];
            s2 += Bump(t_[i]) * t_[i] * t_[i];
        }
        const double det = s0 * s2 - s1 * s1;
        const double c0 = (m0 * s2 - m1 * s1) / det;
        const double c1 = (m1 * s0 - m0 * s1) / det;
        for (std::size_t i = 0; i < t_.size(); ++i) profile_[i] += (c0 + c1 * t_[i]) * Bump(t_[i]);
    }

    double Bump(double t) const {
        if (t <= 0.0 || t >= spec_.lit_t) return 0.0;
        const double s = std::sin(kPi * t / spec_.lit_t);
        return s * s;
    }

    // The same for a disc, evenly.
    void KeepDisc() {
        const double whole = std::sqrt(2.0 * spec_.disc_fresnel_number);
        double sum = 0.0;
        for (std::size_t i = 0; i < t_.size(); ++i) {
            const double lo = std::max(0.0, whole - t_[i] - 0.5 * spec_.step_t);
            const double hi = std::max(0.0, whole - t_[i] + 0.5 * spec_.step_t);
            sum += 0.5 * (hi * hi - lo * lo) * profile_[i];
        }
        const double factor = 0.5 * whole * whole / sum;
        for (double& value : profile_) value *= factor;
    }

    const EdgeProfileSpec& spec_;
    std::vector<double> t_, profile_;  // middles of the steps
};

}  // namespace

double KnifeEdge(double v) {
    static const KnifeTable table;
    if (v > KnifeTable::kEnd) return 1.0;
    // Far in the dark only the edge's own wave is left.
    if (v < -KnifeTable::kEnd) return 0.5 / (kPi * kPi * v * v);
    return table.At(v);
}

double DiscPattern(double fresnel_number, double rho) {
    FLARE_CHECK(fresnel_number > 0.0 && rho >= 0.0);
    const double u = 2.0 * kPi * fresnel_number;
    const double x = u * rho;
    // Bessel's functions of all orders at once, downwards (Miller).
    const int most = 2 * (static_cast<int>(x + 12.0 * std::cbrt(x) + 30.0) / 2);
    const bool inside = rho < 1.0;
    const double q = inside ? rho : 1.0 / rho;
    double above = 0.0, here = 1e-280, norm = 0.0;
    double even = 0.0, odd = 0.0;  // sums over orders, nested from the highest down
    for (int k = most; k >= 0; --k) {
        if (std::abs(here) > 1e200) {
            for (double* value : {&above, &here, &norm, &even, &odd}) *value *= 1e-200;
        }
        // even = J_0 - q^2 (J_2 - q^2 (J_4 - ...)), odd = J_1 - q^2 (J_3 - ...).
        double& sum = k % 2 == 0 ? even : odd;
        sum = here - q * q * sum;
        if (k % 2 == 0) norm += k == 0 ? here : 2.0 * here;
        if (k == 0) break;
        // At the axis itself only J_0 is left.
        if (x == 0.0) {
            here = k == 1 ? 1.0 : 0.0;
            continue;
        }
        const double below = 2.0 * k / x * here - above;
        above = here;
        here = below;
    }
    even /= norm;
    odd *= q / norm;
    if (inside) {
        // V_0 = even, V_1 = odd.
        const double half = 0.5 * (u + x * rho);
        return 1.0 + even * even + odd * odd - 2.0 * even * std::cos(half) -
               2.0 * odd * std::sin(half);
    }
    // U_1 = odd, U_2 = J_0 - even.
    const double j0 = here / norm;
    return odd * odd + (j0 - even) * (j0 - even);
}

std::vector<float> EdgeTable(const EdgeProfileSpec& spec) {
    return TableMaker(spec).Run();
}

double TableMean(const float* table, int entries, double place, double half_width) {
    const double last = entries - 1;
    const auto sum = [&](double at) {
        const double inner = std::clamp(at, 0.0, last - 1e-6);
        const auto i = static_cast<std::size_t>(inner);
        const double f = inner - static_cast<double>(i);
        return (1.0 - f) * static_cast<double>(table[i]) + f * static_cast<double>(table[i + 1]) +
               std::max(0.0, at - last);
    };
    const double half = std::max(half_width, 0.25);
    return (sum(place + half) - sum(place - half)) / (2.0 * half);
}

}  // namespace flare
