// SPDX-License-Identifier: Apache-2.0
//
// Which coating lies on which surface of a lens, and how to ask for others.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "core/optics/coating_design.h"
#include "core/optics/prescription.h"

namespace flare {

// The coating of a surface between two media: its own, else the lens's default where air meets
// glass. There is nothing to coat between equal media and at the stop. Requires that the names are
// known (FindFaults).
Coating CoatingFor(const Prescription& prescription, const SurfacePrescription& surface,
                   const Glass& before, const Glass& behind);

// Coatings for Lens::WithCoatings, by the names a lens file may use. A bad name is an error of code
// "bad_value" at "/default" or "/surfaces/N", as is a surface that does not exist or is the stop or
// the sensor.
struct CoatingOverride {
    // For every surface between air and glass, also for those that name a coating of their own.
    std::optional<std::string> default_coating;
    // For single surfaces, by number, also between two glasses.
    std::map<int, std::string> surfaces;
    // Further coatings that the names may mean, found before the lens's own.
    CoatingDefinitions coatings;
};

}  // namespace flare
