// SPDX-License-Identifier: Apache-2.0
//
// The spectrum of a light that is more than a mix of the Rec.709 primaries: a hot body, a measured
// lamp, or a colour outside the Rec.709 gamut. Safe from any thread.
#pragma once

#include "core/spectrum/spectrum.h"

namespace flare {

// Planck's law at this temperature (c2 = 0.014387769 m K), scaled to luminance 1, the unit in which
// WhiteSpectrum has it too.
Spectrum BlackbodySpectrum(double kelvin);

// Luminance in that unit.
double Luminance(const Spectrum& power);

// A spectrum of the colour `rgb` (linear Rec.709, any sign) that departs little from
// `base`: exactly base times v where rgb is v times the base's own colour; the smooth mix of
// primaries over the base while that is nowhere negative (for base = white: LightSpectrum). Beyond,
// the nearest one that is nowhere negative, in the mean square of its ratio to the base. A colour
// that no light has (outside the spectral locus, as the primaries of ACES2065-1 and, by a little,
// of ACEScg) gets that of the nearest real one towards white, and the rest as a mix of primaries
// that is negative somewhere. The colour is right to 1e-9 of its largest channel in every case.
Spectrum SpectrumOfColor(const Spectrum& base, Vec3d rgb);

}  // namespace flare
