// SPDX-License-Identifier: Apache-2.0
//
// Lenses that nobody designed and that can be built all the same: two to six surfaces around a
// stop, radii from strong to flat, air, glass and cemented faces, rims well within the spheres and
// gaps wide enough that no surface crosses the next. `Source` gives the numbers: Uniform(lo, hi)
// and Below(n), be it a seeded generator (random.h) or the bytes of a fuzzer.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/optics/lens.h"
#include "tests/support/seed_lens.h"

namespace flare::testing {

struct RandomLensKind {
    int most_surfaces = 6;   // without the stop
    bool any_shape = false;  // aspheres, cylinders and toroids too
    bool dispersion = false;
    bool coatings = false;
};

namespace random_lens {

// How far a sphere's rim stands from its vertex along the axis.
inline double Sag(double radius_mm, double height_mm) {
    if (radius_mm == 0.0) return 0.0;
    const double c = 1.0 / radius_mm, h2 = height_mm * height_mm;
    return c * h2 / (1.0 + std::sqrt(1.0 - c * c * h2));
}

template <class Source>
void Reshape(Source& random, SurfacePrescription& surface) {
    const double height = surface.semi_diameter_mm;
    switch (random.Below(6)) {
        case 0:
            surface.kind = SurfaceKind::kAsphere;
            surface.conic = random.Uniform(-1.5, 0.3);
            surface.asphere = {random.Uniform(-0.05, 0.05) / (height * height * height)};
            break;
        case 1:
            surface.kind = SurfaceKind::kCylinderX;
            break;
        case 2:
            surface.kind = SurfaceKind::kCylinderY;
            break;
        case 3:
            surface.kind = SurfaceKind::kToroid;
            surface.radius_x_mm = surface.radius_mm;
            surface.radius_y_mm = surface.radius_mm * random.Uniform(1.0, 2.0);
            surface.radius_mm = 0.0;
            break;
        default:
            break;
    }
}

}  // namespace random_lens

// The sensor stands at the paraxial focus where that is 5 to 300 mm behind the last surface, else
// somewhere behind it.
template <class Source>
Prescription RandomPrescription(Source& random, const RandomLensKind& kind = {}) {
    const int count = 2 + random.Below(std::max(1, kind.most_surfaces - 1));
    const int stop_at = random.Below(count + 1);
    std::vector<SurfacePrescription> surfaces;
    bool in_glass = false;
    for (int i = 0; i < count; ++i) {
        const bool last = i + 1 == count;
        if (i == stop_at) surfaces.push_back(Stop(random.Uniform(0.5, 3.0), 1.0));
        const double size = std::exp(random.Uniform(std::log(18.0), std::log(400.0)));
        const double radius = random.Below(8) == 0 ? 0.0 : (random.Below(2) == 0 ? size : -size);
        const double height = radius == 0.0 ? random.Uniform(5.0, 12.0)
                                            : std::min(0.55 * size, random.Uniform(5.0, 12.0));
        // Behind glass either air or, cemented, another glass.
        in_glass = !last && (!in_glass || random.Below(3) == 0);
        const double nd = in_glass ? random.Uniform(1.4, 1.95) : 1.0;
        surfaces.push_back(Sphere(radius, 0.0, nd, 0.0, height));
        if (in_glass && kind.dispersion) surfaces.back().vd = random.Uniform(20.0, 85.0);
    }
    if (stop_at == count) surfaces.push_back(Stop(0.5, 1.0));
    // The stop stands in whatever medium lies in front of it.
    const auto stop = std::find_if(surfaces.begin(), surfaces.end(),
                                   [](const auto& s) { return s.kind == SurfaceKind::kStop; });
    if (stop != surfaces.begin()) {
        stop->nd = (stop - 1)->nd;
        stop->vd = (stop - 1)->vd;
    }
    stop->semi_diameter_mm = random.Uniform(1.5, 5.0);
    for (std::size_t i = 0; i + 1 < surfaces.size(); ++i) {
        const SurfacePrescription& a = surfaces[i];
        const SurfacePrescription& b = surfaces[i + 1];
        const double height = std::min(a.semi_diameter_mm, b.semi_diameter_mm);
        const double closed =
            random_lens::Sag(a.radius_mm, height) - random_lens::Sag(b.radius_mm, height);
        surfaces[i].gap_mm = std::max(0.0, closed) + random.Uniform(0.3, 5.0);
    }
    if (kind.any_shape) {
        for (SurfacePrescription& surface : surfaces) {
            if (surface.kind == SurfaceKind::kSphere) random_lens::Reshape(random, surface);
        }
    }
    Prescription lens = Assemble("random", std::move(surfaces));
    if (kind.coatings) lens.default_coating = random.Below(2) == 0 ? "mgf2-550" : "broadband-550";
    const double somewhere = random.Uniform(15.0, 60.0);
    const auto built = Lens::Build(lens);
    const double bfl = built ? (*built)->first_order().bfl_mm : 0.0;
    if (!(bfl >= 5.0 && bfl <= 300.0)) {
        lens.surfaces.back().gap_mm = somewhere;
        lens.surfaces.back().gap_given = true;
    }
    return lens;
}

}  // namespace flare::testing
