// SPDX-License-Identifier: Apache-2.0
//
// First-order (Gaussian) optics with 2x2 ray-transfer matrices on (height, slope). Slopes are
// geometric angles, not multiplied by the index, so a system from air to air has determinant 1 and
// an interface has determinant n_in / n_out.
//
// The 4x4 matrix of a lens whose cylinders stand along x and y falls apart into one 2x2 matrix for
// each section; functions take the section (the same answer for both in a rotational lens).
#pragma once

#include "core/optics/lens.h"

namespace flare {

struct Abcd {
    double a = 1.0, b = 0.0, c = 0.0, d = 1.0;

    double determinant() const { return a * d - b * c; }
};

// first, then second: the product second * first.
Abcd Then(const Abcd& first, const Abcd& second);
Abcd Drift(double distance_mm);
// Refraction at a surface of `curvature` for light that travels towards +z.
Abcd Refraction(double curvature, double n_in, double n_out);

// From the tangent plane at vertex 0 to that of surface `last` (before refracting there).
Abcd FrontToSurface(const Lens& lens, int last, double wavelength_nm,
                    Section section = Section::kY);
// From vertex 0 through all surfaces to the tangent plane behind the last vertex.
Abcd FrontToBack(const Lens& lens, double wavelength_nm, Section section = Section::kY);
// From the stop (before the medium behind it) to the tangent plane behind the last vertex.
Abcd StopToBack(const Lens& lens, double wavelength_nm, Section section = Section::kY);
// From vertex 0 to the sensor.
Abcd FrontToSensor(const Lens& lens, double wavelength_nm, Section section = Section::kY);

struct AxialBeam {
    double entrance_diameter_mm = 0.0;
    double working_f_number = 0.0;  // N_w = |z_sensor - z_exit pupil| / diameter at the exit pupil
};

// The axial beam from infinity that the stop (an opening of `stop_semi_diameter_mm`) and all rims
// let through, by first-order heights at the d line. The second is the geometric mean over both
// sections.
AxialBeam WorkingBeam(const Lens& lens, double stop_semi_diameter_mm, Section section);
AxialBeam WorkingBeam(const Lens& lens, double stop_semi_diameter_mm);

// The opening of the stop for an f-number: diameter A1 EFL / N (the geometric mean of both
// sections' A1 EFL), clamped to the stop's own.
struct StopSetting {
    double semi_diameter_mm = 0.0;
    double f_number = 0.0;  // after clamping
    bool clamped = false;
};
StopSetting StopForFNumber(const Lens& lens, double f_number);

// Axial transmittance of the direct path for unpolarised light, coatings and absorption included.
double AxialTransmittance(const Lens& lens, double wavelength_nm);

}  // namespace flare
