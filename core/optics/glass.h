// SPDX-License-Identifier: Apache-2.0
//
// A medium: its refractive index against wavelength, relative to air, and what it absorbs. A small
// value, cheap to copy, safe to share between threads. Wavelengths are in air, nm. Named glasses
// come from glass_catalogue.h; the formulas and their sources stand in docs/physics/glass.md.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

namespace flare {

class Fingerprinter;

inline constexpr double kLineD = 587.5618;  // helium d, nm: design wavelength
inline constexpr double kLineF = 486.1327;  // hydrogen F, nm
inline constexpr double kLineC = 656.2725;  // hydrogen C, nm

// What a catalogue says of a glass. With l the wavelength in micrometres, the sum over the terms:
//   kSellmeier      n^2 = constant + sum strength l^2 / (l^2 - place)
//   kSquaredPowers  n^2 = constant + sum strength l^place
//   kPowers         n   = constant + sum strength l^place
struct GlassData {
    enum class Formula { kSellmeier, kSquaredPowers, kPowers };
    struct Term {
        double strength = 0.0;
        double place = 0.0;  // um^2, or the power: a whole number
        friend bool operator==(const Term&, const Term&) = default;
    };
    struct AbsorptionPoint {
        double wavelength_nm = 0.0;
        double k = 0.0;  // imaginary part of the index, >= 0
        friend bool operator==(const AbsorptionPoint&, const AbsorptionPoint&) = default;
    };

    Formula formula = Formula::kSellmeier;
    double constant = 1.0;
    std::vector<Term> terms;
    double low_nm = 0.0, high_nm = 0.0;       // where the formula holds
    std::vector<AbsorptionPoint> absorption;  // wavelengths rise; empty: nothing is known

    friend bool operator==(const GlassData&, const GlassData&) = default;
};

class Glass {
  public:
    static Glass Air() { return Glass(1.0, 0.0); }
    // Two-term Cauchy dispersion n = A + B / lambda^2 through (n_d, V_d): exact at d and in
    // n_F - n_C. Within 1.5e-4 of the Sellmeier formula over 400-706 nm for N-BK7, 1.4e-3 off at
    // 1014 nm. No V_d: no dispersion. Requires n_d >= 1 and, if given, V_d > 0; n_d == 1 is not
    // dispersive. Absorbs nothing.
    static Glass FromNdVd(double nd, std::optional<double> vd);
    // Requires data that GlassCatalogue has read: a rising range without a pole in it.
    explicit Glass(GlassData data);

    // Outside low_nm() .. high_nm() the index of the nearer end: a formula has poles out there.
    double Index(double wavelength_nm) const {
        const double nm = std::clamp(wavelength_nm, low_nm(), high_nm());
        return data_ != nullptr ? IndexOfData(nm) : a_ + b_nm2_ / (nm * nm);
    }
    double nd() const { return Index(kLineD); }
    // (n_d - 1) / (n_F - n_C); infinite without dispersion, NaN for air.
    double vd() const { return (nd() - 1.0) / (Index(kLineF) - Index(kLineC)); }
    bool is_air() const { return data_ == nullptr && a_ == 1.0 && b_nm2_ == 0.0; }
    double low_nm() const { return data_ != nullptr ? data_->low_nm : 300.0; }
    double high_nm() const { return data_ != nullptr ? data_->high_nm : 1100.0; }

    // Internal transmittance over s mm is exp(-AbsorptionPerMm(lambda) s): 4 pi k / lambda. Between
    // two points ln k is linear in 1 / lambda (k itself where one of them is 0); beyond the first
    // and the last their k holds. 0 where the catalogue has no points.
    double AbsorptionPerMm(double wavelength_nm) const;
    bool absorbs() const { return data_ != nullptr && !data_->absorption.empty(); }

    // Everything that Index depends on, and everything that AbsorptionPerMm does.
    void AddDispersionTo(Fingerprinter& fingerprinter) const;
    void AddAbsorptionTo(Fingerprinter& fingerprinter) const;

    // Equal numbers: two names of one catalogue entry are one glass, a formula and the (n_d, V_d)
    // that approximates it are two.
    friend bool operator==(const Glass& one, const Glass& other);

  private:
    Glass(double a, double b_nm2) : a_(a), b_nm2_(b_nm2) {}
    double IndexOfData(double wavelength_nm) const;

    double a_ = 1.0;
    double b_nm2_ = 0.0;
    std::shared_ptr<const GlassData> data_;  // in place of the Cauchy terms
};

}  // namespace flare
