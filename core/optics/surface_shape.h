// SPDX-License-Identifier: Apache-2.0
//
// The shape of one optical surface: its sag z(x, y), the height above the tangent plane at its
// vertex, in mm, with z towards the sensor. Plane, sphere, even asphere on a conic, cylinder curved
// in x or in y, and toroid. Cylinders and toroids have their axes along x and y, so that each of
// these two sections is an optical system of its own.
//
//   asphere  z = c r^2 / (1 + sqrt(1 - (1 + k) c^2 r^2)) + a4 r^4 + a6 r^6 + ...   (ISO 10110-12)
//   toroid   z = (cx x^2 + cy y^2) / (1 + sqrt(1 - cx^2 x^2 - cy^2 y^2))
//
// Values; nothing here fails. Where the formula has no value (beyond the equator) a sag is NaN.
#pragma once

#include <array>
#include <vector>

#include "core/base/vec.h"

namespace flare {

// The two planes of symmetry of a lens: x-z and y-z. A rotationally symmetric lens is the same in
// both.
enum class Section { kX, kY };

// How a ray is brought to the surface.
enum class SurfaceForm {
    kQuadric,    // sphere, plane and conic: closed form
    kCylinderX,  // curved in x: closed form
    kCylinderY,
    kAsphere,  // iterated from the conic
    kToroid,   // iterated from the sphere of mean curvature
};

class SurfaceShape {
  public:
    static constexpr std::size_t kMostCoefficients = 8;

    SurfaceShape() = default;  // a plane
    static SurfaceShape Sphere(double curvature);
    // `even` holds a4, a6, ... in mm^-3, mm^-5, ...; at most kMostCoefficients.
    static SurfaceShape Asphere(double curvature, double conic, const std::vector<double>& even);
    static SurfaceShape CylinderX(double curvature);
    static SurfaceShape CylinderY(double curvature);
    static SurfaceShape Toroid(double curvature_x, double curvature_y);

    SurfaceForm form() const { return form_; }
    // At the vertex, 1/mm; the second derivative of the sag.
    double curvature(Section section) const {
        return section == Section::kX ? curvature_x_ : curvature_y_;
    }
    double curvature_x() const { return curvature_x_; }
    double curvature_y() const { return curvature_y_; }
    double conic() const { return conic_; }
    const std::array<double, kMostCoefficients>& coefficients() const { return even_; }
    bool flat() const { return form_ == SurfaceForm::kQuadric && curvature_x_ == 0.0; }
    bool rotational() const {
        return form_ == SurfaceForm::kQuadric || form_ == SurfaceForm::kAsphere;
    }

    double Sag(double x, double y) const;
    // dz/dx and dz/dy.
    Vec2d Slope(double x, double y) const;
    // The sag has a value and a finite slope at every point within this distance of the axis;
    // infinite for a plane.
    double reach_mm() const;
    // Smallest and largest sag within `radius_mm` of the axis (clipped to the reach), by sampling
    // where the shape is not monotone; for bounds, add a margin.
    std::array<double, 2> SagRange(double radius_mm) const;

    friend bool operator==(const SurfaceShape&, const SurfaceShape&) = default;

  private:
    SurfaceForm form_ = SurfaceForm::kQuadric;
    double curvature_x_ = 0.0, curvature_y_ = 0.0;
    double conic_ = 0.0;
    std::array<double, kMostCoefficients> even_{};
};

}  // namespace flare
