// SPDX-License-Identifier: Apache-2.0
//
// A second ray tracer, for tests only: written from the textbook, in long double, straight from the
// prescription, and sharing no code with the core (but the index of a glass given by name, which
// has tests of its own). Where the core uses the curvature form from the vertex and Newton's
// method, this one cuts the ray with the sphere about its centre of curvature and bisects
// (scalar_surface.h); where the core walks an interaction list, this one walks the surfaces and
// turns round at each reflection.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/optics/glass_catalogue.h"
#include "core/optics/prescription.h"
#include "tests/support/scalar_surface.h"

namespace flare::testing {

enum class ScalarFate { kArrived, kVignetted, kStopped, kMissed, kTir };

struct ScalarResult {
    ScalarFate fate = ScalarFate::kMissed;
    int ended_at = -1;         // number of the interaction, -1: at the sensor
    Real x_mm = 0, y_mm = 0;   // on the sensor
    Real path_mm = 0;          // optical
    std::vector<Real3> stops;  // where it crossed the stop
    std::vector<Real> cos_in;  // at every surface it met, stop included
    // Of bare glass: the product of Fresnel's R and T, and of what the media let through.
    Real weight = 1;
    // How near the ray came to another fate: the least distance from a rim (mm), from total
    // reflection (in sin^2), from an order of surfaces (mm).
    Real margin = std::numeric_limits<Real>::infinity();
    // The largest distance from the axis, in semi-diameters, at which it met a conic, an asphere or
    // a toroid; and the most crossings that one of them offered.
    Real widest_sag = 0;
    int most_crossings = 1;
};

// Two-term Cauchy index through n_d and V_d, or the catalogue's.
inline Real IndexBehind(const SurfacePrescription& surface, Real wavelength_nm) {
    if (surface.glass) {
        return GlassByName(*surface.glass).value().Index(static_cast<double>(wavelength_nm));
    }
    const Real nd = surface.nd.value_or(1.0);
    if (nd == 1 || !surface.vd) return nd;
    const auto q = [](Real nm) { return 1 / (nm * nm); };
    const Real b = (nd - 1) / (*surface.vd * (q(486.1327L) - q(656.2725L)));
    return nd + b * (q(wavelength_nm) - q(587.5618L));
}

inline Real AbsorptionBehind(const SurfacePrescription& surface, Real wavelength_nm) {
    if (!surface.glass) return 0;
    return GlassByName(*surface.glass).value().AbsorptionPerMm(static_cast<double>(wavelength_nm));
}

struct ScalarSurface {
    bool stop = false, sensor = false;
    ScalarShape shape;
    Real radius = 0;  // of a sphere, 0: plane
    Real z = 0, semi = 0;
    Real n_before = 1, n_behind = 1;
    Real absorption_before = 0, absorption_behind = 0;  // per mm
    Real reflectance = 0;                               // of a sensor
};

// A reflecting sensor comes last; its place is the paraxial focus where the file gives no gap, so
// that `sensor_z` of the trace is to be asked.
inline std::vector<ScalarSurface> ScalarSurfaces(const Prescription& lens, Real wavelength_nm) {
    std::vector<ScalarSurface> surfaces;
    Real z = 0, n = 1, absorption = 0;
    for (const SurfacePrescription& from : lens.surfaces) {
        ScalarSurface to;
        to.stop = from.kind == SurfaceKind::kStop;
        to.sensor = from.kind == SurfaceKind::kSensor;
        to.shape = ScalarShapeOf(from);
        to.radius = to.shape.radius;
        to.z = z;
        to.semi = from.semi_diameter_mm;
        to.reflectance = from.reflectance;
        to.n_before = n;
        to.n_behind = n = IndexBehind(from, wavelength_nm);
        to.absorption_before = absorption;
        to.absorption_behind = absorption = AbsorptionBehind(from, wavelength_nm);
        z += from.gap_mm;
        surfaces.push_back(to);
    }
    return surfaces;
}

// Where the line meets the surface in the wanted direction of crossing, on the vertex's hemisphere.
inline ScalarHit ScalarMeet(const ScalarSurface& s, Real3 p, Real3 d, bool forward) {
    const Real3 vertex{0, 0, s.z};
    ScalarHit hit = MeetShape(s.shape, s.semi, p - vertex, d, forward);
    hit.point = hit.point + vertex;
    return hit;
}

// Fresnel for unpolarised light, with the angles' cosines.
inline Real FresnelReflectance(Real n1, Real n2, Real cos1) {
    const Real sin2 = n1 / n2 * std::sqrt(1 - cos1 * cos1);
    if (sin2 >= 1) return 1;
    const Real cos2 = std::sqrt(1 - sin2 * sin2);
    const Real rs = (n1 * cos1 - n2 * cos2) / (n1 * cos1 + n2 * cos2);
    const Real rp = (n2 * cos1 - n1 * cos2) / (n2 * cos1 + n1 * cos2);
    return (rs * rs + rp * rp) / 2;
}

class ScalarWalk {
  public:
    ScalarWalk(const std::vector<ScalarSurface>& lens, Real sensor_z,
               const std::vector<int>& bounces, Real3 p, Real3 d, bool clip)
        : lens_(lens), sensor_z_(sensor_z), bounces_(bounces), clip_(clip), p_(p), d_(d) {}

