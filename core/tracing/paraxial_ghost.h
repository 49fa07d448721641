// SPDX-License-Identifier: Apache-2.0
//
// First-order optics of a bounce sequence: the ABCD matrix from vertex 0 to the sensor and its
// split at each passage through the stop.
#pragma once

#include <vector>

#include "core/optics/paraxial.h"
#include "core/tracing/interaction_list.h"

namespace flare {

struct ParaxialPath {
    Abcd front_to_sensor;
    std::vector<Abcd> front_to_stop;  // one a crossing, in order
    std::vector<Abcd> stop_to_sensor;
};

// What one interaction does to (height, slope) in a section; slopes are dy/dz against +z whichever
// way the light travels.
Abcd StepMatrix(const Interaction& step, Section section);

// In one section; the same in both for a rotational lens.
ParaxialPath ParaxialPathOf(const InteractionList& list, Section section = Section::kY);

}  // namespace flare
