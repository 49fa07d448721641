// SPDX-License-Identifier: Apache-2.0
//
// Slopes are dy/dz against the +z axis whichever way the light travels: a drift backwards is a
// drift by a negative distance, and a mirror is a refraction with n_out = -n_in.
#include "core/tracing/paraxial_ghost.h"

namespace flare {
Abcd StepMatrix(const Interaction& step, Section section) {
    const double curvature = step.shape.curvature(section);
    switch (step.kind) {
        case InteractionKind::kStop:
            return {};
        case InteractionKind::kReflect:
            return Refraction(curvature, 1.0, -1.0);
        // Refraction depends on n_in / n_out alone, so it holds for both directions of travel.
        case InteractionKind::kRefract:
            return Refraction(curvature, step.n_in, step.n_out);
    }
    return {};
}

ParaxialPath ParaxialPathOf(const InteractionList& list, Section section) {
    ParaxialPath path;
    double z = 0.0;
    Abcd so_far;
    std::vector<Abcd> since_stop;
    const auto extend = [&](const Abcd& step) {
        so_far = Then(so_far, step);
        for (Abcd& m : since_stop) m = Then(m, step);
    };
    for (const Interaction& step : list.steps) {
        extend(Drift(step.vertex_z_mm - z));
        z = step.vertex_z_mm;
        if (step.kind == InteractionKind::kStop) {
            path.front_to_stop.push_back(so_far);
            since_stop.emplace_back();
        }
        extend(StepMatrix(step, section));
    }
    extend(Drift(list.sensor_z_mm - z));
    path.front_to_sensor = so_far;
    path.stop_to_sensor = since_stop;
    return path;
}

}  // namespace flare
