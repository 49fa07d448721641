// SPDX-License-Identifier: Apache-2.0
//
// Everything is written in q = n cos(theta), the normal component of the wave vector over 2 pi /
// lambda. The admittances are q (s) and n^2 / q (p); multiplying the p equations through by q keeps
// them finite at grazing incidence and at the critical angle, where q is 0. For complex indices
// n + i k the time factor is exp(-i omega t), hence the minus signs in the matrices.
#include "core/optics/coating.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/base/units.h"

namespace flare {
namespace {

using Complex = std::complex<double>;

// Normal component for tangential component squared n_in^2 sin^2; absorbing and evanescent waves
// decay, so the imaginary part is not negative.
Complex NormalComponent(Complex index_squared, double tangential_squared) {
    const Complex q = std::sqrt(index_squared - tangential_squared);
    return q.imag() < 0.0 ? -q : q;
}

// The field vector [B; C] carried through the stack, and the power of e taken out of it so that
// thick absorbing or evanescent layers do not overflow.
struct Field {
    Complex b, c;
    double log_scale = 0.0;
};

// cos(z) and sin(z)/q with exp(-|Im z|) taken out. z = k q d.
struct ScaledLayer {
    Complex cosine, sine_over_q;
    double log_scale;
};

ScaledLayer ScaleLayer(Complex q, double k_d) {
    const Complex z = q * k_d;
    const double decay = std::abs(z.imag());
    if (std::abs(z) < 1e-8) return {1.0, k_d, 0.0};
    const Complex i(0.0, 1.0);
    const Complex plus = std::exp(i * z - decay);
    const Complex minus = std::exp(-i * z - decay);
    return {0.5 * (plus + minus), (plus - minus) / (2.0 * i) / q, decay};
}

struct Stack {
    const Coating* coating;
    bool reversed;
    double tangential_squared;
    double wave_number;  // 2 pi / lambda, 1/nm
};

// Multiplies the characteristic matrices, last layer first, onto the exit medium's vector.
Field Through(const Stack& stack, Field field, bool p_polarised) {
    const auto& layers = stack.coating->layers;
    const Complex minus_i(0.0, -1.0);
    for (std::size_t j = 0; j < layers.size(); ++j) {
        const CoatingLayer& layer = stack.reversed ? layers[j] : layers[layers.size() - 1 - j];
        const Complex n2 = layer.index * layer.index;
        const Complex q = NormalComponent(n2, stack.tangential_squared);
        const ScaledLayer s = ScaleLayer(q, stack.wave_number * layer.thickness_nm);
        const Complex m12 = minus_i * s.sine_over_q * (p_polarised ? q * q / n2 : Complex(1.0));
        const Complex m21 = minus_i * s.sine_over_q * (p_polarised ? n2 : q * q);
        field = {s.cosine * field.b + m12 * field.c, m21 * field.b + s.cosine * field.c,
                 field.log_scale + s.log_scale};
    }
    return field;
}

// A bare interface, with the difference of the indices taken first: no cancellation however close
// they are.
Reflection BareReflection(double n_in, double n_out, double cos_in) {
    const double q_in = n_in * cos_in;
    const double step = (n_out - n_in) * (n_out + n_in);  // n_out^2 - n_in^2
    const double q_out_squared = step + q_in * q_in;
    if (q_out_squared <= 0.0 || q_in <= 0.0) return {1.0, 0.0};
    const double q_out = std::sqrt(q_out_squared);
    const double sum = q_in + q_out;
    const double r_s = -step / (sum * sum);
    const double a = n_in * n_in * q_out;
    const double b = n_out * n_out * q_in;
    // a - b over a + b; with a^2 - b^2 = step (n_in^4 - q_in^2 (n_in^2 + n_out^2)).
    const double in2 = n_in * n_in;
    const double r_p =
        step * (in2 * in2 - q_in * q_in * (in2 + n_out * n_out)) / ((a + b) * (a + b));
    const double t_s = 4.0 * q_in * q_out / (sum * sum);
    const double t_p = 4.0 * a * b / ((a + b) * (a + b));
    return {0.5 * (r_s * r_s + r_p * r_p), 0.5 * (t_s + t_p)};
}

Coating QuarterWave(std::string name, double index, double design_nm) {
    return {std::move(name), {{index, design_nm / 4.0 / index}}};
}

}  // namespace

Result<Coating> CoatingByName(std::string_view name) {
    if (name == "bare" || name == "none") return Coating{};
    constexpr std::string_view prefix = "mgf2-";
    if (name.substr(0, prefix.size()) == prefix) {
        const std::string_view digits = name.substr(prefix.size());
        int design_nm = 0;
        const auto [end, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), design_nm);
        if (error == std::errc() && end == digits.data() + digits.size() && design_nm >= 300 &&
            design_nm <= 1100) {
            return QuarterWave(std::string(name), 1.38, design_nm);
        }
    }
    return Error{"bad_lens",
                 "unknown coating \"" + std::string(name) +
                     "\"; known are \"bare\" and \"mgf2-NNN\" with NNN from 300 to 1100 nm",
                 ""};
}

Reflection ReflectionOf(const Coating& coating, bool reversed, double n_in, double n_out,
                        double cos_in, double wavelength_nm) {
    const double c = std::clamp(cos_in, 0.0, 1.0);
    if (coating.bare()) {
        if (n_in == n_out) return {0.0, 1.0};
        return BareReflection(n_in, n_out, c);
    }
    if (c == 0.0) return {1.0, 0.0};

    const double q_in = n_in * c;
    const double tangential_squared = n_in * n_in * (1.0 - c * c);
    const Complex q_out = NormalComponent((n_out - n_in) * (n_out + n_in) + q_in * q_in, 0.0);
    const Stack stack{&coating, reversed, tangential_squared, 2.0 * kPi / wavelength_nm};

    // s: [B; C] starts as [1; q_out].
    const Field s = Through(stack, {1.0, q_out, 0.0}, false);
    const Complex s_sum = q_in * s.b + s.c;
    const double r_s = std::norm((q_in * s.b - s.c) / s_sum);
    const double t_s = 4.0 * q_in * q_out.real() / std::norm(s_sum) * std::exp(-2.0 * s.log_scale);

    // p: [B; C] times q_out starts as [q_out; n_out^2]; the entrance side is multiplied by q_in.
    const double in2 = n_in * n_in;
    const double out2 = n_out * n_out;
    const Field p = Through(stack, {q_out, out2, 0.0}, true);
    const Complex p_sum = in2 * p.b + q_in * p.c;
    const double r_p = std::norm((in2 * p.b - q_in * p.c) / p_sum);
    const double t_p =
        4.0 * in2 * q_in * out2 * q_out.real() / std::norm(p_sum) * std::exp(-2.0 * p.log_scale);

    return {0.5 * (r_s + r_p), 0.5 * (t_s + t_p)};
}

}  // namespace flare
