// SPDX-License-Identifier: Apache-2.0
#include "core/tracing/interaction_list.h"

#include "core/base/check.h"

namespace flare {
namespace {

Interaction StepAt(const Lens& lens, int index, bool forward, bool reflects, double wavelength_nm) {
    const LensSurface& surface = lens.surfaces()[static_cast<std::size_t>(index)];
    const double before = lens.MediumBefore(index).Index(wavelength_nm);
    const double behind = lens.MediumBehind(index).Index(wavelength_nm);
    Interaction step;
    step.kind = surface.is_stop() ? InteractionKind::kStop
                : reflects        ? InteractionKind::kReflect
                                  : InteractionKind::kRefract;
    step.surface = index;
    step.forward = forward;
    step.vertex_z_mm = surface.vertex_z_mm;
    step.shape = surface.shape;
    step.semi_diameter_mm = surface.semi_diameter_mm;
    step.n_in = forward ? before : behind;
    step.n_out = forward ? behind : before;
    step.absorption_per_mm = (forward ? lens.MediumBefore(index) : lens.MediumBehind(index))
                                 .AbsorptionPerMm(wavelength_nm);
    return step;
}

// Light that the sensor sends back.
Interaction SensorStep(const Lens& lens) {
    Interaction step;
    step.kind = InteractionKind::kReflect;
    step.surface = lens.sensor_index();
    step.vertex_z_mm = lens.sensor_z_mm();
    step.semi_diameter_mm = lens.sensor()->semi_diameter_mm;
    return step;
}

}  // namespace

InteractionList WriteOut(const Lens& lens, const BounceSequence& sequence, double wavelength_nm) {
    InteractionList list;
    list.sensor_z_mm = lens.sensor_z_mm();
    list.wavelength_nm = wavelength_nm;
    std::size_t next_bounce = 0;
    bool forward = true;
    const int sensor = lens.sensor_index();
    for (int at = 0;; at += forward ? 1 : -1) {
        FLARE_CHECK(at >= 0);
        const bool reflects = next_bounce < sequence.size() && sequence[next_bounce] == at;
        if (at == sensor) {
            if (!reflects) break;
            list.steps.push_back(SensorStep(lens));
            ++next_bounce;
            forward = false;
            continue;
        }
        list.steps.push_back(StepAt(lens, at, forward, reflects, wavelength_nm));
        if (list.steps.back().kind == InteractionKind::kStop) ++list.stop_crossings;
        if (reflects) {
            ++next_bounce;
            forward = !forward;
        }
    }
    FLARE_CHECK(next_bounce == sequence.size());
    return list;
}

Reflection ReflectionAt(const Lens& lens, const Interaction& step, double cos_in,
                        double wavelength_nm) {
    if (step.kind == InteractionKind::kStop) return {0.0, 1.0};
    if (step.surface == lens.sensor_index()) return {lens.sensor()->reflectance, 0.0};
    const LensSurface& surface = lens.surfaces()[static_cast<std::size_t>(step.surface)];
    const bool reversed = step.forward == surface.dense_in_front;
    return ReflectionOf(surface.coating, reversed, step.n_in, step.n_out, cos_in, wavelength_nm);
}

}  // namespace flare
