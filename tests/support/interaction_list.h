// SPDX-License-Identifier: Apache-2.0
//
// A list of interactions written down by hand, at the d line, for tests of single surfaces.
#pragma once

#include <utility>
#include <vector>

#include "core/optics/glass.h"
#include "core/tracing/interaction_list.h"

namespace flare::testing {

inline InteractionList ListOf(std::vector<Interaction> steps, double sensor_z) {
    InteractionList list;
    list.steps = std::move(steps);
    list.sensor_z_mm = sensor_z;
    list.wavelength_nm = kLineD;
    return list;
}

}  // namespace flare::testing
