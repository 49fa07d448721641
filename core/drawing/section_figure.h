// SPDX-License-Identifier: Apache-2.0
//
// What is to be seen of a lens in one section, before it becomes text: shapes and rays as (z,
// height) in mm of lens space.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/drawing/beam_rays.h"
#include "core/drawing/section_outline.h"
#include "core/optics/paraxial.h"

namespace flare {

// Light of the drawing, the same in both sections.
struct FigureLight {
    double wavelength_nm = kLineD;
    StopSetting stop;
    std::optional<double> field_rad;  // of the field beam; absent or 0: none
    double ghost_field_rad = 0.0;
    std::vector<BounceSequence> ghosts;
};

struct FigureBox {
    double z0 = 0.0, z1 = 0.0, low = 0.0, high = 0.0;

    void Add(Vec2d p);
};

struct FigurePupil {
    std::string name;
    double z_mm = 0.0;  // may be infinite
    double semi_diameter_mm = 0.0;
    bool within_reach = true;  // near and small enough to be drawn where it is
};

struct FigureStop {
    int surface = 0;
    double z_mm = 0.0, opening_mm = 0.0, outer_mm = 0.0;  // a bar from opening to outer
};

struct FigureSensor {
    double z_mm = 0.0, semi_height_mm = 0.0;
    bool reflects = false;
};

struct FigureGhost {
    BounceSequence sequence;
    std::vector<DrawnRay> fan;
};

struct SectionFigure {
    Section section = Section::kY;
    std::vector<ElementOutline> elements;
    std::vector<Outline> faces;  // of every surface, the stop's as well
    std::vector<int> loose;      // surfaces with air on both sides that are no stop
    FigureStop stop;
    FigureSensor sensor;
    std::vector<FigurePupil> pupils;
    DirectBeam axial, field;
    std::vector<FigureGhost> ghosts;
    FigureBox box;  // around everything that is drawn to scale
};

SectionFigure FigureOf(const Lens& lens, Section section, const FigureLight& light);

}  // namespace flare
