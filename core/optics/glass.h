// SPDX-License-Identifier: Apache-2.0
//
// The refractive index of a medium against wavelength, relative to air. Wavelengths are in air, nm.
#pragma once

#include <optional>

namespace flare {

inline constexpr double kLineD = 587.5618;  // helium d, nm: design wavelength
inline constexpr double kLineF = 486.1327;  // hydrogen F, nm
inline constexpr double kLineC = 656.2725;  // hydrogen C, nm

// Two-term Cauchy dispersion n = A + B / lambda^2 through (n_d, V_d): exact at d and in n_F - n_C.
// Within 1.5e-4 of the Sellmeier formula over 400-706 nm for N-BK7, 1.4e-3 off at 1014 nm.
class Glass {
  public:
    static Glass Air() { return Glass(1.0, 0.0); }
    // No V_d: no dispersion. Requires n_d >= 1 and, if given, V_d > 0; n_d == 1 is not dispersive.
    static Glass FromNdVd(double nd, std::optional<double> vd);

    double Index(double wavelength_nm) const {
        return a_ + b_nm2_ / (wavelength_nm * wavelength_nm);
    }
    double AbsorptionPerMm(double /*wavelength_nm*/) const { return 0.0; }
    bool absorbs() const { return false; }
    double nd() const { return Index(kLineD); }
    bool is_air() const { return a_ == 1.0 && b_nm2_ == 0.0; }
    double cauchy_a() const { return a_; }
    double cauchy_b_nm2() const { return b_nm2_; }

    friend bool operator==(const Glass&, const Glass&) = default;

  private:
    Glass(double a, double b_nm2) : a_(a), b_nm2_(b_nm2) {}
    double a_;
    double b_nm2_;
};

}  // namespace flare
