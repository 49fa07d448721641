// SPDX-License-Identifier: Apache-2.0
//
// First-order optics for tests only, in long double, straight from the numbers of a prescription:
// the y-nu trace of Smith (Modern Optical Engineering, ch. 2), which shares no matrix with the
// core.
#pragma once

#include <cmath>
#include <cstddef>

#include "core/optics/prescription.h"
#include "core/optics/prescription_faults.h"

namespace flare::testing {

struct TableRay {
    long double height = 0, slope = 0;
};

inline long double TableCurvature(const SurfacePrescription& surface, Section section) {
    const auto of = [](double radius) { return radius == 0.0 ? 0.0L : 1.0L / radius; };
    switch (surface.kind) {
        case SurfaceKind::kCylinderX:
            return section == Section::kX ? of(surface.radius_mm) : 0.0L;
        case SurfaceKind::kCylinderY:
            return section == Section::kY ? of(surface.radius_mm) : 0.0L;
        case SurfaceKind::kToroid:
            return of(section == Section::kX ? surface.radius_x_mm : surface.radius_y_mm);
        default:
            return of(surface.radius_mm);
    }
}

// From the tangent plane at vertex 0 to that behind the last vertex, at the d line.
inline TableRay ThroughTable(const Prescription& lens, TableRay ray, Section section) {
    long double index = 1;
    const std::size_t count = lens.optical_count();
    for (std::size_t i = 0; i < count; ++i) {
        const SurfacePrescription& surface = lens.surfaces[i];
        const long double behind = MediumOf(surface).value().nd();
        ray.slope =
            (index * ray.slope - ray.height * (behind - index) * TableCurvature(surface, section)) /
            behind;
        index = behind;
        if (i + 1 < count) ray.height += surface.gap_mm * ray.slope;
    }
    return ray;
}

struct TableFigures {
    double efl_mm = 0.0, bfl_mm = 0.0, f_number = 0.0;
};

inline TableFigures FiguresOf(const Prescription& lens, Section section = Section::kY) {
    const TableRay out = ThroughTable(lens, {1, 0}, section);
    // The height at the stop of the same ray.
    Prescription front = lens;
    std::size_t stop = 0;
    while (lens.surfaces[stop].kind != SurfaceKind::kStop) ++stop;
    front.surfaces.resize(stop + 1);
    const long double a1 = ThroughTable(front, {1, 0}, section).height;
    const long double efl = -1 / out.slope;
    return {static_cast<double>(efl), static_cast<double>(-out.height / out.slope),
            static_cast<double>(std::fabs(efl * a1) / (2 * lens.surfaces[stop].semi_diameter_mm))};
}

inline double TableLength(const Prescription& lens) {
    double length = 0.0;
    for (std::size_t i = 0; i + 1 < lens.optical_count(); ++i) length += lens.surfaces[i].gap_mm;
    return length;
}

// How far behind the last vertex an object on the axis, this far in front of a sensor that stands
// `sensor_gap_mm` behind the last vertex, is imaged.
inline double ImageOfObject(const Prescription& lens, double sensor_gap_mm, double focus_mm,
                            Section section = Section::kY) {
    const long double object =
        static_cast<long double>(focus_mm) - TableLength(lens) - sensor_gap_mm;
    const TableRay out = ThroughTable(lens, {1, 1 / object}, section);
    return static_cast<double>(-out.height / out.slope);
}

}  // namespace flare::testing
