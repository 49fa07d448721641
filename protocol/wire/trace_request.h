// SPDX-License-Identifier: Apache-2.0
//
// The input of `flare trace` as plain values: exact rays through one bounce sequence. Lens space,
// mm.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "protocol/wire/json_tree.h"

namespace flare::wire {

struct TraceRay {
    std::array<double, 3> origin{};
    std::array<double, 3> direction{};  // not zero; any length
};

// Exactly one of lens and prescription is there.
struct TraceRequest {
    std::optional<std::string> lens;
    std::optional<JsonTree> prescription;
    bool bare_glass = false;
    std::optional<double> f_number;  // absent: the stop as the lens file has it
    double wavelength_nm = 587.5618;
    std::vector<int> sequence;  // surfaces that reflect, in the order the light meets them
    bool clip = true;
    std::vector<TraceRay> rays;
};

}  // namespace flare::wire
