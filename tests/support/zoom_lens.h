// SPDX-License-Identifier: Apache-2.0
//
// A zoom of two simple groups whose figures follow from closed forms, and a lens focused by a
// table.
#pragma once

#include <iterator>
#include <limits>
#include <vector>

#include "tests/support/paraxial_table.h"
#include "tests/support/seed_lens.h"

namespace flare::testing {

// Two groups of -60 and 45 mm: their distance sets the focal length, from 41 to 135 mm.
inline Prescription TwoGroups(double distance_mm, double sensor_mm) {
    Prescription lens = Assemble(
        "two-groups", {Sphere(0.0, 2.0, 1.5, 60.0, 20.0), Sphere(30.0, distance_mm, 1.0, 0.0, 18.0),
                       Stop(1.0, 8.0), Sphere(22.5, 4.0, 1.5, 60.0, 10.0),
                       Sphere(0.0, sensor_mm, 1.0, 0.0, 10.0)});
    lens.surfaces.back().gap_mm = sensor_mm;
    lens.surfaces.back().gap_given = true;
    return lens;
}

inline double DistanceFor(double efl_mm) {
    double lo = 1.0, hi = 80.0;  // the focal length falls
    for (int i = 0; i < 100; ++i) {
        const double mid = 0.5 * (lo + hi);
        (FiguresOf(TwoGroups(mid, 60.0)).efl_mm > efl_mm ? lo : hi) = mid;
    }
    return 0.5 * (lo + hi);
}

struct ZoomPosition {
    double nominal_mm, real_over_nominal, defocus_mm, stop_mm;
};
// Nominal lengths that the lens misses a little, and a sensor that is a little out of focus.
inline constexpr ZoomPosition kPositions[] = {{45.0, 1.010, 0.010, 6.0},
                                              {70.0, 0.990, -0.020, 7.0},
                                              {90.0, 0.995, 0.000, 7.5},
                                              {115.0, 1.020, 0.030, 8.0}};

inline std::vector<double> Nominals() {
    std::vector<double> focal;
    for (const ZoomPosition& p : kPositions) focal.push_back(p.nominal_mm);
    return focal;
}

inline Prescription Zoom() {
    std::vector<double> distance, sensor, stop;
    for (const ZoomPosition& p : kPositions) {
        distance.push_back(DistanceFor(p.nominal_mm * p.real_over_nominal));
        sensor.push_back(FiguresOf(TwoGroups(distance.back(), 60.0)).bfl_mm + p.defocus_mm);
        stop.push_back(p.stop_mm);
    }
    Prescription lens = TwoGroups(distance.front(), sensor.front());
    lens.surfaces[2].semi_diameter_mm = stop.front();
    lens.states.focal_mm = Nominals();
    lens.states.f_number = {3.6, 5.0, 6.0, 7.2};
    lens.states.gaps = {{1, distance, "#d"}, {4, sensor, "#s"}};
    lens.states.semi_diameters = {{2, stop, "#r"}};
    return lens;
}

// The second group moves to focus; the sensor stays.
inline Prescription InnerFocusing() {
    Prescription lens = TwoGroups(30.0, 0.0);
    lens.surfaces.back().gap_given = false;
    lens.surfaces.back().gap_mm = 0.0;
    lens.states.focus_m = {std::numeric_limits<double>::infinity(), 3.0, 1.2};
    lens.states.gaps = {{1, {30.0, 28.0, 25.0}, "#d"}};
    return lens;
}

}  // namespace flare::testing
