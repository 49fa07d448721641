// SPDX-License-Identifier: Apache-2.0
//
// Three non-negative, smooth spectra that sum to 1 at every sample; D65 times one of them has the
// colour of one primary of Rec.709. make_primaries.py states the problem and solves it.
#pragma once

#include <array>

namespace flare {

struct PrimariesRow {
    double red, green, blue;
};

const std::array<PrimariesRow, 81>& PrimariesTable();

}  // namespace flare
