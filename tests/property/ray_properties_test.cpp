// SPDX-License-Identifier: Apache-2.0
//
// What holds for rays through any lens: the way back is the way there, a lens of another size has
// the same rays in that size, mirrored light goes mirrored, and no path gains light.
#include <gtest/gtest.h>

#include "core/tracing/trace_reference.h"
#include "tests/property/any_lens.h"

namespace flare {
namespace {

using testing::Drawn;

constexpr int kLenses = 100, kRaysEach = 20;  // at each try

BounceSequence AnySequence(Drawn& drawn, const Lens& lens) {
    const std::vector<BounceSequence> all = TwoReflectionSequences(lens);
    if (all.empty() || drawn.Below(4) == 0) return {};
    return all[static_cast<std::size_t>(drawn.Below(static_cast<int>(all.size())))];
}

Ray AnyRay(Drawn& drawn, const Lens& lens) {
    const double h = lens.surfaces().front().semi_diameter_mm;
    const Vec3d d = Vec3d(drawn.Uniform(-0.2, 0.2), drawn.Uniform(-0.2, 0.2), 1.0).normalized();
    const Vec3d at(drawn.Uniform(-h, h), drawn.Uniform(-h, h), 0.0);
    return {at - d * 60.0, d};
}

void OnceFindsItsWayBack(Drawn& drawn) {
    const auto lens = testing::AnyLens(drawn);
    const InteractionList list = WriteOut(*lens, AnySequence(drawn, *lens), 550.0);
    InteractionList reversed = list;
    reversed.steps.assign(list.steps.rbegin(), list.steps.rend());
    for (Interaction& step : reversed.steps) {
        if (step.kind == InteractionKind::kReflect) continue;
        step.forward = !step.forward;
        std::swap(step.n_in, step.n_out);
    }
    for (int k = 0; k < kRaysEach; ++k) {
        const Ray ray = AnyRay(drawn, *lens);
        const TraceResult end = TraceRay(list, ray, {}, nullptr);
        if (end.fate != RayFate::kArrived) continue;
        RayRecord record;
        const Vec3d on_sensor(end.sensor_mm.x, end.sensor_mm.y, list.sensor_z_mm);
        const TraceResult back =
            TraceRay(reversed, {on_sensor, -end.exit_direction}, {false, nullptr, true}, &record);
        RC_ASSERT(record.points.size() == list.steps.size());
        const Vec3d to_start = ray.origin - record.points.back();
        const Vec3d& d = back.exit_direction;
        RC_ASSERT((to_start - d * to_start.dot(d)).length() < 1e-8);
        RC_ASSERT((d + ray.direction).length() < 1e-8);
    }
}

Prescription Scaled(Prescription lens, double k) {
    for (SurfacePrescription& surface : lens.surfaces) {
        surface.radius_mm *= k;
        surface.radius_x_mm *= k;
        surface.radius_y_mm *= k;
        surface.gap_mm *= k;
        surface.semi_diameter_mm *= k;
        for (std::size_t n = 0; n < surface.asphere.size(); ++n) {
            surface.asphere[n] /= std::pow(k, 2.0 * static_cast<double>(n) + 3.0);
        }
    }
    return lens;
}

void OnceScalesWithTheLens(Drawn& drawn) {
    const auto lens = testing::BuildLens(
        testing::RandomPrescription(drawn, {6, drawn.Below(2) == 0, drawn.Below(2) == 0, false}));
    const double k = std::exp(drawn.Uniform(-2.0, 2.0));
    const auto other = testing::BuildLens(Scaled(lens->prescription(), k));
    const BounceSequence sequence = AnySequence(drawn, *lens);
    const InteractionList list = WriteOut(*lens, sequence, 550.0);
    const InteractionList scaled = WriteOut(*other, sequence, 550.0);
    for (int n = 0; n < kRaysEach; ++n) {
        const Ray ray = AnyRay(drawn, *lens);
        const TraceResult one = TraceRay(list, ray, {}, nullptr);
        const TraceResult same = TraceRay(scaled, {ray.origin * k, ray.direction}, {}, nullptr);
        // A ray on a rim may fall to either side.
        if (std::abs(one.max_rim_ratio2 - 1.0) < 1e-9) continue;
        RC_ASSERT(one.fate == same.fate);
        if (one.fate != RayFate::kArrived) continue;
        RC_ASSERT((same.sensor_mm - one.sensor_mm * k).length() <
                  1e-9 * k * (1.0 + one.sensor_mm.length()));
        RC_ASSERT(std::abs(same.path_mm / k - one.path_mm) < 1e-9 * std::abs(one.path_mm));
    }
}

void OnceGoesMirroredWhereItStartsMirrored(Drawn& drawn) {
    const auto lens = testing::AnyLens(drawn);
    const InteractionList list = WriteOut(*lens, AnySequence(drawn, *lens), 550.0);
    for (int n = 0; n < kRaysEach; ++n) {
        const Ray ray = AnyRay(drawn, *lens);
        const Ray mirrored{Vec3d(-ray.origin.x, ray.origin.y, ray.origin.z),
                           Vec3d(-ray.direction.x, ray.direction.y, ray.direction.z)};
        const TraceResult one = TraceRay(list, ray, {}, nullptr);
        const TraceResult other = TraceRay(list, mirrored, {}, nullptr);
        RC_ASSERT(one.fate == other.fate);
        if (one.fate != RayFate::kArrived) continue;
        RC_ASSERT((Vec2d(-one.sensor_mm.x, one.sensor_mm.y) - other.sensor_mm).length() < 1e-10);
    }
}

// Of one ray all sequences of two reflections and the direct path together carry no more than came.
void OnceNeverBringsMoreLightThanItHad(Drawn& drawn) {
    const auto lens = testing::AnyLens(drawn);
    std::vector<BounceSequence> sequences = TwoReflectionSequences(*lens);
    sequences.emplace_back();
    std::vector<InteractionList> lists;
    for (const BounceSequence& sequence : sequences) {
        lists.push_back(WriteOut(*lens, sequence, 550.0));
    }
    for (int n = 0; n < kRaysEach; ++n) {
        const Ray ray = AnyRay(drawn, *lens);
        double carried = 0.0;
        for (const InteractionList& list : lists) {
            RayRecord record;
            if (TraceRay(list, ray, {}, &record).fate != RayFate::kArrived) continue;
            const double weight = PathWeight(*lens, list, record);
            RC_ASSERT(weight >= 0.0);
            carried += weight;
        }
        RC_ASSERT(carried <= 1.0 + 1e-12);
    }
}

RC_GTEST_PROP(AnyRayThroughAnyLens, FindsItsWayBack, ()) {
    Drawn drawn;
    for (int n = 0; n < kLenses; ++n) OnceFindsItsWayBack(drawn);
}

RC_GTEST_PROP(AnyRayThroughAnyLens, ScalesWithTheLens, ()) {
    Drawn drawn;
    for (int n = 0; n < kLenses; ++n) OnceScalesWithTheLens(drawn);
}

RC_GTEST_PROP(AnyRayThroughAnyLens, GoesMirroredWhereItStartsMirrored, ()) {
    Drawn drawn;
    for (int n = 0; n < kLenses; ++n) OnceGoesMirroredWhereItStartsMirrored(drawn);
}

RC_GTEST_PROP(AnyRayThroughAnyLens, NeverBringsMoreLightThanItHad, ()) {
    Drawn drawn;
    for (int n = 0; n < kLenses; ++n) OnceNeverBringsMoreLightThanItHad(drawn);
}

}  // namespace
}  // namespace flare
