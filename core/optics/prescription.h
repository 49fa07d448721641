// SPDX-License-Identifier: Apache-2.0
//
// A lens prescription: what a lens file says, as plain values. Lengths are mm, surfaces are
// numbered from the front from 0. Nothing here is checked or derived; Lens (lens.h) is the checked,
// immutable form that the rest of the program works with.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/optics/coating_design.h"
#include "core/optics/glass.h"

namespace flare {

enum class SurfaceKind { kSphere, kPlane, kStop };

struct SurfacePrescription {
    SurfaceKind kind = SurfaceKind::kSphere;
    double radius_mm = 0.0;  // > 0: centre of curvature towards +z; 0: plane
    double gap_mm = 0.0;     // to the next surface; of the last one: to the sensor
    bool gap_given =
        false;  // the last surface may leave it out: the sensor is at the paraxial focus
    std::optional<double> nd;  // medium behind the surface; absent: air
    std::optional<double> vd;  // absent: no dispersion
    double semi_diameter_mm = 0.0;
    std::optional<std::string> coating;  // absent: the lens's default
    std::string where;                   // place in the file, for messages

    friend bool operator==(const SurfacePrescription&, const SurfacePrescription&) = default;
};

struct Prescription {
    std::string name;
    std::string maker, patent, source, notes;
    std::optional<double> design_focal_mm, design_f_number, design_image_circle_mm;
    std::string default_coating = "bare";
    CoatingDefinitions coatings;  // the lens's own, found before the built-in ones
    bool fisheye = false;  // `pixel` means where the chief ray lands (interface: projection "lens")
    std::vector<SurfacePrescription> surfaces;

    friend bool operator==(const Prescription&, const Prescription&) = default;
};

}  // namespace flare
