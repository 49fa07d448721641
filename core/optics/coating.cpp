// SPDX-License-Identifier: Apache-2.0
//
// Everything is written in q = n cos(theta), the normal component of the wave vector over 2 pi /
// lambda. The admittances are q (s) and n^2 / q (p); multiplying the p equations through by q keeps
// them finite at grazing incidence and at the critical angle, where q is 0. For complex indices
// n + i k the time factor is exp(-i omega t), hence the minus signs in the matrices.
#include "core/optics/coating.h"

#include <algorithm>
#include <cmath>
#include <complex>

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
    double wavelength_nm;
};

// The fields of both polarisations.
struct Fields {
    Field s, p;
};

Field Carried(const ScaledLayer& layer, Complex m12, Complex m21, const Field& field) {
    return {layer.cosine * field.b + m12 * field.c, m21 * field.b + layer.cosine * field.c,
            field.log_scale + layer.log_scale};
}

// Multiplies the characteristic matrices, last layer first, onto the exit medium's vectors.
Fields Through(const Stack& stack, Fields fields) {
    const auto& layers = stack.coating->layers;
    const Complex minus_i(0.0, -1.0);
    for (std::size_t j = 0; j < layers.size(); ++j) {
        const CoatingLayer& layer = stack.reversed ? layers[j] : layers[layers.size() - 1 - j];
        const Complex n = layer.material.Index(stack.wavelength_nm);
        const Complex n2 = n * n;
        const Complex q = NormalComponent(n2, stack.tangential_squared);
        const ScaledLayer m = ScaleLayer(q, 2.0 * kPi / stack.wavelength_nm * layer.thickness_nm);
        const Complex sine = minus_i * m.sine_over_q;
        fields.s = Carried(m, sine, sine * (q * q), fields.s);
        fields.p = Carried(m, sine * (q * q / n2), sine * n2, fields.p);
    }
    return fields;
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

}  // namespace

void Coating::AddTo(Fingerprinter& fingerprinter) const {
    fingerprinter.Add(static_cast<std::int64_t>(layers.size()));
    for (const CoatingLayer& layer : layers) {
        layer.material.AddTo(fingerprinter);
        fingerprinter.Add(layer.thickness_nm);
    }
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
    const Stack stack{&coating, reversed, tangential_squared, wavelength_nm};

    const double in2 = n_in * n_in;
    const double out2 = n_out * n_out;
    // s: [B; C] starts as [1; q_out]. p: times q_out, as [q_out; n_out^2]; there the entrance side
    // is multiplied by q_in.
    const auto [s, p] = Through(stack, {{1.0, q_out, 0.0}, {q_out, out2, 0.0}});

    const Complex s_sum = q_in * s.b + s.c;
    const double r_s = std::norm((q_in * s.b - s.c) / s_sum);
    const double t_s = 4.0 * q_in * q_out.real() / std::norm(s_sum) * std::exp(-2.0 * s.log_scale);

    const Complex p_sum = in2 * p.b + q_in * p.c;
    const double r_p = std::norm((in2 * p.b - q_in * p.c) / p_sum);
    const double t_p =
        4.0 * in2 * q_in * out2 * q_out.real() / std::norm(p_sum) * std::exp(-2.0 * p.log_scale);

    return {0.5 * (r_s + r_p), 0.5 * (t_s + t_p)};
}

}  // namespace flare
