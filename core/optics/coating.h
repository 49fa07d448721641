// SPDX-License-Identifier: Apache-2.0
//
// Thin-film coatings by the characteristic-matrix method (Abeles; e.g. Macleod, Thin-Film Optical
// Filters, ch. 2), exact at any angle, any number of layers, absorbing layers and total internal
// reflection included.
#pragma once

#include <complex>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace flare {

struct CoatingLayer {
    std::complex<double> index;  // n + i k, k >= 0 absorbs
    double thickness_nm = 0.0;
};

// Layers are listed from the medium of lower index (air, as a rule) to that of higher index. An
// empty list is the bare interface.
struct Coating {
    std::string name = "bare";
    std::vector<CoatingLayer> layers;

    bool bare() const { return layers.empty(); }
};

// Named coatings: "bare" (alias "none"), "mgf2-550" (n 1.38, 99.64 nm: a quarter wave at 550 nm),
// and "mgf2-NNN": a quarter wave of n 1.38 at NNN nm, 300..1100.
Result<Coating> CoatingByName(std::string_view name);

// Power fractions for unpolarised light: the mean of s and p. reflectance + transmittance = 1 where
// nothing absorbs.
struct Reflection {
    double reflectance = 0.0;
    double transmittance = 0.0;
};

// Light that meets the interface from medium n_in (real index) at the angle with cosine `cos_in`
// (0..1) and goes on into n_out. `reversed` is true if the light travels against the order of
// `layers`, i.e. comes from the high-index side. At total reflection the transmittance is 0.
Reflection ReflectionOf(const Coating& coating, bool reversed, double n_in, double n_out,
                        double cos_in, double wavelength_nm);

}  // namespace flare
