// SPDX-License-Identifier: Apache-2.0
//
// In a plane of symmetry there is one unknown, the place u in the meridional plane: the height at
// the stop as a function of u is scanned for a change of sign between living neighbours, then
// bisected. A scan, not Newton from the paraxial pupil: in wide-angle lenses the real pupil lies
// far from it. Of several crossings the one whose rays pass the rims most easily is the
// image-forming one.
#include "core/tracing/chief_ray.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace flare {
namespace {

// How near to the stop's centre the chief ray of an anamorphic lens must come.
constexpr double kAimed_mm = 1e-11;

struct Probe {
    bool alive = false;
    double height = 0.0;  // at the stop, along the meridional plane
    Vec2d stop{0.0, 0.0};
    TraceResult result;
};

class StopAim {
  public:
    StopAim(const Lens& lens, const LightBundle& bundle, double wavelength_nm)
        : bundle_(bundle), list_(WriteOut(lens, {}, wavelength_nm)) {}

    Probe At(double u) { return At(u, 0.0); }

    Probe At(double u, double v) {
        TraceOptions options;
        options.clip = false;
        Probe probe;
        probe.result = TraceRay(list_, bundle_.At(u, v), options, &record_);
        probe.alive = probe.result.fate == RayFate::kArrived && !record_.stop_mm.empty();
        if (!probe.alive) return probe;
        probe.stop = record_.stop_mm.front();
        // In a plane of symmetry the ray stays in it.
        const Vec2d along = bundle_.Meridional(1.0, 0.0);
        probe.height = probe.stop.dot(along);
        return probe;
    }

    // Newton's method in the plane across the beam, slopes by differences.
    std::optional<ChiefRay> Aim(double u, double v) {
        const double step = 1e-6 * bundle_.half_width();
        Probe probe = At(u, v);
        for (int i = 0; i < 60 && probe.alive; ++i) {
            const double miss = probe.stop.length();
            if (miss < kAimed_mm) {
                return ChiefRay{bundle_.At(u, v), u, v, probe.result.sensor_mm,
                                probe.result.max_rim_ratio2};
            }
            const Probe du = At(u + step, v);
            const Probe dv = At(u, v + step);
            if (!du.alive || !dv.alive) return std::nullopt;
            const Vec2d a = (du.stop - probe.stop) / step;
            const Vec2d b = (dv.stop - probe.stop) / step;
            const double determinant = a.x * b.y - a.y * b.x;
            if (determinant == 0.0) return std::nullopt;
            double move_u = (b.x * probe.stop.y - b.y * probe.stop.x) / determinant;
            double move_v = (a.y * probe.stop.x - a.x * probe.stop.y) / determinant;
            Probe next = At(u + move_u, v + move_v);
            for (int halving = 0; halving < 30 && !(next.alive && next.stop.length() < miss);
                 ++halving) {
                move_u *= 0.5;
                move_v *= 0.5;
                next = At(u + move_u, v + move_v);
            }
            if (!(next.alive && next.stop.length() < miss)) return std::nullopt;
            u += move_u;
            v += move_v;
            probe = next;
        }
        return std::nullopt;
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
        return ChiefRay{bundle_.At(u, 0.0), u, 0.0, probe.result.sensor_mm,
                        probe.result.max_rim_ratio2};
    }

  private:
    const LightBundle& bundle_;
    InteractionList list_;
    RayRecord record_;
};

// Without a plane of symmetry: from the rays of a coarse grid that come nearest to the stop's
// centre.
std::optional<ChiefRay> FindSkewChiefRay(StopAim& aim, const LightBundle& bundle) {
    struct Start {
        double miss, u, v;
    };
    constexpr int kSteps = 24;
    std::vector<Start> starts;
    for (int j = 0; j <= kSteps; ++j) {
        for (int i = 0; i <= kSteps; ++i) {
            const double u = bundle.centre_u() + bundle.half_width() * (2.0 * i / kSteps - 1.0);
            const double v = bundle.half_width() * (2.0 * j / kSteps - 1.0);
            const Probe probe = aim.At(u, v);
            if (probe.alive) starts.push_back({probe.stop.length(), u, v});
        }
    }
    constexpr std::size_t kTries = 6;
    const std::size_t tries = std::min(kTries, starts.size());
    std::partial_sort(starts.begin(), starts.begin() + static_cast<std::ptrdiff_t>(tries),
                      starts.end(), [](const Start& a, const Start& b) { return a.miss < b.miss; });
    std::optional<ChiefRay> best;
    for (std::size_t k = 0; k < tries; ++k) {
        const std::optional<ChiefRay> found = aim.Aim(starts[k].u, starts[k].v);
        if (found && (!best || found->max_rim_ratio2 < best->max_rim_ratio2)) best = found;
        // One that passes within the rims is the image-forming one.
        if (best && best->max_rim_ratio2 <= 1.0) break;
    }
    return best;
}

}  // namespace

std::optional<ChiefRay> FindChiefRay(const Lens& lens, const LightBundle& bundle,
                                     double wavelength_nm) {
    StopAim aim(lens, bundle, wavelength_nm);
    if (!bundle.mirror_symmetric()) return FindSkewChiefRay(aim, bundle);
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
        return chief->sensor_mm.length();
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

std::optional<Vec3d> TravelToSensor(const Lens& lens, Vec2d sensor_mm, double inverse_distance,
                                    double wavelength_nm) {
    const auto image_of = [&](Vec2d slope) -> std::optional<Vec2d> {
        const CanonicalPose pose = PoseOf(lens, std::atan2(slope.y, slope.x));
        const LightBundle bundle(lens, std::atan(slope.length()), inverse_distance,
                                 pose.azimuth_rad);
        const std::optional<ChiefRay> chief = FindChiefRay(lens, bundle, wavelength_nm);
        if (!chief) return std::nullopt;
        return pose.LensSpace(chief->sensor_mm);
    };
    const auto distance = [&](Section section) {
        return lens.first_order(section).projection_distance_mm;
    };
    constexpr double kArrived_mm = 1e-9;
    Vec2d slope(sensor_mm.x / distance(Section::kX), sensor_mm.y / distance(Section::kY));
    std::optional<Vec2d> image = image_of(slope);
    // Too far out for the lens: come back towards the axis until there is an image to start from.
    for (int i = 0; i < 20 && !image; ++i) {
        slope *= 0.8;
        image = image_of(slope);
    }
    constexpr double kStep = 1e-5;
    for (int i = 0; i < 40 && image; ++i) {
        const Vec2d miss = sensor_mm - *image;
        if (miss.length() < kArrived_mm) {
            return Vec3d(slope.x, slope.y, 1.0).normalized();
        }
        const std::optional<Vec2d> dx = image_of(slope + Vec2d(kStep, 0.0));
        const std::optional<Vec2d> dy = image_of(slope + Vec2d(0.0, kStep));
        if (!dx || !dy) return std::nullopt;
        const Vec2d a = (*dx - *image) / kStep;
        const Vec2d b = (*dy - *image) / kStep;
        const double determinant = a.x * b.y - a.y * b.x;
        if (determinant == 0.0) return std::nullopt;
        Vec2d move((miss.x * b.y - miss.y * b.x) / determinant,
                   (a.x * miss.y - a.y * miss.x) / determinant);
        std::optional<Vec2d> next;
        for (int halving = 0; halving < 12; ++halving, move *= 0.5) {
            next = image_of(slope + move);
            if (next && (sensor_mm - *next).length() < miss.length()) break;
            next.reset();
        }
        slope += move;
        image = next;
    }
    return std::nullopt;
}

}  // namespace flare
