// SPDX-License-Identifier: Apache-2.0
//
// What a lens does from the axis to the edge of its picture: where the chief ray lands and how far
// that is from the ideal place (distortion), how much light of a uniform scene arrives there
// (relative illumination), and what of it surfaces and glass let through. Rows are evenly spaced in
// field angle, 0 to the edge; an anamorphic lens has one table a section. Geometry and fluxes are
// those of the d line. docs/physics/field-data.md has the formulas.
//
// Pure; nothing here fails, what has no value at an angle is absent there. About 15 000 rays a row:
// 11 rows take 0.2 to 0.7 s with 11 to 34 surfaces.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "core/optics/lens.h"

namespace flare {

struct FieldOptions {
    int rows = 11;                        // 2 or more
    std::optional<double> f_number = {};  // absent: wide open
    // Distance of the scene from the sensor; absent: infinity. The scene is a plane across the
    // axis, that of a fisheye a sphere about the entrance pupil. Tables have no rows where it would
    // not stand in front of the entrance pupil.
    std::optional<double> focus_m = {};
    std::vector<double> wavelengths_nm{400.0, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0};
};

// What ends the table.
enum class FieldEdge {
    kImageCircle,  // the chief ray reaches the image circle of the design
    kNoChiefRay,   // no ray passes the stop's centre any more
    kNoLight       // without a stated image circle: rims let nothing through
};

// "image_circle", "no_chief_ray", "no_light"
std::string_view Name(FieldEdge edge);

struct FieldRow {
    double field_rad = 0.0;
    // Distance of the chief ray from the axis, positive on the side where the paraxial one lands.
    std::optional<double> image_height_mm;
    // d' tan(field) with d' the projection distance of first_order(), the EFL of a lens focused at
    // infinity; up to 85 degrees.
    std::optional<double> ideal_height_mm;
    // (image - ideal) / ideal; on the axis its limit. Against d' field for a fisheye only.
    std::optional<double> distortion;
    std::optional<double> f_theta_distortion;
    // Where the chief ray lands, from a scene of radiance 1 everywhere, and relative to the axis.
    std::optional<double> irradiance;
    std::optional<double> relative_illumination;
    // Cross-section of the beam that passes, measured across it, and its share of that on the axis.
    double beam_area_mm2 = 0.0;
    double beam_share = 0.0;
    double flux_mm2 = 0.0;  // on the sensor for E0 = 1
    // Mean over the beam at the d line, and at the options' wavelengths over theirs. Absent and
    // empty where no light passes.
    std::optional<double> transmittance;
    std::vector<double> transmittances;
};

struct FieldTable {
    Section section = Section::kY;
    FieldEdge edge = FieldEdge::kImageCircle;
    std::vector<FieldRow> rows;
};

struct FieldData {
    double f_number = 0.0;  // as the iris was set
    std::vector<double> wavelengths_nm;
    std::vector<FieldTable> tables;  // one; section x, then y of an anamorphic lens
};

FieldData FieldDataOf(const Lens& lens, const FieldOptions& options = {});

}  // namespace flare