    ScalarResult Run() {
        int i = 0;
        const auto optical = static_cast<int>(lens_.size()) - (lens_.back().sensor ? 1 : 0);
        for (int step = 0;; ++step) {
            const bool reflects = bounce_ < bounces_.size() && bounces_[bounce_] == i;
            if (i == optical && !reflects) return Sensor();
            if (!Pass(lens_[static_cast<std::size_t>(i)], reflects, step == 0)) {
                result_.ended_at = step;
                return result_;
            }
            i += forward_ ? 1 : -1;
        }
    }

  private:
    static constexpr Real kOrder = 1e-7L;

    bool End(ScalarFate fate) {
        result_.fate = fate;
        return false;
    }
    void Near(Real distance) { result_.margin = std::min(result_.margin, std::abs(distance)); }

    bool Pass(const ScalarSurface& s, bool reflects, bool first) {
        ScalarSurface at = s;
        if (s.sensor) at.z = sensor_z_;
        const ScalarHit hit = ScalarMeet(at, p_, d_, forward_);
        if (!hit.met) return End(ScalarFate::kMissed);
        result_.cos_in.push_back(std::abs(hit.cosine));
        if (s.stop) result_.stops.push_back(hit.point);
        const Real height = std::hypot(hit.point.x, hit.point.y);
        if (s.shape.by_sag) {
            result_.widest_sag = std::max(result_.widest_sag, height / s.semi);
            result_.most_crossings = std::max(result_.most_crossings, hit.crossings);
        }
        if (!first) Near(hit.t + kOrder);
        if (clip_ && !first && hit.t < -kOrder) return End(ScalarFate::kMissed);
        Near(height - s.semi);
        if (clip_ && height > s.semi) {
            return End(s.stop ? ScalarFate::kStopped : ScalarFate::kVignetted);
        }
        const Real n1 = forward_ ? s.n_before : s.n_behind;
        const Real n2 = forward_ ? s.n_behind : s.n_before;
        result_.path_mm += n1 * hit.t;
        result_.weight *= std::exp(-(forward_ ? s.absorption_before : s.absorption_behind) * hit.t);
        p_ = hit.point;
        if (s.stop) return true;
        const Real r = s.sensor ? s.reflectance : FresnelReflectance(n1, n2, std::abs(hit.cosine));
        result_.weight *= reflects ? r : 1 - r;
        if (reflects) {
            ++bounce_;
            forward_ = !forward_;
            d_ = Unit(d_ - hit.normal * (2 * hit.cosine));
            return true;
        }
        // Snell by angles: sin2 = n1/n2 sin1, the new direction in the plane of d and the normal.
        const Real eta = n1 / n2;
        const Real sin2 = eta * eta * (1 - hit.cosine * hit.cosine);
        Near(sin2 - 1);
        if (sin2 >= 1) return End(ScalarFate::kTir);
        const Real sign = hit.cosine > 0 ? 1 : -1;
        d_ = Unit(d_ * eta + hit.normal * (sign * std::sqrt(1 - sin2) - eta * hit.cosine));
        return true;
    }

    ScalarResult Sensor() {
        result_.fate = ScalarFate::kMissed;
        if (!(d_.z > 0)) return result_;
        const Real t = (sensor_z_ - p_.z) / d_.z;
        Near(t + kOrder);
        if (clip_ && t < -kOrder) return result_;
        result_.x_mm = p_.x + t * d_.x;
        result_.y_mm = p_.y + t * d_.y;
        result_.path_mm += t;
        result_.fate = ScalarFate::kArrived;
        return result_;
    }

    const std::vector<ScalarSurface>& lens_;
    Real sensor_z_;
    const std::vector<int>& bounces_;
    bool clip_;
    Real3 p_, d_;
    bool forward_ = true;
    std::size_t bounce_ = 0;
    ScalarResult result_;
};

// `bounces`: the reflecting surfaces in order. With clip, rims, stop rim and wrong order end the
// ray.
inline ScalarResult ScalarTrace(const std::vector<ScalarSurface>& lens, Real sensor_z,
                                const std::vector<int>& bounces, Real3 p, Real3 d, bool clip) {
    return ScalarWalk(lens, sensor_z, bounces, p, d, clip).Run();
}

}  // namespace flare::testing
