// SPDX-License-Identifier: Apache-2.0
//
// What stops a prescription from being built into a Lens, surface by surface: numbers that are not
// numbers, glass that no glass has, rims wider than their sphere, a missing stop. Lens::Build
// refuses at the first fault; the lint shows them all.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/optics/prescription.h"

namespace flare {

// Limits that bound the work a lens asks for and keep its arithmetic far from overflow.
inline constexpr int kMaxSurfaces = 100;
inline constexpr double kMaxGapMm = 1e5;
inline constexpr double kMaxSemiDiameterMm = 1e4;
inline constexpr double kMinLengthMm = 1e-6;  // of a radius and of a semi-diameter
inline constexpr double kMaxNd = 4.0;
// Glasses have V_d between 15 and 100. From 10 up the Cauchy index never falls below 1.
inline constexpr double kMinVd = 10.0;
inline constexpr double kMaxVd = 200.0;

inline constexpr std::size_t kMaxStatePositions = 64;  // along one axis
inline constexpr double kMaxConic = 1e6;
// The largest part of its semi-diameter that one coefficient may bend a surface's rim.
inline constexpr double kMaxAsphericSags = 2.0;

struct PrescriptionFault {
    std::string code;     // "gap", "semi_diameter", "index", "no_stop", "several_stops", ...
    std::string message;  // what, and how much against what
    std::string where;    // the surface's place; "" for the whole
};

// In the order of the surfaces; then what concerns the whole.
std::vector<PrescriptionFault> FindFaults(const Prescription& prescription);

// The medium behind a surface. Fails with a fault's code and message, and the surface's place,
// where its glass, nd and vd make none.
Result<Glass> MediumOf(const SurfacePrescription& surface);

// "surface 3": how messages name a surface.
std::string SurfaceLabel(std::size_t index);
// A length or ratio in messages: six significant digits.
std::string NumberText(double value);

}  // namespace flare
