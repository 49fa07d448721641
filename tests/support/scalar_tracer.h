// SPDX-License-Identifier: Apache-2.0
//
// A second ray tracer, for tests only: written from the textbook, in long double, straight from the
// prescription, and sharing no code with the core. Where the core uses the curvature form from the
// vertex, this one cuts the ray with the sphere about its centre of curvature; where the core walks
// an interaction list, this one walks the surfaces and turns round at each reflection. Slow, clear,
// and right to about 1e-15 mm for radii a camera lens has.
#pragma once

#include <cmath>
#include <cstddef>
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

enum class ScalarFate { kArrived, kVignetted, kStopped, kMissed, kTir };

struct ScalarResult {
    ScalarFate fate = ScalarFate::kMissed;
    Real x_mm = 0, y_mm = 0;   // on the sensor
    Real path_mm = 0;          // optical
    std::vector<Real3> stops;  // where it crossed the stop
    std::vector<Real> cos_in;  // at every surface it met, stop included
};

// Two-term Cauchy index through n_d and V_d.
inline Real CauchyIndex(const SurfacePrescription& surface, Real wavelength_nm) {
    const Real nd = surface.nd.value_or(1.0);
    if (nd == 1 || !surface.vd) return nd;
    const auto q = [](Real nm) { return 1 / (nm * nm); };
    const Real b = (nd - 1) / (*surface.vd * (q(486.1327L) - q(656.2725L)));
    return nd + b * (q(wavelength_nm) - q(587.5618L));
}

struct ScalarSurface {
    bool stop = false;
    Real radius = 0;  // 0: plane
    Real z = 0, semi = 0;
    Real n_before = 1, n_behind = 1;
};

inline std::vector<ScalarSurface> ScalarSurfaces(const Prescription& lens, Real wavelength_nm) {
    std::vector<ScalarSurface> surfaces;
    Real z = 0, n = 1;
    for (const SurfacePrescription& from : lens.surfaces) {
        ScalarSurface to;
        to.stop = from.kind == SurfaceKind::kStop;
        to.radius = std::isinf(from.radius_mm) ? 0 : from.radius_mm;
        to.z = z;
        to.semi = from.semi_diameter_mm;
        to.n_before = n;
        to.n_behind = n = CauchyIndex(from, wavelength_nm);
        z += from.gap_mm;
        surfaces.push_back(to);
    }
    return surfaces;
}

struct ScalarHit {
    bool met = false;
    Real t = 0;
    Real3 point, normal;  // the normal points to the surface's back (+z at the vertex)
    Real cosine = 0;      // normal . direction, signed
};

// Where the line meets the surface in the wanted direction of crossing, on the vertex's hemisphere.
inline ScalarHit ScalarMeet(const ScalarSurface& s, Real3 p, Real3 d, bool forward) {
    ScalarHit hit;
    if (s.radius == 0) {
        if (d.z == 0 || (d.z > 0) != forward) return hit;
        hit = {true, (s.z - p.z) / d.z, {}, {0, 0, 1}, d.z};
        hit.point = p + d * hit.t;
        return hit;
    }
    const Real3 centre{0, 0, s.z + s.radius};
    const Real3 to = p - centre;
    const Real half_b = Dot(to, d);
    const Real3 across = to - d * half_b;
    const Real discriminant = s.radius * s.radius - Dot(across, across);
    if (discriminant < 0) return hit;
    const Real root = std::sqrt(discriminant);
    for (const Real t : {-half_b - root, -half_b + root}) {
        const Real3 point = p + d * t;
        const Real3 normal = (centre - point) * (1 / s.radius);
        const Real cosine = Dot(normal, d);
        if (normal.z > 0 && (cosine > 0) == forward) return {true, t, point, normal, cosine};
    }
    return hit;
}

// `bounces`: the reflecting surfaces in order. With clip, rims, stop rim and wrong order end the
// ray.
inline ScalarResult ScalarTrace(const std::vector<ScalarSurface>& lens, Real sensor_z,
                                const std::vector<int>& bounces, Real3 p, Real3 d, bool clip) {
    constexpr Real kOrder = 1e-7L;
    ScalarResult result;
    const auto end = [&](ScalarFate fate) {
        result.fate = fate;
        return result;
    };
    std::size_t bounce = 0;
    bool forward = true;
    bool first = true;
    for (int i = 0; i < static_cast<int>(lens.size()); i += forward ? 1 : -1) {
        const ScalarSurface& s = lens[static_cast<std::size_t>(i)];
        const ScalarHit hit = ScalarMeet(s, p, d, forward);
        if (!hit.met) return end(ScalarFate::kMissed);
        result.cos_in.push_back(std::abs(hit.cosine));
        if (s.stop) result.stops.push_back(hit.point);
        if (clip && !first && hit.t < -kOrder) return end(ScalarFate::kMissed);
        first = false;
        const bool outside = std::hypot(hit.point.x, hit.point.y) > s.semi;
        if (clip && outside) return end(s.stop ? ScalarFate::kStopped : ScalarFate::kVignetted);
        const Real n1 = forward ? s.n_before : s.n_behind;
        const Real n2 = forward ? s.n_behind : s.n_before;
        result.path_mm += n1 * hit.t;
        p = hit.point;
        if (s.stop) continue;
        if (bounce < bounces.size() && bounces[bounce] == i) {
            ++bounce;
            forward = !forward;
            d = Unit(d - hit.normal * (2 * hit.cosine));
            continue;
        }
        // Snell by angles: sin2 = n1/n2 sin1, the new direction in the plane of d and the normal.
        const Real eta = n1 / n2;
        const Real sin2 = eta * eta * (1 - hit.cosine * hit.cosine);
        if (sin2 >= 1) return end(ScalarFate::kTir);
        const Real sign = hit.cosine > 0 ? 1 : -1;
        d = Unit(d * eta + hit.normal * (sign * std::sqrt(1 - sin2) - eta * hit.cosine));
    }
    if (!(d.z > 0)) return end(ScalarFate::kMissed);
    const Real t = (sensor_z - p.z) / d.z;
    if (clip && t < -kOrder) return end(ScalarFate::kMissed);
    result.x_mm = p.x + t * d.x;
    result.y_mm = p.y + t * d.y;
    result.path_mm += t;
    return end(ScalarFate::kArrived);
}

}  // namespace flare::testing
