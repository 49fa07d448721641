// SPDX-License-Identifier: Apache-2.0
//
// Lenses without rotational symmetry whose figures follow from those of a rotational one.
#pragma once

#include <string>
#include <vector>

#include "tests/support/seed_lens.h"

namespace flare::testing {

// `lens` behind two cylinders of -50 and +100 mm that are curved in x and form an afocal pair: the
// x section has half the focal length, the y section sees plane plates. Their plane sides face
// outwards, so that the principal planes are the curved vertices and the pair is afocal at the d
// line exactly where these are 50 mm apart.
inline Prescription BehindAfocalPair(Prescription lens, double gap_mm = 1.0,
                                     double semi_diameter_mm = 16.0) {
    const auto cylinder = [&](double radius, double gap, double nd, double vd) {
        SurfacePrescription surface = Sphere(radius, gap, nd, vd, semi_diameter_mm);
        surface.kind = SurfaceKind::kCylinderX;
        return surface;
    };
    lens.name = "anamorphic-" + lens.name;
    const std::vector<SurfacePrescription> pair{
        Sphere(0.0, 2.0, 1.5, 60.0, semi_diameter_mm), cylinder(25.0, 50.0, 1.0, 0.0),
        cylinder(50.0, 5.0, 1.5, 60.0), Sphere(0.0, gap_mm, 1.0, 0.0, semi_diameter_mm)};
    lens.surfaces.insert(lens.surfaces.begin(), pair.begin(), pair.end());
    for (std::size_t i = 0; i < lens.surfaces.size(); ++i) {
        lens.surfaces[i].where = std::string("#").append(std::to_string(i));
    }
    return lens;
}

// The same lens to a billionth, without its rotational symmetry: surface `index` becomes a toroid.
inline Prescription AllButRotational(Prescription lens, std::size_t index) {
    SurfacePrescription& surface = lens.surfaces[index];
    surface.kind = SurfaceKind::kToroid;
    surface.radius_y_mm = surface.radius_mm;
    surface.radius_x_mm = surface.radius_mm * (1.0 + 1e-9);
    surface.radius_mm = 0.0;
    return lens;
}

}  // namespace flare::testing
