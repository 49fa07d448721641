// SPDX-License-Identifier: Apache-2.0
//
// Thin-film coatings by the characteristic-matrix method (Abeles; e.g. Macleod, Thin-Film Optical
// Filters, ch. 2), exact at any angle, any number of layers, absorbing layers and total internal
// reflection included.
#pragma once

#include <complex>
#include <string>
#include <vector>

#include "core/base/fingerprint.h"
#include "core/optics/coating_material.h"

namespace flare {

struct CoatingLayer {
    CoatingMaterial material;
    double thickness_nm = 0.0;

    friend bool operator==(const CoatingLayer&, const CoatingLayer&) = default;
};

// A stack as it lies on one interface. Layers are listed from the medium of lower index (air, as a
// rule) to that of higher index. An empty list is the bare interface. What stack a named coating
// puts on which pair of media is up to its CoatingDesign (coating_design.h).
struct Coating {
    std::string name = "bare";
    std::vector<CoatingLayer> layers;
    std::string note;  // where the stack is not quite what its name promises: why

    bool bare() const { return layers.empty(); }
    // What it does to light: the layers, not the name.
    void AddTo(Fingerprinter& fingerprinter) const;
};

// Power fractions for unpolarised light: the mean of s and p. reflectance + transmittance = 1 where
// nothing absorbs. Where something does, the sum is less, the transmittance is still the same from
// both sides (at conjugate angles) and the reflectance is not.
struct Reflection {
    double reflectance = 0.0;
    double transmittance = 0.0;
};

// The reflectance of an interface without a coating, from the normal components q = n cos of the
// light on both sides (Fresnel). The difference of the indices is taken first: no cancellation
// however close they are. The same from both sides; q_in + q_out > 0.
double BareReflectance(double n_in, double n_out, double q_in, double q_out);

// Light that meets the interface from medium n_in (real index) at the angle with cosine `cos_in`
// (0..1) and goes on into n_out. `reversed` is true if the light travels against the order of
// `layers`, i.e. comes from the high-index side. At total reflection the transmittance is 0.
Reflection ReflectionOf(const Coating& coating, bool reversed, double n_in, double n_out,
                        double cos_in, double wavelength_nm);

// The same for one wavelength, with the layers' indices looked up once: for many angles. It does
// not keep the coating.
class CoatingAtWavelength {
  public:
    CoatingAtWavelength(const Coating& coating, double wavelength_nm);

    // As ReflectionOf.
    Reflection Of(bool reversed, double n_in, double n_out, double cos_in) const;
    // Then R + T < 1, and R differs from side to side.
    bool absorbs() const { return absorbs_; }

  private:
    struct Layer {
        std::complex<double> index_squared;
        double k_d = 0.0;  // 2 pi thickness / wavelength
    };
    std::vector<Layer> layers_;
    bool absorbs_ = false;
};

}  // namespace flare
