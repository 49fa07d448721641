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
    step.curvature = surface.curvature;
    step.semi_diameter_mm = surface.semi_diameter_mm;
    step.n_in = forward ? before : behind;
    step.n_out = forward ? behind : before;
    return step;
}

}  // namespace

InteractionList WriteOut(const Lens& lens, const BounceSequence& sequence, double wavelength_nm) {
    InteractionList list;
    list.sensor_z_mm = lens.sensor_z_mm();
    list.wavelength_nm = wavelength_nm;
    const int count = static_cast<int>(lens.surfaces().size());
    std::size_t next_bounce = 0;
    bool forward = true;
    for (int at = 0; at < count; at += forward ? 1 : -1) {
        FLARE_CHECK(at >= 0);
        const bool reflects = next_bounce < sequence.size() && sequence[next_bounce] == at;
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
    const LensSurface& surface = lens.surfaces()[static_cast<std::size_t>(step.surface)];
    const bool reversed = step.forward == surface.dense_in_front;
    return ReflectionOf(surface.coating, reversed, step.n_in, step.n_out, cos_in, wavelength_nm);
}

}  // namespace flare
