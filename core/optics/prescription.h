// SPDX-License-Identifier: Apache-2.0
//
// A lens prescription: what a lens file says, as plain values. Lengths are mm, surfaces are
// numbered from the front from 0. Nothing here is checked or derived; Lens (lens.h) is the checked,
// immutable form that the rest of the program works with.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/optics/coating_design.h"
#include "core/optics/glass.h"
#include "core/optics/surface_shape.h"

namespace flare {

enum class SurfaceKind {
    kSphere,
    kPlane,
    kAsphere,
    kCylinderX,  // curved in x
    kCylinderY,
    kToroid,
    kStop,
    kSensor,  // a reflecting sensor, only as the last surface
};

// "sphere", "cylinder_x", ...: the words of a lens file.
std::string_view KindName(SurfaceKind kind);

struct SurfacePrescription {
    SurfaceKind kind = SurfaceKind::kSphere;
    double radius_mm = 0.0;                       // > 0: centre of curvature towards +z; 0: plane
    double radius_x_mm = 0.0, radius_y_mm = 0.0;  // of a toroid, 0: flat in that section
    double conic = 0.0;                           // of an asphere
    std::vector<double> asphere;                  // a4, a6, ... in mm^-3, mm^-5, ...
    double gap_mm = 0.0;  // to the next surface; of the last one: to the sensor
    bool gap_given =
        false;  // the last surface may leave it out: the sensor is at the paraxial focus
    std::optional<std::string> glass;  // medium behind the surface, by name (glass_catalogue.h)
    std::optional<double> nd;          // or by its index; neither: air
    std::optional<double> vd;          // absent: no dispersion
    double semi_diameter_mm = 0.0;
    std::optional<std::string> coating;  // absent: the lens's default
    double reflectance = 0.0;            // of a sensor, at any angle and wavelength
    std::string where;                   // place in the file, for messages

    friend bool operator==(const SurfacePrescription&, const SurfacePrescription&) = default;
};

// The shape that a surface's numbers mean. Requires at most kMostCoefficients coefficients.
SurfaceShape ShapeOf(const SurfacePrescription& surface);

// What changes when the lens is zoomed or focused: numbers against nominal focal length and focus
// distance. An empty axis has one position.
struct StateTable {
    // One surface's gap or semi-diameter over the positions: [zoom * focus positions + focus].
    struct Row {
        int surface = 0;
        std::vector<double> values;
        std::string where;

        friend bool operator==(const Row&, const Row&) = default;
    };

    std::vector<double> focal_mm;  // nominal, rising; the first is the lens's default
    std::vector<double> focus_m;   // from the sensor, falling, the first infinite; empty: unit
                                   // focusing
    std::vector<double> f_number;  // by design at each zoom position; may be empty
    std::vector<Row> gaps;
    std::vector<Row> semi_diameters;
    std::string where;

    bool empty() const { return focal_mm.empty() && focus_m.empty(); }
    std::size_t zoom_positions() const { return focal_mm.empty() ? 1 : focal_mm.size(); }
    std::size_t focus_positions() const { return focus_m.empty() ? 1 : focus_m.size(); }

    friend bool operator==(const StateTable&, const StateTable&) = default;
};

struct Prescription {
    std::string name;
    std::string maker, patent, source, notes;
    std::optional<double> design_focal_mm, design_f_number, design_image_circle_mm;
    // How far the table's own figures may lie from the design, relative; absent: the lint's own.
    std::optional<double> focal_tolerance, f_number_tolerance;
    Section design_section = Section::kY;  // that design_focal_mm speaks of
    std::optional<int> year;
    std::string default_coating = "bare";
    CoatingDefinitions coatings;  // the lens's own, found before the built-in ones
    bool fisheye = false;  // `pixel` means where the chief ray lands (interface: projection "lens")
    std::vector<SurfacePrescription> surfaces;
    StateTable states;
    // How far the sensor stands behind its place at infinity, by unit focusing.
    double focus_shift_mm = 0.0;

    // Surfaces without a reflecting sensor at the end.
    std::size_t optical_count() const {
        const bool sensor = !surfaces.empty() && surfaces.back().kind == SurfaceKind::kSensor;
        return surfaces.size() - (sensor ? 1 : 0);
    }

    friend bool operator==(const Prescription&, const Prescription&) = default;
};

}  // namespace flare
