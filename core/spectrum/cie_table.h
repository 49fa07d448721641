// SPDX-License-Identifier: Apache-2.0
//
// Standard data of the CIE, sampled like Spectrum (380 to 780 nm in steps of 5 nm): the colour
// matching functions of the 1931 2-degree observer (ISO/CIE 11664-1) and the relative spectral
// power of illuminant D65 (ISO/CIE 11664-2), 100 at 560 nm.
#pragma once

#include <array>

namespace flare {

struct CieRow {
    double x_bar, y_bar, z_bar;
    double d65;
};

const std::array<CieRow, 81>& CieTable();

}  // namespace flare
