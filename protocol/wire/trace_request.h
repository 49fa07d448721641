// SPDX-License-Identifier: Apache-2.0
//
// The input of `flare trace` as plain values: exact rays through one bounce sequence. Lens space,
// mm.
#pragma once

#include <array>
#include <vector>

#include "protocol/wire/lens_choice.h"

namespace flare::wire {

struct TraceRay {
    std::array<double, 3> origin{};
    std::array<double, 3> direction{};  // not zero; any length
};

struct TraceRequest {
    LensChoice lens;  // without an f-number: the stop as the lens file has it
    double wavelength_nm = 587.5618;
    std::vector<int> sequence;  // surfaces that reflect, in the order the light meets them
    bool clip = true;
    std::vector<TraceRay> rays;
};

}  // namespace flare::wire
