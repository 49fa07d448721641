// SPDX-License-Identifier: Apache-2.0
//
// The double Gauss of US 2,673,491 scaled to 50 mm, as numbers in code: the lens whose figures many
// tests know, for tests that must not depend on the file reader.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/optics/prescription.h"

namespace flare::testing {

inline SurfacePrescription Sphere(double radius_mm, double gap_mm, double nd, double vd,
                                  double semi_diameter_mm) {
    SurfacePrescription surface;
    surface.kind = radius_mm == 0.0 ? SurfaceKind::kPlane : SurfaceKind::kSphere;
    surface.radius_mm = radius_mm;
    surface.gap_mm = gap_mm;
    surface.gap_given = true;
    if (nd != 1.0) surface.nd = nd;
    if (vd != 0.0) surface.vd = vd;
    surface.semi_diameter_mm = semi_diameter_mm;
    return surface;
}

inline SurfacePrescription Stop(double gap_mm, double semi_diameter_mm) {
    SurfacePrescription surface;
    surface.kind = SurfaceKind::kStop;
    surface.gap_mm = gap_mm;
    surface.gap_given = true;
    surface.semi_diameter_mm = semi_diameter_mm;
    return surface;
}

// Names each surface's place "#0", "#1", ... and lets the last one's gap be the paraxial focus.
inline Prescription Assemble(std::string name, std::vector<SurfacePrescription> surfaces) {
    Prescription lens;
    lens.name = std::move(name);
    lens.surfaces = std::move(surfaces);
    for (std::size_t i = 0; i < lens.surfaces.size(); ++i) {
        lens.surfaces[i].where = std::string("#").append(std::to_string(i));
    }
    if (!lens.surfaces.empty()) {
        lens.surfaces.back().gap_mm = 0.0;
        lens.surfaces.back().gap_given = false;
    }
    return lens;
}

inline Prescription SeedLens() {
    Prescription lens = Assemble("seed", {
                                             Sphere(29.475, 3.76, 1.67, 47.1, 12.6),
                                             Sphere(84.83, 0.12, 1.0, 0.0, 12.6),
                                             Sphere(19.275, 4.025, 1.67, 47.1, 11.5),
                                             Sphere(40.77, 3.275, 1.699, 30.1, 11.5),
                                             Sphere(12.75, 5.705, 1.0, 0.0, 9.0),
                                             Stop(4.5, 8.55),
                                             Sphere(-14.495, 1.18, 1.603, 38.4, 8.5),
                                             Sphere(40.77, 6.065, 1.658, 57.0, 10.0),
                                             Sphere(-20.385, 0.19, 1.0, 0.0, 10.0),
                                             Sphere(437.065, 3.22, 1.717, 48.1, 10.0),
                                             Sphere(-39.73, 0.0, 1.0, 0.0, 10.0),
                                         });
    lens.default_coating = "mgf2-550";
    return lens;
}

// A plano-convex lens (R 50, n 1.5, no dispersion: focal length 100 mm exactly) behind a stop.
inline Prescription PlanoConvex() {
    return Assemble("plano-convex", {
                                        Stop(2.0, 5.0),
                                        Sphere(50.0, 6.0, 1.5, 0.0, 10.0),
                                        Sphere(0.0, 0.0, 1.0, 0.0, 10.0),
                                    });
}

}  // namespace flare::testing
