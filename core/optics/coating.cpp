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

// The fields of both polarisations.
struct Fields {
    Field s, p;
};

// cos(z) and sin(z)/q with exp(-|Im z|) taken out. z = k q d, Im z >= 0.
struct ScaledLayer {
    Complex cosine, sine_over_q;
    double log_scale;
};

ScaledLayer ScaleLayer(Complex q, double k_d) {
    const Complex z = q * k_d;
    if (std::abs(z) < 1e-8) return {1.0, k_d, 0.0};
    const double decay = z.imag();
    const Complex turn(std::cos(z.real()), std::sin(z.real()));
    const Complex plus = std::exp(-2.0 * decay) * turn;  // exp(i z - decay)
    const Complex minus = std::conj(turn);               // exp(-i z - decay)
    return {0.5 * (plus + minus), (plus - minus) / (Complex(0.0, 2.0) * q), decay};
}

Field Carried(const ScaledLayer& layer, Complex m12, Complex m21, const Field& field) {
    return {layer.cosine * field.b + m12 * field.c, m21 * field.b + layer.cosine * field.c,
            field.log_scale + layer.log_scale};
}

// Multiplies one layer's characteristic matrices onto the fields.
void Carry(Complex n2, double k_d, double tangential_squared, Fields& fields) {
    const Complex q = NormalComponent(n2, tangential_squared);
    const ScaledLayer m = ScaleLayer(q, k_d);
    const Complex sine = Complex(0.0, -1.0) * m.sine_over_q;
    fields.s = Carried(m, sine, sine * (q * q), fields.s);
    fields.p = Carried(m, sine * (q * q / n2), sine * n2, fields.p);
}

// The same where the wave is an ordinary one: real on the diagonal, imaginary (-i m12, -i m21) off
// it. Most layers at most angles, and several times as fast.
void CarryReal(double n2, double k_d, double tangential_squared, Fields& fields) {
    const double q2 = n2 - tangential_squared;
    const double q = std::sqrt(q2);
    const double z = q * k_d;
    const double cosine = std::cos(z);
    const double sine_over_q = z < 1e-8 ? k_d : std::sin(z) / q;
    const auto carried = [cosine](double m12, double m21, const Field& f) {
        return Field{cosine * f.b + Complex(m12 * f.c.imag(), -m12 * f.c.real()),
                     cosine * f.c + Complex(m21 * f.b.imag(), -m21 * f.b.real()), f.log_scale};
    };
    fields.s = carried(sine_over_q, sine_over_q * q2, fields.s);
    fields.p = carried(sine_over_q * (q2 / n2), sine_over_q * n2, fields.p);
}

Reflection BareReflection(double n_in, double n_out, double cos_in) {
    const double q_in = n_in * cos_in;
    const double q_out_squared = (n_out - n_in) * (n_out + n_in) + q_in * q_in;
    if (q_out_squared <= 0.0 || q_in <= 0.0) return {1.0, 0.0};
    const double q_out = std::sqrt(q_out_squared);
    const double sum = q_in + q_out;
    const double a = n_in * n_in * q_out;
    const double b = n_out * n_out * q_in;
    const double t_s = 4.0 * q_in * q_out / (sum * sum);
    const double t_p = 4.0 * a * b / ((a + b) * (a + b));
    return {BareReflectance(n_in, n_out, q_in, q_out), 0.5 * (t_s + t_p)};
}

}  // namespace

double BareReflectance(double n_in, double n_out, double q_in, double q_out) {
    const double in2 = n_in * n_in;
    const double out2 = n_out * n_out;
    const double step = (n_out - n_in) * (n_out + n_in);  // n_out^2 - n_in^2 = q_out^2 - q_in^2
    const double sum = q_in + q_out;
    const double r_s = step / (sum * sum);
    const double a = in2 * q_out;
    const double b = out2 * q_in;
    // a - b over a + b; with a^2 - b^2 = step (n_in^4 - q_in^2 (n_in^2 + n_out^2)).
    const double r_p = step * (in2 * in2 - q_in * q_in * (in2 + out2)) / ((a + b) * (a + b));
    return 0.5 * (r_s * r_s + r_p * r_p);
}

void Coating::AddTo(Fingerprinter& fingerprinter) const {
    fingerprinter.Add(static_cast<std::int64_t>(layers.size()));
    for (const CoatingLayer& layer : layers) {
        layer.material.AddTo(fingerprinter);
        fingerprinter.Add(layer.thickness_nm);
    }
}

CoatingAtWavelength::CoatingAtWavelength(const Coating& coating, double wavelength_nm) {
    layers_.reserve(coating.layers.size());
    for (const CoatingLayer& layer : coating.layers) {
        const Complex n = layer.material.Index(wavelength_nm);
        layers_.push_back({n * n, 2.0 * kPi / wavelength_nm * layer.thickness_nm});
        absorbs_ = absorbs_ || n.imag() != 0.0;
    }
}

Reflection CoatingAtWavelength::Of(bool reversed, double n_in, double n_out, double cos_in) const {
    const double c = std::clamp(cos_in, 0.0, 1.0);
    if (layers_.empty()) {
        if (n_in == n_out) return {0.0, 1.0};
        return BareReflection(n_in, n_out, c);
    }
    if (c == 0.0) return {1.0, 0.0};

    const double q_in = n_in * c;
    const double tangential_squared = n_in * n_in * (1.0 - c * c);
    const Complex q_out = NormalComponent((n_out - n_in) * (n_out + n_in) + q_in * q_in, 0.0);

    const double in2 = n_in * n_in;
    const double out2 = n_out * n_out;
    // s: [B; C] starts as [1; q_out]. p: times q_out, as [q_out; n_out^2]; there the entrance side
    // is multiplied by q_in. The layer next to the exit comes first.
    Fields fields{{1.0, q_out, 0.0}, {q_out, out2, 0.0}};
    for (std::size_t j = 0; j < layers_.size(); ++j) {
        const Layer& layer = reversed ? layers_[j] : layers_[layers_.size() - 1 - j];
        const double real = layer.index_squared.real();
        if (layer.index_squared.imag() == 0.0 && real > tangential_squared) {
            CarryReal(real, layer.k_d, tangential_squared, fields);
        } else {
            Carry(layer.index_squared, layer.k_d, tangential_squared, fields);
        }
    }

    const auto& [s, p] = fields;
    const Complex s_sum = q_in * s.b + s.c;
    const double r_s = std::norm((q_in * s.b - s.c) / s_sum);
    const double t_s = 4.0 * q_in * q_out.real() / std::norm(s_sum) * std::exp(-2.0 * s.log_scale);

    const Complex p_sum = in2 * p.b + q_in * p.c;
    const double r_p = std::norm((in2 * p.b - q_in * p.c) / p_sum);
    const double t_p =
        4.0 * in2 * q_in * out2 * q_out.real() / std::norm(p_sum) * std::exp(-2.0 * p.log_scale);

    return {0.5 * (r_s + r_p), 0.5 * (t_s + t_p)};
}

Reflection ReflectionOf(const Coating& coating, bool reversed, double n_in, double n_out,
                        double cos_in, double wavelength_nm) {
    return CoatingAtWavelength(coating, wavelength_nm).Of(reversed, n_in, n_out, cos_in);
}

}  // namespace flare
