// SPDX-License-Identifier: Apache-2.0
#include "core/optics/surface_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"

namespace flare {

SurfaceShape SurfaceShape::Sphere(double curvature) {
    SurfaceShape shape;
    shape.curvature_x_ = shape.curvature_y_ = curvature;
    return shape;
}

SurfaceShape SurfaceShape::Asphere(double curvature, double conic,
                                   const std::vector<double>& even) {
    FLARE_CHECK(even.size() <= kMostCoefficients);
    SurfaceShape shape = Sphere(curvature);
    shape.conic_ = curvature == 0.0 ? 0.0 : conic;  // a plane has no conic
    std::copy(even.begin(), even.end(), shape.even_.begin());
    const bool pure = std::all_of(even.begin(), even.end(), [](double a) { return a == 0.0; });
    shape.form_ = pure ? SurfaceForm::kQuadric : SurfaceForm::kAsphere;
    return shape;
}

SurfaceShape SurfaceShape::CylinderX(double curvature) {
    SurfaceShape shape;
    if (curvature == 0.0) return shape;
    shape.form_ = SurfaceForm::kCylinderX;
    shape.curvature_x_ = curvature;
    return shape;
}

SurfaceShape SurfaceShape::CylinderY(double curvature) {
    SurfaceShape shape;
    if (curvature == 0.0) return shape;
    shape.form_ = SurfaceForm::kCylinderY;
    shape.curvature_y_ = curvature;
    return shape;
}

SurfaceShape SurfaceShape::Toroid(double curvature_x, double curvature_y) {
    if (curvature_x == curvature_y) return Sphere(curvature_x);
    SurfaceShape shape;
    shape.form_ = SurfaceForm::kToroid;
    shape.curvature_x_ = curvature_x;
    shape.curvature_y_ = curvature_y;
    return shape;
}

namespace {

// The polynomial a4 q^2 + a6 q^3 + ... in q = r^2, and its derivative by q.
struct Polynomial {
    double value = 0.0, derivative = 0.0;
};

Polynomial EvenTerms(const std::array<double, SurfaceShape::kMostCoefficients>& even, double q) {
    Polynomial sum;
    for (std::size_t i = even.size(); i-- > 0;) {
        sum.derivative = sum.derivative * q + sum.value;
        sum.value = sum.value * q + even[i];
    }
    // So far a4 + a6 q + ...; times q^2.
    return {sum.value * q * q, 2.0 * q * sum.value + q * q * sum.derivative};
}

}  // namespace

double SurfaceShape::Sag(double x, double y) const {
    // NaN from the square root is the answer beyond the equator. A cylinder is a toroid with one
    // curvature 0.
    if (rotational()) {
        const double c = curvature_x_;
        const double q = x * x + y * y;
        const double conic = c * q / (1.0 + std::sqrt(1.0 - (1.0 + conic_) * c * c * q));
        return form_ == SurfaceForm::kQuadric ? conic : conic + EvenTerms(even_, q).value;
    }
    const double ax = curvature_x_ * x;
    const double ay = curvature_y_ * y;
    return (ax * x + ay * y) / (1.0 + std::sqrt(1.0 - ax * ax - ay * ay));
}

Vec2d SurfaceShape::Slope(double x, double y) const {
    if (rotational()) {
        const double c = curvature_x_;
        const double q = x * x + y * y;
        // d z / d x = c x / sqrt(...) for a conic.
        double by_x = c / std::sqrt(1.0 - (1.0 + conic_) * c * c * q);
        if (form_ == SurfaceForm::kAsphere) by_x += 2.0 * EvenTerms(even_, q).derivative;
        return {by_x * x, by_x * y};
    }
    const double ax = curvature_x_ * x;
    const double ay = curvature_y_ * y;
    const double root = std::sqrt(1.0 - ax * ax - ay * ay);
    const double n = ax * x + ay * y;
    const double d = 1.0 + root;
    // z = n / d with d' = -cx^2 x / root.
    return {2.0 * ax / d + n * curvature_x_ * ax / (root * d * d),
            2.0 * ay / d + n * curvature_y_ * ay / (root * d * d)};
}

double SurfaceShape::reach_mm() const {
    double steepest = std::max(std::abs(curvature_x_), std::abs(curvature_y_));
    if (rotational()) steepest *= std::sqrt(std::max(0.0, 1.0 + conic_));
    return steepest == 0.0 ? std::numeric_limits<double>::infinity() : 1.0 / steepest;
}

std::array<double, 2> SurfaceShape::SagRange(double radius_mm) const {
    constexpr int kSteps = 64;
    std::array<double, 2> range{0.0, 0.0};
    const double radius = std::min(radius_mm, reach_mm() * (1.0 - 1e-12));
    const int first = form_ == SurfaceForm::kAsphere ? 1 : kSteps;
    for (int i = first; i <= kSteps; ++i) {
        const double r = radius * i / kSteps;
        for (const double sag : {Sag(r, 0.0), Sag(0.0, r)}) {
            if (std::isnan(sag)) continue;
            range[0] = std::min(range[0], sag);
            range[1] = std::max(range[1], sag);
        }
    }
    return range;
}

}  // namespace flare
