// SPDX-License-Identifier: Apache-2.0
//
// A measured curve (a lamp's power, a sensor's sensitivity) as a Spectrum. The curve is straight
// between its points and zero beyond them. Where points lie 5 nm apart or more, samples are its
// values; finer ones, with lines that the samples would step over, are averaged with a triangle of
// 5 nm to both sides, which keeps their area.
#pragma once

#include <vector>

#include "core/spectrum/spectrum.h"

namespace flare {

// `wavelengths_nm` strictly ascending, as many as `values`, at least one.
Spectrum SpectrumOfCurve(const std::vector<double>& wavelengths_nm,
                         const std::vector<double>& values);

}  // namespace flare
