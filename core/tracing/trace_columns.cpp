// SPDX-License-Identifier: Apache-2.0
//
// Interactions are the outer loop, vectors of rays the inner one: iterations of the inner loop do
// not depend on each other, so the processor overlaps their square roots and divisions. A block of
// rays stays in the first-level cache while it goes through the lens. Lost rays are carried on with
// whatever numbers they have; their masks keep them out of the results.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/tracing/trace_columns.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h must come before highway.h.
#include <hwy/highway.h>

#include "core/tracing/trace_columns-inl.h"

#if HWY_ONCE

#include <algorithm>
#include <array>

#include "core/base/check.h"
#include "core/tracing/trace_columns.h"

namespace flare {

HWY_EXPORT(TraceBlock);
HWY_EXPORT(TargetOfBlock);

void RayColumns::Resize(std::size_t rays) {
    for (std::vector<float>* column : {&x, &y, &z, &dx, &dy, &dz}) column->resize(rays);
}

void RayColumns::Set(std::size_t ray, const Vec3d& from_first_vertex, const Vec3d& direction) {
    x[ray] = static_cast<float>(from_first_vertex.x);
    y[ray] = static_cast<float>(from_first_vertex.y);
    z[ray] = static_cast<float>(from_first_vertex.z);
    dx[ray] = static_cast<float>(direction.x);
    dy[ray] = static_cast<float>(direction.y);
    dz[ray] = static_cast<float>(direction.z);
}

namespace {

std::vector<FloatStep> FloatSteps(const InteractionList& list, const ColumnNeeds& needs) {
    std::vector<FloatStep> steps;
    double vertex = list.steps.front().vertex_z_mm;
    std::int32_t crossing = 0;
    for (std::size_t i = 0; i < list.steps.size(); ++i) {
        const Interaction& from = list.steps[i];
        FloatStep step;
        step.kind = from.kind;
        step.form = from.shape.form();
        step.flat = from.shape.flat();
        step.forward = from.forward;
        step.shift = static_cast<float>(from.vertex_z_mm - vertex);
        step.curvature_x = static_cast<float>(from.shape.curvature_x());
        step.curvature_y = static_cast<float>(from.shape.curvature_y());
        step.conic = static_cast<float>(from.shape.conic());
        const auto& even = from.shape.coefficients();
        for (std::size_t k = 0; k < even.size(); ++k) {
            step.even[k] = static_cast<float>(even[k]);
            if (even[k] != 0.0) step.terms = static_cast<std::int32_t>(k) + 1;
        }
        step.inverse_semi2 =
            static_cast<float>(1.0 / (from.semi_diameter_mm * from.semi_diameter_mm));
        step.eta = static_cast<float>(from.n_in / from.n_out);
        step.n_in = static_cast<float>(from.n_in);
        step.from_rare = from.n_in <= from.n_out;
        if (from.kind == InteractionKind::kStop) step.crossing = crossing++;
        const auto segment =
            std::find(needs.segments.begin(), needs.segments.end(), static_cast<int>(i));
        if (segment != needs.segments.end()) {
            step.segment = static_cast<std::int32_t>(segment - needs.segments.begin());
        }
        vertex = from.vertex_z_mm;
        steps.push_back(step);
    }
    return steps;
}

}  // namespace

void TraceInColumns(const InteractionList& list, const RayColumns& rays, const ColumnNeeds& needs,
                    TraceColumns& out) {
    FLARE_CHECK(!list.steps.empty());
    const std::vector<FloatStep> steps = FloatSteps(list, needs);
    const std::size_t count = rays.size();
    const std::size_t stride = (count + kBlockRays - 1) / kBlockRays * kBlockRays;
    out.rays = count;
    out.stride = stride;
    out.ended_at.resize(stride);
    out.fate.resize(stride);
    out.disorder.resize(stride);
    for (std::vector<float>* column :
         {&out.exit_x, &out.exit_y, &out.slope_x, &out.slope_y, &out.path_mm}) {
        column->resize(stride);
    }
    const auto crossings = static_cast<std::size_t>(list.stop_crossings);
    out.rim_ratio2.resize(steps.size() * stride);
    out.rare_cos2.resize(needs.passage ? steps.size() * stride : 0);
    out.stop_x.resize(crossings * stride);
    out.stop_y.resize(crossings * stride);
    out.hit_x.resize(needs.hits ? steps.size() * stride : 0);
    out.hit_y.resize(needs.hits ? steps.size() * stride : 0);
    out.segment_mm.resize(needs.segments.size() * stride);

    for (std::size_t first = 0; first < count; first += kBlockRays) {
        BlockColumns block;
        const std::size_t filled = std::min(kBlockRays, count - first);
        const std::array<const std::vector<float>*, 6> from = {&rays.x,  &rays.y,  &rays.z,
                                                               &rays.dx, &rays.dy, &rays.dz};
        for (std::size_t c = 0; c < 6; ++c) {
            const float* const source = from[c]->data() + first;
            std::copy_n(source, filled, block.state[c]);
            // The last block is filled up with its last ray.
            std::fill(block.state[c] + filled, block.state[c] + kBlockRays, source[filled - 1]);
        }
        BlockOutput output;
        output.stride = stride;
        output.ended_at = out.ended_at.data() + first;
        output.fate = out.fate.data() + first;
        output.disorder = out.disorder.data() + first;
        output.exit_x = out.exit_x.data() + first;
        output.exit_y = out.exit_y.data() + first;
        output.slope_x = out.slope_x.data() + first;
        output.slope_y = out.slope_y.data() + first;
        output.path_mm = out.path_mm.data() + first;
        // Columns that nobody asked for, or of a path without such a step, are empty.
        const auto from_first = [first](std::vector<float>& column) {
            return column.empty() ? nullptr : column.data() + first;
        };
        output.rim_ratio2 = from_first(out.rim_ratio2);
        output.rare_cos2 = from_first(out.rare_cos2);
        output.stop_x = from_first(out.stop_x);
        output.stop_y = from_first(out.stop_y);
        output.hit_x = from_first(out.hit_x);
        output.hit_y = from_first(out.hit_y);
        output.segment_mm = from_first(out.segment_mm);
        HWY_DYNAMIC_DISPATCH(TraceBlock)(steps.data(), steps.size(), block, output);
    }
}

std::string ArithmeticClass() {
    return hwy::TargetName(HWY_DYNAMIC_DISPATCH(TargetOfBlock)());
}

}  // namespace flare
#endif  // HWY_ONCE
