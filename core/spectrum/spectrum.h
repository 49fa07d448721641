// SPDX-License-Identifier: Apache-2.0
//
// Spectra as samples every 5 nm from 380 to 780 nm, and what they look like in linear Rec.709 under
// the CIE 1931 2-degree observer.
#pragma once

#include <array>

#include "core/base/vec.h"

namespace flare {

inline constexpr int kSpectrumSamples = 81;
inline constexpr double kSpectrumFirst_nm = 380.0;
inline constexpr double kSpectrumStep_nm = 5.0;

using Spectrum = std::array<double, kSpectrumSamples>;

constexpr double SampleWavelength(int i) {
    return kSpectrumFirst_nm + kSpectrumStep_nm * i;
}

// Linear Rec.709 (D65 white) response to unit power in each sample, scaled so that the D65 spectrum
// below sums to exactly (1, 1, 1). Single samples may be negative: they lie outside the gamut.
const std::array<Vec3d, kSpectrumSamples>& Rec709Response();

// Relative power of D65 (reference white), scaled as Rec709Response expects.
const Spectrum& WhiteSpectrum();

// The spectrum of a light whose direct image through a colourless lens has the value `rgb`: white
// times a mix of three smooth, non-negative primaries that sum to 1. Linear in rgb; exact for every
// rgb, also outside [0, 1].
Spectrum LightSpectrum(Vec3d rgb);

// Sum of response times power.
Vec3d Rec709FromSpectrum(const Spectrum& power);

}  // namespace flare
