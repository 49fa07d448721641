// SPDX-License-Identifier: Apache-2.0
//
// The shapes of surfaces for the second tracer, in long double and sharing no code with the core.
// Spheres and cylinders are cut by the line about their centre of curvature. Everything that a sag
// describes (conics, aspheres, toroids) is found by walking along the line and bisecting, never by
// Newton's method, and its normal is that of finite differences: the sag alone is taken from the
// textbook. Slow, clear, and right to about 1e-15 mm for the surfaces of camera lenses.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/optics/prescription.h"

namespace flare::testing {

using Real = long double;

struct Real3 {
    Real x = 0, y = 0, z = 0;
};

inline Real3 operator+(Real3 a, Real3 b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Real3 operator-(Real3 a, Real3 b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Real3 operator*(Real3 a, Real s) {
    return {a.x * s, a.y * s, a.z * s};
}
inline Real Dot(Real3 a, Real3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Real3 Unit(Real3 a) {
    return a * (1 / std::sqrt(Dot(a, a)));
}

struct ScalarHit {
    bool met = false;
    Real t = 0;
    Real3 point, normal;  // the normal points to the surface's back (+z at the vertex)
    Real cosine = 0;      // normal . direction, signed
    int crossings = 1;    // how many there were in the wanted direction
};

// Aspheres and toroids are looked for within this many semi-diameters of the axis.
inline constexpr Real kScalarReach = 1.25L;

struct ScalarShape {
    Real radius = 0;      // of a sphere or cylinder, 0: plane
    int cylinder = -1;    // curved in x: 0, in y: 1
    bool by_sag = false;  // the rest describes it
    Real cx = 0, cy = 0, conic = 0;
    std::vector<Real> even;

    // Under the root of the sag: 1 at the vertex, 0 at the equator. For a conic cx = cy; a toroid's
    // conic is 0.
    Real Under(Real x, Real y) const {
        return 1 - (1 + conic) * (cx * cx * x * x + cy * cy * y * y);
    }

    Real Sag(Real x, Real y) const {
        const Real r2 = x * x + y * y;
        Real sag = (cx * x * x + cy * y * y) / (1 + std::sqrt(Under(x, y)));
        Real power = r2 * r2;
        for (const Real a : even) {
            sag += a * power;
            power *= r2;
        }
        return sag;
    }
};

inline ScalarShape ScalarShapeOf(const SurfacePrescription& from) {
    const auto finite = [](double radius) { return std::isinf(radius) ? 0.0L : Real(radius); };
    const auto curvature = [&](double r) { return finite(r) == 0 ? 0.0L : 1 / finite(r); };
    ScalarShape to;
    switch (from.kind) {
        case SurfaceKind::kSphere:
            to.radius = finite(from.radius_mm);
            break;
        case SurfaceKind::kCylinderX:
        case SurfaceKind::kCylinderY:
            to.radius = finite(from.radius_mm);
            to.cylinder = from.kind == SurfaceKind::kCylinderX ? 0 : 1;
            break;
        case SurfaceKind::kAsphere:
            to.by_sag = true;
            to.cx = to.cy = curvature(from.radius_mm);
            to.conic = from.conic;
            to.even.assign(from.asphere.begin(), from.asphere.end());
            break;
        case SurfaceKind::kToroid:
            to.by_sag = true;
            to.cx = curvature(from.radius_x_mm);
            to.cy = curvature(from.radius_y_mm);
            break;
        case SurfaceKind::kPlane:
        case SurfaceKind::kStop:
        case SurfaceKind::kSensor:
            break;
    }
    return to;
}

// The line through p (relative to the vertex) along d, cut with a plane, sphere or cylinder, on the
// vertex's side of its equator.
inline ScalarHit MeetCircle(const ScalarShape& shape, Real3 p, Real3 d, bool forward) {
    ScalarHit hit;
    if (shape.radius == 0) {
        if (d.z == 0 || (d.z > 0) != forward) return hit;
        hit.met = true;
        hit.t = -p.z / d.z;
        hit.point = p + d * hit.t;
        hit.normal = {0, 0, 1};
        hit.cosine = d.z;
        return hit;
    }
    // A cylinder is a circle in the projection along its axis.
    Real3 flat_p = p, flat_d = d;
    if (shape.cylinder == 0) flat_p.y = flat_d.y = 0;
    if (shape.cylinder == 1) flat_p.x = flat_d.x = 0;
    const Real3 centre{0, 0, shape.radius};
    const Real3 to = flat_p - centre;
    const Real dd = Dot(flat_d, flat_d);
    if (dd == 0) return hit;
    const Real half_b = Dot(to, flat_d) / dd;
    const Real3 across = to - flat_d * half_b;
    const Real discriminant = (shape.radius * shape.radius - Dot(across, across)) / dd;
    if (discriminant < 0) return hit;
    const Real root = std::sqrt(discriminant);
    for (const Real t : {-half_b - root, -half_b + root}) {
        const Real3 on_circle = flat_p + flat_d * t;
        const Real3 normal = (centre - on_circle) * (1 / shape.radius);
        const Real cosine = Dot(normal, flat_d);
        if (normal.z > 0 && (cosine > 0) == forward) return {true, t, p + d * t, normal, cosine, 1};
    }
    return hit;
}

// All crossings in the wanted direction of a line with a surface given by its sag, within `radius`
// of the axis: samples along the line, and between them the turning points, so that two crossings
// close together are not overlooked.
class SagCrossings {
  public:
    SagCrossings(const ScalarShape& shape, Real radius, Real3 p, Real3 d, bool forward)
        : shape_(shape), radius_(radius), p_(p), d_(d), forward_(forward) {}

    std::vector<Real> Find() {
        // Everything lies in a ball about the vertex.
        Real deepest = 0;
        for (int i = 0; i <= 64; ++i) {
            const Real r = radius_ * i / 64;
            for (const Real sag : {shape_.Sag(r, 0), shape_.Sag(0, r)}) {
                if (sag == sag) deepest = std::max(deepest, std::abs(sag));
            }
        }
        const Real middle = -Dot(p_, d_);
        const Real3 across = p_ + d_ * middle;
        const Real ball2 = radius_ * radius_ + 1.1L * deepest * deepest + 1e-6L;
        const Real chord2 = ball2 - Dot(across, across);
        if (!(chord2 > 0)) return {};
        const Real half = std::sqrt(chord2);
        std::vector<Real> t(kSamples + 1), h(kSamples + 1);
        for (int i = 0; i <= kSamples; ++i) {
            const auto k = static_cast<std::size_t>(i);
            t[k] = middle + half * (2 * Real(i) / kSamples - 1);
            h[k] = Height(t[k]);
        }
        for (std::size_t k = 0; k + 1 < t.size(); ++k) Between(t[k], h[k], t[k + 1], h[k + 1]);
        for (std::size_t k = 1; k + 1 < t.size(); ++k) {
            const Real a = h[k - 1], b = h[k], c = h[k + 1];
            const bool top = b < 0 && b >= a && b >= c, bottom = b > 0 && b <= a && b <= c;
            if (!top && !bottom) continue;
            const Real turn = Turn(t[k - 1], t[k + 1], top);
            Between(t[k - 1], a, turn, Height(turn));
            Between(turn, Height(turn), t[k + 1], c);
        }
        return found_;
    }

  private:
    static constexpr int kSamples = 256;

    Real Height(Real t) const {
        const Real3 q = p_ + d_ * t;
        if (q.x * q.x + q.y * q.y > radius_ * radius_)
            return std::numeric_limits<Real>::quiet_NaN();
        return q.z - shape_.Sag(q.x, q.y);
    }

    void Between(Real lo, Real at_lo, Real hi, Real at_hi) {
        if (std::isnan(at_lo) == std::isnan(at_hi) && std::isnan(at_lo)) return;
        if (std::isnan(at_lo) || std::isnan(at_hi)) {  // the domain's edge lies between
            Real in = std::isnan(at_lo) ? hi : lo, out = std::isnan(at_lo) ? lo : hi;
            for (int i = 0; i < 64; ++i) {
                const Real mid = (in + out) / 2;
                (std::isnan(Height(mid)) ? out : in) = mid;
            }
            (std::isnan(at_lo) ? lo : hi) = in;
            (std::isnan(at_lo) ? at_lo : at_hi) = Height(in);
        }
        if (!(forward_ ? at_lo <= 0 && at_hi > 0 : at_lo >= 0 && at_hi < 0)) return;
        for (int i = 0; i < 90; ++i) {
            const Real mid = (lo + hi) / 2;
            ((Height(mid) > 0) == forward_ ? hi : lo) = mid;
        }
        found_.push_back((lo + hi) / 2);
    }

    // The top or bottom of the height between, by thirds.
    Real Turn(Real lo, Real hi, bool top) const {
        for (int i = 0; i < 100; ++i) {
            const Real a = lo + (hi - lo) / 3, b = hi - (hi - lo) / 3;
            const bool rises = Height(b) > Height(a);
            (rises == top ? lo : hi) = rises == top ? a : b;
        }
        return (lo + hi) / 2;
    }

    const ScalarShape& shape_;
    Real radius_;
    Real3 p_, d_;
    bool forward_;
    std::vector<Real> found_;
};

// d sag / dx or d sag / dy, central differences of eighth order.
inline Real SagSlope(const ScalarShape& shape, Real x, Real y, bool along_x, Real step) {
    constexpr Real kWeights[] = {4.0L / 5, -1.0L / 5, 4.0L / 105, -1.0L / 280};
    Real slope = 0;
    for (int k = 1; k <= 4; ++k) {
        const Real dx = along_x ? k * step : 0, dy = along_x ? 0 : k * step;
        slope += kWeights[k - 1] * (shape.Sag(x + dx, y + dy) - shape.Sag(x - dx, y - dy));
    }
    return slope / step;
}

// Of several crossings the one nearest to where the line meets the conic (for a toroid the sphere
// of mean curvature) beneath, or else the tangent plane.
inline ScalarHit MeetSag(const ScalarShape& shape, Real semi, Real3 p, Real3 d, bool forward) {
    ScalarShape base = shape;
    base.even.clear();
    base.cx = base.cy = (shape.cx + shape.cy) / 2;
    std::vector<Real> found = SagCrossings(shape, kScalarReach * semi, p, d, forward).Find();
    ScalarHit hit;
    if (found.empty()) return hit;
    if (found.size() > 1) {
        const std::vector<Real> beneath =
            SagCrossings(base, kScalarReach * semi, p, d, forward).Find();
        const Real near = !beneath.empty() ? beneath.front() : -p.z / d.z;
        std::sort(found.begin(), found.end(),
                  [&](Real a, Real b) { return std::abs(a - near) < std::abs(b - near); });
        // Turning points may find the same crossing twice.
        hit.crossings = 1 + static_cast<int>(std::count_if(found.begin(), found.end(), [&](Real t) {
                            return std::abs(t - found.front()) > 1e-12L;
                        }));
    }
    hit.t = found.front();
    hit.point = p + d * hit.t;
    // Differences must not reach over the equator, nor come near it.
    const Real steep = std::max(std::abs(shape.cx), std::abs(shape.cy)) *
                       std::sqrt(std::max(Real(0), 1 + shape.conic));
    Real step = std::min(semi, Real(1)) / 1024;
    if (steep > 0) step = std::min(step, shape.Under(hit.point.x, hit.point.y) / (160 * steep));
    hit.normal = Unit({-SagSlope(shape, hit.point.x, hit.point.y, true, step),
                       -SagSlope(shape, hit.point.x, hit.point.y, false, step), 1});
    hit.cosine = Dot(hit.normal, d);
    hit.met = hit.cosine == hit.cosine;
    return hit;
}

inline ScalarHit MeetShape(const ScalarShape& shape, Real semi, Real3 p, Real3 d, bool forward) {
    return shape.by_sag ? MeetSag(shape, semi, p, d, forward) : MeetCircle(shape, p, d, forward);
}

}  // namespace flare::testing
