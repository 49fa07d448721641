// SPDX-License-Identifier: Apache-2.0
//
// The rays of a drawing: exact rays in one section of a lens, found by search, as polylines of (z,
// height) in mm of lens space. The light is at infinity; at a positive field angle it stands above
// the axis (towards +x or +y). Pure functions, some thousand traced rays each.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/optics/iris.h"
#include "core/tracing/bounce_sequence.h"

namespace flare {

struct DrawnRay {
    std::vector<Vec2d> points;       // where it starts, each surface it meets, the sensor
    std::vector<std::size_t> turns;  // which of the points are reflections
    bool passes = true;              // all rims and the iris
};

// What to look at, and from how far in front of the lens rays are drawn.
struct BeamView {
    const Lens& lens;
    Section section;
    const Iris& iris;
    double lead_mm;
};

// The beam of the direct path: its two outermost rays (absent where no light passes) and the chief
// ray (absent where there is none), which rims may stop.
struct DirectBeam {
    std::optional<DrawnRay> upper, lower, chief;
};
DirectBeam TraceDirectBeam(const BeamView& view, double field_rad, double wavelength_nm);

// Rays of a ghost, spread over what passes rims and iris, in order of height; empty where no ray in
// the section does. Requires a sound sequence (CheckSequence).
std::vector<DrawnRay> TraceGhostFan(const BeamView& view, const BounceSequence& sequence,
                                    double field_rad, double wavelength_nm);

}  // namespace flare
