// SPDX-License-Identifier: Apache-2.0
//
// A lens zoomed and focused. Gaps and semi-diameters follow the lens file's tables between their
// positions by monotone cubics (Fritsch & Carlson 1980), over the logarithm of the focal length and
// over 1 / focus distance.
//
// Between two zoom positions a cam, not a formula, moves the groups of a real zoom: what is asked
// for is a focal length with the picture in focus. So the place between two positions is found at
// which the focal length, interpolated in proportion to the nominal one, is met, and the sensor
// follows the paraxial focus from the one position's residual defocus to the other's. At the
// positions themselves the numbers of the file stand as they are.
//
// A lens without a focus table is focused by moving the sensor (unit focusing): with the distance S
// = focus - HH' between object and image less that between the principal planes,
// s' = (S - sqrt(S^2 - 4 f S)) / 2 and the sensor moves by s' - f. An infinite distance is none.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/optics/lens.h"

namespace flare {

struct LensState {
    std::optional<double> focus_m;  // from the sensor; absent: infinity. Above 0
    std::optional<double> zoom_mm;  // nominal focal length; absent: the lens's default. Above 0

    friend bool operator==(const LensState&, const LensState&) = default;
};

// One value of a state that had to be brought into the lens's range.
struct StateClamp {
    std::string field;  // "focus_m" or "zoom_mm"
    double from = 0.0, to = 0.0;
};

struct LensInState {
    std::shared_ptr<const Lens> lens;
    LensState state;  // as set: after clamping; zoom_mm is absent for a lens that is no zoom
    std::vector<StateClamp> clamped;
};

// `base` must be as Lens::Build made it (infinity, first position), with any coatings. Fails with
// "bad_lens" where the lens cannot be built in that state.
Result<LensInState> SetState(const std::shared_ptr<const Lens>& base, const LensState& state);

// What is wrong with a prescription's state table (see prescription_faults.h).
struct StateFault {
    std::string message;
    std::string where;
};
std::vector<StateFault> FindStateFaults(const Prescription& prescription);

// Monotone cubic interpolation of y over rising x at `at`, constant beyond the ends.
double MonotoneAt(const std::vector<double>& x, const std::vector<double>& y, double at);

}  // namespace flare
