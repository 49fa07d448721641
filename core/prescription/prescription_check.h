// SPDX-License-Identifier: Apache-2.0
//
// The lint: does a lens file tell the truth about itself? Each finding says what, where, how much.
#pragma once

#include <string>
#include <vector>

#include "core/optics/prescription.h"

namespace flare {

enum class Severity { kWarning, kError };

struct Finding {
    Severity severity = Severity::kWarning;
    std::string code;     // "efl", "f_number", "semi_diameter", "overlap", "no_stop", "source", ...
    std::string message;  // what, and how much against what
    std::string where;    // place in the file, "" for the whole
};

// Tolerances, relative unless a unit is named. Makers round focal lengths to a percent; a tenth of
// a stop is 3.5 % of the f-number, a third of one 12 %.
inline constexpr double kEflWarning = 0.01, kEflError = 0.05;
inline constexpr double kFNumberWarning = 0.035, kFNumberError = 0.12;
inline constexpr double kRimWarning = 0.05;      // of the axial beam's diameter, lost to rims
inline constexpr double kFocusBlurMm = 0.03;     // disc of a point on the axis, wide open
inline constexpr double kNearHemisphere = 0.98;  // semi-diameter / radius
inline constexpr double kOverlapMm = 1e-3;

// All findings, errors first. An error is either what stops Lens::Build (every such fault is found,
// not only the first) or a design figure that the table misses by more than kEflError or
// kFNumberError ("efl", "f_number"), which is a slip in the table though the lens can be built.
std::vector<Finding> CheckPrescription(const Prescription& prescription);

}  // namespace flare
