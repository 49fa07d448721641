// SPDX-License-Identifier: Apache-2.0
//
// Invariants: the direction has unit length after every step; a ray ends in exactly one fate; no
// square root is taken of a negative number and no discriminant is clamped.
#include "core/tracing/trace_reference.h"

#include <algorithm>
#include <cmath>

#include "core/tracing/surface_hit.h"

namespace flare {
namespace {

class Walk {
  public:
    Walk(const InteractionList& list, const Ray& ray, const TraceOptions& options,
         RayRecord* record)
        : list_(list), options_(options), record_(record), p_(ray.origin), d_(ray.direction) {
        if (record_ != nullptr) {
            record_->cos_in.clear();
            record_->rim_ratio2.clear();
            record_->stop_mm.clear();
            record_->points.clear();
            record_->segment_mm.clear();
        }
    }

    TraceResult Run() {
        for (int i = 0; i < static_cast<int>(list_.steps.size()); ++i) {
            if (!Step(list_.steps[static_cast<std::size_t>(i)], i == 0)) {
                result_.ended_at = i;
                return result_;
            }
        }
        ReachSensor();
        return result_;
    }

  private:
    // One interaction; false if the ray ends here, its fate then being set.
    bool Step(const Interaction& step, bool first) {
        const Vec3d local = p_ - Vec3d(0.0, 0.0, step.vertex_z_mm);
        const SurfaceHit hit =
            MeetSurface(step.shape, step.semi_diameter_mm, step.forward, local, d_);
        if (!hit.met) return End(RayFate::kMissed);

        const double ratio2 = (hit.point.x * hit.point.x + hit.point.y * hit.point.y) /
                              (step.semi_diameter_mm * step.semi_diameter_mm);
        const bool is_stop = step.kind == InteractionKind::kStop;
        if (!is_stop) result_.max_rim_ratio2 = std::max(result_.max_rim_ratio2, ratio2);
        Record(step, hit, ratio2);

        // The first surface is met wherever on the line the origin lies.
        if (!first && hit.distance < -kOrderTolerance_mm) {
            result_.out_of_order = true;
            if (result_.max_rim_ratio2 <= 1.0) result_.out_of_order_inside = true;
            if (options_.clip) return End(RayFate::kMissed);
        }
        result_.path_mm += step.n_in * hit.distance;
        p_ = hit.point + Vec3d(0.0, 0.0, step.vertex_z_mm);

        if (options_.clip && !is_stop && ratio2 > 1.0) return End(RayFate::kVignetted);
        if (is_stop) return PassStop(step, hit, ratio2);
        if (step.kind == InteractionKind::kReflect) {
            d_ -= hit.normal * (2.0 * hit.cosine);
            d_.normalize();
            return true;
        }
        return Refract(step, hit);
    }

    bool PassStop(const Interaction&, const SurfaceHit& hit, double ratio2) {
        if (!options_.clip) return true;
        const bool open = options_.iris != nullptr
                              ? options_.iris->Distance(Vec2d(hit.point.x, hit.point.y)) <= 0.0
                              : ratio2 <= 1.0;
        return open || End(RayFate::kStopped);
    }

    // Snell in vectors: the tangential part scales by n_in / n_out. sin^2 comes from that part, not
    // from 1 - cos^2.
    bool Refract(const Interaction& step, const SurfaceHit& hit) {
        const double eta = step.n_in / step.n_out;
        const Vec3d tangential = (d_ - hit.normal * hit.cosine) * eta;
        const double sin2 = tangential.dot(tangential);
        if (sin2 >= 1.0) return End(RayFate::kTir);
        const double cosine = std::sqrt(1.0 - sin2);
        d_ = tangential + hit.normal * (hit.cosine >= 0.0 ? cosine : -cosine);
        d_.normalize();
        return true;
    }

    void ReachSensor() {
        result_.exit_direction = d_;
        if (!(d_.z > 0.0)) {
            result_.fate = RayFate::kMissed;
            return;
        }
        const double distance = (list_.sensor_z_mm - p_.z) / d_.z;
        if (distance < -kOrderTolerance_mm) {
            result_.out_of_order = true;
            if (options_.clip) {
                result_.fate = RayFate::kMissed;
                return;
            }
        }
        result_.sensor_mm = {p_.x + d_.x * distance, p_.y + d_.y * distance};
        result_.path_mm += distance;
        result_.fate = RayFate::kArrived;
    }

    void Record(const Interaction& step, const SurfaceHit& hit, double ratio2) {
        if (record_ == nullptr) return;
        record_->cos_in.push_back(std::min(1.0, std::abs(hit.cosine)));
        record_->rim_ratio2.push_back(ratio2);
        record_->segment_mm.push_back(hit.distance);
        if (step.kind == InteractionKind::kStop)
            record_->stop_mm.emplace_back(hit.point.x, hit.point.y);
        if (options_.record_points) {
            record_->points.push_back(hit.point + Vec3d(0.0, 0.0, step.vertex_z_mm));
        }
    }

    bool End(RayFate fate) {
        result_.fate = fate;
        return false;
    }

    const InteractionList& list_;
    const TraceOptions& options_;
    RayRecord* record_;
    Vec3d p_, d_;
    TraceResult result_;
};

}  // namespace

TraceResult TraceRay(const InteractionList& list, const Ray& ray, const TraceOptions& options,
                     RayRecord* record) {
    return Walk(list, ray, options, record).Run();
}

double PathWeight(const Lens& lens, const InteractionList& list, const RayRecord& record) {
    double weight = 1.0;
    for (std::size_t i = 0; i < record.cos_in.size(); ++i) {
        const Interaction& step = list.steps[i];
        const Reflection r = ReflectionAt(lens, step, record.cos_in[i], list.wavelength_nm);
        weight *= step.kind == InteractionKind::kReflect ? r.reflectance : r.transmittance;
        if (step.absorption_per_mm > 0.0) {
            weight *= std::exp(-step.absorption_per_mm * record.segment_mm[i]);
        }
    }
    return weight;
}

}  // namespace flare
