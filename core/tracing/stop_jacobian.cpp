// SPDX-License-Identifier: Apache-2.0
#include "core/tracing/stop_jacobian.h"

#include <cmath>

#include "core/base/check.h"

namespace flare {
namespace {

constexpr double kPupilStep_mm = 1e-3;
constexpr double kAngleStep = 1e-5;

}  // namespace

Matrix2 Matrix2::Inverse() const {
    const double over = 1.0 / determinant();
    return {Vec2d(y.y, -x.y) * over, Vec2d(-y.x, x.x) * over};
}

std::optional<double> StopJacobian::Distance(Vec2d n) const {
    if (sensor_per_stop.determinant() == 0.0) return std::nullopt;
    return n.dot(sensor_per_stop.Inverse() * (sensor_per_angle * n));
}

StopPassage::StopPassage(const InteractionList& list, std::size_t crossing) : list_(list) {
    std::size_t passed = 0;
    while (true) {
        FLARE_CHECK(step_ < list.steps.size());
        if (list.steps[step_].kind == InteractionKind::kStop && passed++ == crossing) break;
        ++step_;
    }
    const Interaction& stop = list.steps[step_];
    index_ = stop.n_out;
    forward_ = stop.forward;
    rest_.sensor_z_mm = list.sensor_z_mm;
    rest_.wavelength_nm = list.wavelength_nm;
    rest_.steps.assign(list.steps.begin() + static_cast<std::ptrdiff_t>(step_) + 1,
                       list.steps.end());
}

std::optional<StopPassage::State> StopPassage::Trace(const Ray& ray) const {
    TraceOptions options;
    options.clip = false;
    options.record_points = true;
    RayRecord record;
    const TraceResult result = TraceRay(list_, ray, options, &record);
    if (result.fate != RayFate::kArrived) return std::nullopt;
    State state;
    const Vec3d at = record.points[step_];
    state.stop_mm = {at.x, at.y};
    Vec3d direction = result.exit_direction;
    if (step_ + 1 < record.points.size()) {
        direction = (record.points[step_ + 1] - at).normalized();
        if ((direction.z > 0.0) != forward_) direction = -direction;
    }
    state.angle = Vec2d(direction.x, direction.y) * index_;
    state.sensor_mm = result.sensor_mm;
    for (std::size_t i = 0; i <= step_; ++i)
        state.path_to_stop_mm += list_.steps[i].n_in * record.segment_mm[i];
    state.path_mm = result.path_mm - state.path_to_stop_mm;
    return state;
}

std::optional<StopPassage::State> StopPassage::FromStop(Vec2d stop_mm, Vec2d angle) const {
    const Vec2d d = angle / index_;
    const double z2 = 1.0 - d.length2();
    if (!(z2 > 0.0)) return std::nullopt;
    const double z = forward_ ? std::sqrt(z2) : -std::sqrt(z2);
    TraceOptions options;
    options.clip = false;
    const Ray ray{{stop_mm.x, stop_mm.y, list_.steps[step_].vertex_z_mm}, {d.x, d.y, z}};
    const TraceResult result = TraceRay(rest_, ray, options, nullptr);
    if (result.fate != RayFate::kArrived) return std::nullopt;
    State state;
    state.stop_mm = stop_mm;
    state.angle = angle;
    state.sensor_mm = result.sensor_mm;
    state.path_mm = result.path_mm;
    return state;
}

std::optional<StopJacobian> StopPassage::At(const LightBundle& bundle, double u, double v,
                                            double most_mm) const {
    const std::optional<State> here = Trace(bundle.At(u, v));
    if (!here || here->stop_mm.length() > most_mm) return std::nullopt;
    const std::optional<State> by_u = Trace(bundle.At(u + kPupilStep_mm, v));
    const std::optional<State> by_v = Trace(bundle.At(u, v + kPupilStep_mm));
    if (!by_u || !by_v) return std::nullopt;
    const Vec2d s = here->stop_mm;
    const Vec2d a = here->angle;
    const std::optional<State> right = FromStop(s, a + Vec2d(kAngleStep, 0.0));
    const std::optional<State> left = FromStop(s, a - Vec2d(kAngleStep, 0.0));
    const std::optional<State> up = FromStop(s, a + Vec2d(0.0, kAngleStep));
    const std::optional<State> down = FromStop(s, a - Vec2d(0.0, kAngleStep));
    if (!right || !left || !up || !down) return std::nullopt;
    const Matrix2 stop_per_pupil{by_u->stop_mm - s, by_v->stop_mm - s};
    if (stop_per_pupil.determinant() == 0.0) return std::nullopt;
    const Matrix2 sensor_per_pupil{by_u->sensor_mm - here->sensor_mm,
                                   by_v->sensor_mm - here->sensor_mm};
    const Matrix2 pupil_per_stop = stop_per_pupil.Inverse();
    StopJacobian out;
    out.stop_mm = s;
    out.sensor_mm = here->sensor_mm;
    out.sensor_per_stop = {sensor_per_pupil * pupil_per_stop.x,
                           sensor_per_pupil * pupil_per_stop.y};
    out.sensor_per_angle = {(right->sensor_mm - left->sensor_mm) / (2.0 * kAngleStep),
                            (up->sensor_mm - down->sensor_mm) / (2.0 * kAngleStep)};
    return out;
}

}  // namespace flare
