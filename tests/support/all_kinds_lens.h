// SPDX-License-Identifier: Apache-2.0
//
// A lens that nobody would build: it has every kind of surface in it, glass by name and by index,
// and a reflecting sensor.
#pragma once

#include <utility>
#include <vector>

#include "tests/support/seed_lens.h"

namespace flare::testing {

inline SurfacePrescription Kind(SurfaceKind kind, double radius_mm, double gap_mm, double nd,
                                double vd, double semi_diameter_mm) {
    SurfacePrescription surface = Sphere(radius_mm, gap_mm, nd, vd, semi_diameter_mm);
    surface.kind = kind;
    return surface;
}

inline SurfacePrescription Asphere(SurfacePrescription sphere, double conic,
                                   std::vector<double> even) {
    sphere.kind = SurfaceKind::kAsphere;
    sphere.conic = conic;
    sphere.asphere = std::move(even);
    return sphere;
}

inline SurfacePrescription Toroid(SurfacePrescription surface, double radius_x_mm,
                                  double radius_y_mm) {
    surface.kind = SurfaceKind::kToroid;
    surface.radius_mm = 0.0;
    surface.radius_x_mm = radius_x_mm;
    surface.radius_y_mm = radius_y_mm;
    return surface;
}

inline SurfacePrescription Mirror(double reflectance, double semi_diameter_mm) {
    SurfacePrescription sensor;
    sensor.kind = SurfaceKind::kSensor;
    sensor.reflectance = reflectance;
    sensor.semi_diameter_mm = semi_diameter_mm;
    return sensor;
}

inline SurfacePrescription OfGlass(SurfacePrescription surface, const char* glass) {
    surface.nd.reset();
    surface.vd.reset();
    surface.glass = glass;
    return surface;
}

// Focal lengths of 62 and 58 mm in x and y; f/3.
inline Prescription AllKindsLens() {
    Prescription lens =
        Assemble("all-kinds",
                 {
                     Asphere(OfGlass(Sphere(40.0, 6.0, 1.0, 0.0, 14.0), "SCHOTT N-BK7"), -0.5,
                             {-1e-6, 2e-9, -3e-12}),
                     Sphere(130.0, 0.5, 1.0, 0.0, 13.0),
                     Kind(SurfaceKind::kCylinderX, 90.0, 4.0, 1.62, 36.0, 12.0),
                     Kind(SurfaceKind::kCylinderY, 300.0, 5.0, 1.0, 0.0, 11.0),
                     Stop(6.0, 8.0),
                     Toroid(Sphere(0.0, 5.0, 1.7, 50.0, 10.0), -70.0, -55.0),
                     Asphere(Sphere(-35.0, 1.0, 1.0, 0.0, 11.0), 0.4, {}),
                     Toroid(OfGlass(Sphere(0.0, 3.0, 1.0, 0.0, 12.0), "SCHOTT SF6"), 200.0, -250.0),
                     Asphere(Sphere(0.0, 1.0, 1.0, 0.0, 12.0), 0.0, {4e-6}),
                     Sphere(0.0, 1.5, 1.52, 64.0, 14.0),
                     Sphere(0.0, 40.0, 1.0, 0.0, 14.0),
                     Mirror(0.15, 20.0),
                 });
    lens.surfaces.back().where = "#11";
    lens.surfaces[10].gap_given = false;  // at the paraxial focus
    return lens;
}

}  // namespace flare::testing
