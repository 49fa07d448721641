// SPDX-License-Identifier: Apache-2.0
//
// Which wavelengths are traced and drawn. Three kinds, from few to many:
//   nodes         traced exactly; positions in between are interpolated as polynomials in
//   1/lambda^2 drawn bands   geometry drawn at this wavelength, evenly spaced in 1/lambda^2
//   (dispersion is nearly
//                 linear in it, so the steps on the sensor are equal)
//   colour bands  where transmittances are evaluated, evenly spaced in wavelength; coatings need
//   many
// Wavelengths are nm.
#pragma once

#include <vector>

#include "core/spectrum/color_response.h"

namespace flare {

// Chebyshev points in 1/lambda^2 over [low, high], from short to long.
std::vector<double> ChebyshevNodes(double low_nm, double high_nm, int count);

// Lagrange weights in 1/lambda^2: value(wavelength) = sum of weight[k] * value(nodes[k]).
std::vector<double> NodeWeights(const std::vector<double>& nodes_nm, double wavelength_nm);

// `count` >= 2 wavelengths evenly spaced in 1/lambda^2 over [low, high].
std::vector<double> EvenInDispersion(double low_nm, double high_nm, int count);
// ... evenly in wavelength.
std::vector<double> EvenInWavelength(double low_nm, double high_nm, int count);

// One term of the sum that makes colour: what colour band `colour` gives to drawn band `drawn`, per
// unit transmittance, as red, green and blue.
struct BandShare {
    int drawn = 0;
    int colour = 0;
    Vec3d rgb{0.0, 0.0, 0.0};
};

// The shares for a light of spectrum `power` as `response` sees it. The colour bands must be evenly
// spaced; a transmittance that is cubic through any four of them is integrated exactly on a 1 nm
// scale. Light between two drawn bands goes to both in proportion, light beyond the last one to
// that. The shares of a transmittance of 1 add up to the light's own colour.
std::vector<BandShare> BandShares(const std::vector<double>& drawn_nm,
                                  const std::vector<double>& colour_nm, const Spectrum& power,
                                  const ColorResponse& response = Rec709Response());

}  // namespace flare
