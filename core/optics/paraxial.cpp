// SPDX-License-Identifier: Apache-2.0
//
// The matrices of Kogelnik & Li (1966) with geometric slopes. Everything is computed from the
// product of elementary matrices on each call: a hundred 2x2 products cost a microsecond, and
// nothing can be out of step with the lens. Ratios are taken last, so that a pupil at infinity
// gives no 0/0.
#include "core/optics/paraxial.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"

namespace flare {

Abcd Then(const Abcd& first, const Abcd& second) {
    return {second.a * first.a + second.b * first.c, second.a * first.b + second.b * first.d,
            second.c * first.a + second.d * first.c, second.c * first.b + second.d * first.d};
}

Abcd Drift(double distance_mm) {
    return {1.0, distance_mm, 0.0, 1.0};
}

Abcd Refraction(double curvature, double n_in, double n_out) {
    return {1.0, 0.0, -curvature * (n_out - n_in) / n_out, n_in / n_out};
}

namespace {

Abcd RefractionAt(const Lens& lens, int index, double wavelength_nm, Section section) {
    return Refraction(lens.surfaces()[static_cast<std::size_t>(index)].shape.curvature(section),
                      lens.MediumBefore(index).Index(wavelength_nm),
                      lens.MediumBehind(index).Index(wavelength_nm));
}

int LastIndex(const Lens& lens) {
    return static_cast<int>(lens.surfaces().size()) - 1;
}

}  // namespace

Abcd FrontToSurface(const Lens& lens, int last, double wavelength_nm, Section section) {
    const std::vector<LensSurface>& surfaces = lens.surfaces();
    FLARE_CHECK(last >= 0 && last <= LastIndex(lens));
    Abcd path;
    for (int i = 0; i < last; ++i) {
        const auto k = static_cast<std::size_t>(i);
        path = Then(path, RefractionAt(lens, i, wavelength_nm, section));
        path = Then(path, Drift(surfaces[k + 1].vertex_z_mm - surfaces[k].vertex_z_mm));
    }
    return path;
}

Abcd FrontToBack(const Lens& lens, double wavelength_nm, Section section) {
    const int last = LastIndex(lens);
    return Then(FrontToSurface(lens, last, wavelength_nm, section),
                RefractionAt(lens, last, wavelength_nm, section));
}

Abcd FrontToSensor(const Lens& lens, double wavelength_nm, Section section) {
    return Then(FrontToBack(lens, wavelength_nm, section),
                Drift(lens.sensor_z_mm() - lens.surfaces().back().vertex_z_mm));
}

Abcd StopToBack(const Lens& lens, double wavelength_nm, Section section) {
    const std::vector<LensSurface>& surfaces = lens.surfaces();
    Abcd path;
    for (int i = lens.stop_index(); i <= LastIndex(lens); ++i) {
        const auto k = static_cast<std::size_t>(i);
        path = Then(path, RefractionAt(lens, i, wavelength_nm, section));
        if (i < LastIndex(lens)) {
            path = Then(path, Drift(surfaces[k + 1].vertex_z_mm - surfaces[k].vertex_z_mm));
        }
    }
    return path;
}

AxialBeam WorkingBeam(const Lens& lens, double stop_semi_diameter_mm, Section section) {
    FLARE_CHECK(stop_semi_diameter_mm > 0.0);
    // A ray that enters parallel at height y meets surface k at height A_k y.
    double entrance_height = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= LastIndex(lens); ++i) {
        const double height = std::abs(FrontToSurface(lens, i, kLineD, section).a);
        double rim = lens.surfaces()[static_cast<std::size_t>(i)].semi_diameter_mm;
        if (i == lens.stop_index()) rim = std::min(rim, stop_semi_diameter_mm);
        if (height * entrance_height > rim) entrance_height = rim / height;
    }

    // With (a b; c d) from stop to back the exit pupil lies at -b/d behind the last vertex and is
    // det/d times as large as the opening at the stop; d cancels in N_w.
    const Abcd rear = StopToBack(lens, kLineD, section);
    const double sensor_distance = lens.sensor_z_mm() - lens.surfaces().back().vertex_z_mm;
    const double stop_height = std::abs(lens.first_order(section).stop_a1) * entrance_height;
    AxialBeam beam;
    beam.entrance_diameter_mm = 2.0 * entrance_height;
    beam.working_f_number = std::abs(sensor_distance * rear.d + rear.b) /
                            (2.0 * std::abs(rear.determinant()) * stop_height);
    return beam;
}

AxialBeam WorkingBeam(const Lens& lens, double stop_semi_diameter_mm) {
    const AxialBeam y = WorkingBeam(lens, stop_semi_diameter_mm, Section::kY);
    if (lens.rotational()) return y;
    const AxialBeam x = WorkingBeam(lens, stop_semi_diameter_mm, Section::kX);
    return {std::sqrt(x.entrance_diameter_mm * y.entrance_diameter_mm),
            std::sqrt(x.working_f_number * y.working_f_number)};
}

StopSetting StopForFNumber(const Lens& lens, double f_number) {
    FLARE_CHECK(f_number > 0.0);
    const FirstOrder& x = lens.first_order(Section::kX);
    const FirstOrder& y = lens.first_order(Section::kY);
    const double across =  // A1 EFL
        lens.rotational() ? y.stop_a1 * y.efl_mm
                          : std::sqrt(std::abs(x.stop_a1 * x.efl_mm * y.stop_a1 * y.efl_mm));
    const LensSurface& stop = lens.surfaces()[static_cast<std::size_t>(lens.stop_index())];
    // An afocal lens has no f-number that a stop could be set to.
    if (!std::isfinite(across) || !std::isfinite(f_number)) {
        return {stop.semi_diameter_mm, lens.f_number(), f_number < lens.f_number()};
    }
    const double semi_diameter = std::abs(across) / (2.0 * f_number);
    // A request for the lens's very own f-number is not one for less.
    const double rounding = 1e-12 * stop.semi_diameter_mm;
    if (semi_diameter > stop.semi_diameter_mm + rounding) {
        return {stop.semi_diameter_mm, lens.f_number(), true};
    }
    return {std::min(semi_diameter, stop.semi_diameter_mm), f_number, false};
}

double AxialTransmittance(const Lens& lens, double wavelength_nm) {
    double transmittance = 1.0;
    for (int i = 0; i <= LastIndex(lens); ++i) {
        const LensSurface& surface = lens.surfaces()[static_cast<std::size_t>(i)];
        if (!surface.is_stop()) {
            transmittance *=
                ReflectionOf(surface.coating, surface.dense_in_front,
                             lens.MediumBefore(i).Index(wavelength_nm),
                             lens.MediumBehind(i).Index(wavelength_nm), 1.0, wavelength_nm)
                    .transmittance;
        }
        if (i == LastIndex(lens)) break;
        const double length_mm =
            lens.surfaces()[static_cast<std::size_t>(i) + 1].vertex_z_mm - surface.vertex_z_mm;
        transmittance *= std::exp(-length_mm * lens.MediumBehind(i).AbsorptionPerMm(wavelength_nm));
    }
    return transmittance;
}

}  // namespace flare
