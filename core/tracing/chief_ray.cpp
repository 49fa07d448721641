// SPDX-License-Identifier: Apache-2.0
//
// One unknown, the place u in the meridional plane: the height at the stop as a function of u is
// scanned for a change of sign between living neighbours, then bisected. A scan, not Newton from
// the paraxial pupil: in wide-angle lenses the real pupil lies far from it. Of several crossings
// the one whose rays pass the rims most easily is the image-forming one.
#include "core/tracing/chief_ray.h"

#include <cmath>

namespace flare {
namespace {

struct Probe {
    bool alive = false;
    double height = 0.0;
    TraceResult result;
};

class StopAim {
  public:
    StopAim(const Lens& lens, const LightBundle& bundle, double wavelength_nm)
        : bundle_(bundle), list_(WriteOut(lens, {}, wavelength_nm)) {}

    Probe At(double u) {
        TraceOptions options;
        options.clip = false;
        Probe probe;
        probe.result = TraceRay(list_, bundle_.At(u, 0.0), options, &record_);
        probe.alive = probe.result.fate == RayFate::kArrived && !record_.stop_mm.empty();
        if (probe.alive) probe.height = record_.stop_mm.front().x;
        return probe;
    }

    std::optional<ChiefRay> Bisect(double lo, double hi, double height_lo) {
        for (int i = 0; i < 200; ++i) {
            const double mid = 0.5 * (lo + hi);
            if (mid == lo || mid == hi) break;
            const Probe probe = At(mid);
            if (!probe.alive) return std::nullopt;
            ((probe.height < 0.0) == (height_lo < 0.0) ? lo : hi) = mid;
        }
        const Probe probe = At(0.5 * (lo + hi));
        if (!probe.alive) return std::nullopt;
        const double u = 0.5 * (lo + hi);
        return ChiefRay{bundle_.At(u, 0.0), u, probe.result.sensor_mm, probe.result.max_rim_ratio2};
    }

  private:
    const LightBundle& bundle_;
    InteractionList list_;
    RayRecord record_;
};

}  // namespace

std::optional<ChiefRay> FindChiefRay(const Lens& lens, const LightBundle& bundle,
                                     double wavelength_nm) {
    StopAim aim(lens, bundle, wavelength_nm);
    constexpr int kSteps = 256;
    std::optional<ChiefRay> best;
    double last_u = 0.0;
    Probe last;
    for (int i = 0; i <= kSteps; ++i) {
        const double u = bundle.centre_u() + bundle.half_width() * (2.0 * i / kSteps - 1.0);
        const Probe probe = aim.At(u);
        std::optional<ChiefRay> found;
        if (probe.alive && probe.height == 0.0) {
            found = aim.Bisect(u, u, 0.0);
        } else if (probe.alive && last.alive && (probe.height < 0.0) != (last.height < 0.0) &&
                   last.height != 0.0) {
            found = aim.Bisect(last_u, u, last.height);
        }
        if (found && (!best || found->max_rim_ratio2 < best->max_rim_ratio2)) best = found;
        last = probe;
        last_u = u;
    }
    return best;
}

std::optional<double> FieldOfImageRadius(const Lens& lens, double radius_mm,
                                         double inverse_distance, double wavelength_nm) {
    const auto radius_of = [&](double field) -> std::optional<double> {
        const auto chief =
            FindChiefRay(lens, LightBundle(lens, field, inverse_distance), wavelength_nm);
        if (!chief) return std::nullopt;
        return std::abs(chief->sensor_mm.x);
    };
    // March out from the axis to bracket the radius, then bisect.
    constexpr double kStep = 0.02;
    double lo = 0.0;
    for (double hi = kStep; hi < 3.1; hi += kStep) {
        const std::optional<double> radius = radius_of(hi);
        if (!radius) return std::nullopt;
        if (*radius < radius_mm) {
            lo = hi;
            continue;
        }
        for (int i = 0; i < 60; ++i) {
            const double mid = 0.5 * (lo + hi);
            if (mid == lo || mid == hi) break;
            const std::optional<double> r = radius_of(mid);
            if (!r) return std::nullopt;
            (*r < radius_mm ? lo : hi) = mid;
        }
        return 0.5 * (lo + hi);
    }
    return std::nullopt;
}

}  // namespace flare
