// SPDX-License-Identifier: Apache-2.0
//
// Small lenses in which one thing is at its limit: a ghost in focus on the sensor, a ghost that
// images infinity or the sensor into the stop, plates, shells, contact, sixty surfaces.
#pragma once

#include <functional>

#include "core/tracing/paraxial_ghost.h"
#include "tests/support/lenses.h"
#include "tests/support/seed_lens.h"

namespace flare::testing {

// Two singlets with a stop between them, 47 mm; six ghosts. The sensor's distance is given.
inline Prescription Singlets(double before_stop_mm = 4.0, double sensor_mm = 36.0) {
    constexpr double kApart = 30.0;
    Prescription lens =
        Assemble("singlets",
                 {Sphere(60.0, 5.0, 1.6, 0.0, 10.0), Sphere(300.0, before_stop_mm, 1.0, 0.0, 10.0),
                  Stop(kApart - before_stop_mm, 5.0), Sphere(70.0, 4.0, 1.7, 0.0, 10.0),
                  Sphere(-90.0, 0.0, 1.0, 0.0, 10.0)});
    lens.surfaces.back().gap_mm = sensor_mm;
    lens.surfaces.back().gap_given = true;
    return lens;
}

// A stop and one singlet, 49 mm: one ghost. For what does not depend on the lens.
inline Prescription Singlet() {
    Prescription lens = Assemble("singlet", {Stop(2.0, 6.0), Sphere(45.0, 5.0, 1.6, 0.0, 12.0),
                                             Sphere(-80.0, 0.0, 1.0, 0.0, 12.0)});
    lens.surfaces.back().gap_mm = 46.0;
    lens.surfaces.back().gap_given = true;
    return lens;
}

// Where a first-order quantity of a ghost, linear in one length of the lens, is 0.
inline double RootOf(const std::function<Prescription(double)>& lens_at,
                     const BounceSequence& sequence,
                     const std::function<double(const ParaxialPath&)>& quantity) {
    const auto at = [&](double length) {
        const auto lens = BuildLens(lens_at(length));
        return quantity(ParaxialPathOf(WriteOut(*lens, sequence, kLineD)));
    };
    const double one = at(1.0), two = at(2.0);
    return 1.0 - one / (two - one);
}

inline const BounceSequence kFrontGhost{1, 0}, kRearGhost{4, 3};

// A = 0: by first-order optics all light of the ghost falls on one point of the sensor.
inline Prescription GhostInFocus() {
    const auto lens_at = [](double sensor_mm) { return Singlets(4.0, sensor_mm); };
    return lens_at(RootOf(lens_at, kRearGhost,
                          [](const ParaxialPath& path) { return path.front_to_sensor.a; }));
}

// A1 = 0: the ghost's light is in focus in the stop.
inline Prescription GhostFocusedInTheStop() {
    const auto lens_at = [](double before_stop_mm) { return Singlets(before_stop_mm); };
    return lens_at(RootOf(lens_at, kFrontGhost,
                          [](const ParaxialPath& path) { return path.front_to_stop.at(0).a; }));
}

// B2 = 0: the sensor holds the stop's image.
inline Prescription GhostOfTheStopsImage() {
    const auto lens_at = [](double sensor_mm) { return Singlets(4.0, sensor_mm); };
    return lens_at(RootOf(lens_at, kRearGhost,
                          [](const ParaxialPath& path) { return path.stop_to_sensor.at(0).b; }));
}

// The singlet behind a plate of two faces with these radii.
inline Prescription BehindAPlate(double front_radius_mm, double back_radius_mm,
                                 double gap_mm = 1.0) {
    Prescription lens = Singlet();
    std::vector<SurfacePrescription> surfaces = {Sphere(front_radius_mm, 2.0, 1.5, 0.0, 11.0),
                                                 Sphere(back_radius_mm, gap_mm, 1.0, 0.0, 11.0)};
    surfaces.insert(surfaces.end(), lens.surfaces.begin(), lens.surfaces.end());
    lens.surfaces = std::move(surfaces);
    for (std::size_t i = 0; i < lens.surfaces.size(); ++i) {
        lens.surfaces[i].where = "#" + std::to_string(i);
    }
    return lens;
}

// The singlet of two glasses, cemented at a face of radius 80.
inline Prescription CementedSinglet(double nd, double nd_behind) {
    Prescription lens = Singlet();
    lens.surfaces[1].nd = nd;
    lens.surfaces[1].gap_mm = 2.5;
    SurfacePrescription inner = Sphere(80.0, 2.5, nd_behind, 0.0, 12.0);
    inner.where = "#inner";
    lens.surfaces.insert(lens.surfaces.begin() + 2, inner);
    return lens;
}

// Sixty refracting surfaces: thirty thin plates, slightly bent, with a stop among them and a lens
// behind.
inline Prescription SixtySurfaces() {
    std::vector<SurfacePrescription> surfaces;
    for (int plate = 0; plate < 29; ++plate) {
        if (plate == 15) surfaces.push_back(Stop(0.5, 6.0));
        const double bend = plate % 2 == 0 ? 2'000.0 : -2'000.0;
        surfaces.push_back(Sphere(bend, 0.5, 1.5, 0.0, 12.0));
        surfaces.push_back(Sphere(bend, 0.5, 1.0, 0.0, 12.0));
    }
    surfaces.push_back(Sphere(50.0, 6.0, 1.6, 0.0, 12.0));
    surfaces.push_back(Sphere(-300.0, 0.0, 1.0, 0.0, 12.0));
    return Assemble("sixty", std::move(surfaces));
}

}  // namespace flare::testing
