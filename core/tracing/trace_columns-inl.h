// SPDX-License-Identifier: Apache-2.0
//
// The kernel of trace_columns.cpp, compiled once for each instruction set. Formulas are those of
// surface_hit.cpp and trace_reference.cpp, under the same names.

// ---- Plain data, once ----
#ifndef FLARE_TRACE_COLUMNS_PLAIN_
#define FLARE_TRACE_COLUMNS_PLAIN_

#include <cstddef>
#include <cstdint>

#include "core/optics/surface_shape.h"
#include "core/tracing/interaction_list.h"

namespace flare {

// A multiple of every vector's lanes; six columns of state take 6 KiB.
inline constexpr std::size_t kBlockRays = 256;

// Two hits count as in order if the second lies no more than this before the first: floats at
// surfaces that touch.
inline constexpr float kFloatOrderTolerance_mm = 2e-5F;

struct FloatStep {
    InteractionKind kind = InteractionKind::kRefract;
    SurfaceForm form = SurfaceForm::kQuadric;
    bool flat = false, forward = true, from_rare = true;
    float shift = 0.0F;  // from the vertex before, mm
    float curvature_x = 0.0F, curvature_y = 0.0F, conic = 0.0F;
    float even[SurfaceShape::kMostCoefficients] = {};
    std::int32_t terms = 0;  // of `even` that are not 0
    float inverse_semi2 = 0.0F;
    float eta = 1.0F, n_in = 1.0F;
    std::int32_t crossing = -1, segment = -1;  // which of them this is; -1: none
};

struct BlockColumns {
    alignas(64) float state[6][kBlockRays];  // x, y, z, dx, dy, dz
};

struct BlockOutput {
    std::size_t stride = 0;
    std::int32_t* ended_at = nullptr;
    std::uint8_t *fate = nullptr, *disorder = nullptr;
    float *exit_x = nullptr, *exit_y = nullptr, *slope_x = nullptr, *slope_y = nullptr;
    float* path_mm = nullptr;
    float *rim_ratio2 = nullptr, *rare_cos2 = nullptr;
    float *stop_x = nullptr, *stop_y = nullptr;
    float *hit_x = nullptr, *hit_y = nullptr;
    float* segment_mm = nullptr;
};

}  // namespace flare
#endif  // FLARE_TRACE_COLUMNS_PLAIN_

// ---- The kernel, once a target ----
#if defined(FLARE_TRACE_COLUMNS_INL_) == defined(HWY_TARGET_TOGGLE)
#ifdef FLARE_TRACE_COLUMNS_INL_
#undef FLARE_TRACE_COLUMNS_INL_
#else
#define FLARE_TRACE_COLUMNS_INL_
#endif

#include <hwy/highway.h>

#include "core/tracing/ray_fate.h"

HWY_BEFORE_NAMESPACE();
namespace flare {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::ScalableTag<float>;
using V = hn::Vec<Floats>;
using M = hn::Mask<Floats>;

struct V3 {
    V x, y, z;
};

HWY_INLINE V Constant(float value) {
    return hn::Set(Floats(), value);
}

HWY_INLINE V Dot(const V3& a, const V3& b) {
    return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}

// a + b s
HWY_INLINE V3 Along(const V3& a, const V3& b, V s) {
    return {hn::MulAdd(b.x, s, a.x), hn::MulAdd(b.y, s, a.y), hn::MulAdd(b.z, s, a.z)};
}

struct VHit {
    M met;
    V distance, cosine;
    V3 point, normal;
};

// The root of A t^2 - 2 G t + F = 0 where G - A t = s sqrt(G^2 - A F).
struct VRoot {
    M real;
    V t, crossing;
};

HWY_INLINE VRoot Solve(V a, V g, V f, bool forward) {
    const V zero = hn::Zero(Floats());
    const V discriminant = hn::NegMulAdd(a, f, hn::Mul(g, g));
    const V size = hn::Sqrt(hn::Max(discriminant, zero));
    const V crossing = forward ? size : hn::Neg(size);
    // Of the two forms of the root the one that adds numbers of equal sign.
    const M same = hn::Ge(hn::Mul(g, crossing), zero);
    const V denominator = hn::IfThenElse(same, hn::Add(g, crossing), a);
    const V numerator = hn::IfThenElse(same, f, hn::Sub(g, crossing));
    const M real = hn::And(hn::Ge(discriminant, zero), hn::Ne(denominator, zero));
    return {real, hn::Div(numerator, denominator), crossing};
}

HWY_INLINE VHit MeetPlane(bool forward, const V3& p, const V3& d) {
    const V zero = hn::Zero(Floats());
    VHit hit;
    hit.met = forward ? hn::Gt(d.z, zero) : hn::Lt(d.z, zero);
    hit.distance = hn::Neg(hn::Div(p.z, d.z));
    hit.point = Along(p, d, hit.distance);
    hit.point.z = zero;
    hit.normal = {zero, zero, Constant(1.0F)};
    hit.cosine = d.z;
    return hit;
}

HWY_INLINE VHit MeetQuadric(float curvature, float conic, bool forward, const V3& p, const V3& d) {
    const V c = Constant(curvature);
    const V k1 = Constant(1.0F + conic);
    const V t0 = hn::Neg(Dot(p, d));
    const V3 q = Along(p, d, t0);
    const V k1z = hn::Mul(k1, q.z);
    const V qd = hn::MulAdd(q.x, d.x, hn::MulAdd(q.y, d.y, hn::Mul(k1z, d.z)));
    const V qq = hn::MulAdd(q.x, q.x, hn::MulAdd(q.y, q.y, hn::Mul(k1z, q.z)));
    const V g = hn::NegMulAdd(c, qd, d.z);
    const V f = hn::MulSub(c, qq, hn::Add(q.z, q.z));
    V a = c;
    if (conic != 0.0F) {
        a = hn::Mul(c, hn::MulAdd(Constant(conic), hn::Mul(d.z, d.z), Constant(1.0F)));
    }
    const VRoot root = Solve(a, g, f, forward);
    VHit hit;
    hit.distance = hn::Add(t0, root.t);
    hit.point = Along(q, d, root.t);
    hit.normal = {hn::Neg(hn::Mul(c, hit.point.x)), hn::Neg(hn::Mul(c, hit.point.y)),
                  hn::NegMulAdd(hn::Mul(c, k1), hit.point.z, Constant(1.0F))};
    hit.cosine = root.crossing;
    hit.met = hn::And(root.real, hn::Gt(hit.normal.z, hn::Zero(Floats())));
    if (conic != 0.0F) {
        const V scale = hn::Div(Constant(1.0F), hn::Sqrt(Dot(hit.normal, hit.normal)));
        hit.normal = {hn::Mul(hit.normal.x, scale), hn::Mul(hit.normal.y, scale),
                      hn::Mul(hit.normal.z, scale)};
        hit.cosine = hn::Mul(hit.cosine, scale);
    }
    return hit;
}

HWY_INLINE VHit MeetCylinder(float curvature, bool along_x, bool forward, const V3& p,
                             const V3& d) {
    const V c = Constant(curvature);
    const V pa = along_x ? p.x : p.y;
    const V da = along_x ? d.x : d.y;
    const V along2 = hn::MulAdd(da, da, hn::Mul(d.z, d.z));
    const V t0 = hn::Neg(hn::Div(hn::MulAdd(pa, da, hn::Mul(p.z, d.z)), along2));
    const V3 q = Along(p, d, t0);
    const V qa = along_x ? q.x : q.y;
    const V g = hn::NegMulAdd(c, hn::MulAdd(qa, da, hn::Mul(q.z, d.z)), d.z);
    const V f = hn::MulSub(c, hn::MulAdd(qa, qa, hn::Mul(q.z, q.z)), hn::Add(q.z, q.z));
    const VRoot root = Solve(hn::Mul(c, along2), g, f, forward);
    VHit hit;
    hit.distance = hn::Add(t0, root.t);
    hit.point = Along(q, d, root.t);
    const V across = hn::Neg(hn::Mul(c, along_x ? hit.point.x : hit.point.y));
    const V zero = hn::Zero(Floats());
    hit.normal = {along_x ? across : zero, along_x ? zero : across,
                  hn::NegMulAdd(c, hit.point.z, Constant(1.0F))};
    hit.cosine = root.crossing;
    hit.met = hn::And(hn::And(root.real, hn::Gt(hit.normal.z, zero)), hn::Gt(along2, zero));
    return hit;
}

// Sag and its slope; `inside` where the formula has a value.
struct VSag {
    M inside;
    V sag, slope_x, slope_y;
};

HWY_INLINE VSag SagOf(const FloatStep& step, V x, V y) {
    const V zero = hn::Zero(Floats());
    const V one = Constant(1.0F);
    VSag out;
    if (step.form == SurfaceForm::kAsphere) {
        const V c = Constant(step.curvature_x);
        const V q = hn::MulAdd(x, x, hn::Mul(y, y));
        const V k1c2 = Constant((1.0F + step.conic) * step.curvature_x * step.curvature_x);
        const V radicand = hn::NegMulAdd(k1c2, q, one);
        out.inside = hn::Gt(radicand, zero);
        const V root = hn::Sqrt(hn::Max(radicand, zero));
        V value = zero;
        V derivative = zero;
        for (std::int32_t k = step.terms - 1; k >= 0; --k) {
            derivative = hn::MulAdd(derivative, q, value);
            value = hn::MulAdd(value, q, Constant(step.even[k]));
        }
        const V qq = hn::Mul(q, q);
        const V poly_slope = hn::MulAdd(qq, derivative, hn::Mul(hn::Add(q, q), value));
        out.sag = hn::MulAdd(value, qq, hn::Div(hn::Mul(c, q), hn::Add(one, root)));
        const V by = hn::Add(hn::Div(c, root), hn::Add(poly_slope, poly_slope));
        out.slope_x = hn::Mul(by, x);
        out.slope_y = hn::Mul(by, y);
        return out;
    }
    const V cx = Constant(step.curvature_x);
    const V cy = Constant(step.curvature_y);
    const V ax = hn::Mul(cx, x);
    const V ay = hn::Mul(cy, y);
    const V radicand = hn::NegMulAdd(ax, ax, hn::NegMulAdd(ay, ay, one));
    out.inside = hn::Gt(radicand, zero);
    const V root = hn::Sqrt(hn::Max(radicand, zero));
    const V d = hn::Add(one, root);
    const V n = hn::MulAdd(ax, x, hn::Mul(ay, y));
    out.sag = hn::Div(n, d);
    const V shared = hn::Div(n, hn::Mul(root, hn::Mul(d, d)));
    const V twice = hn::Div(Constant(2.0F), d);
    out.slope_x = hn::Mul(ax, hn::MulAdd(shared, cx, twice));
    out.slope_y = hn::Mul(ay, hn::MulAdd(shared, cy, twice));
    return out;
}

// Newton from the conic, or from the sphere between a toroid's curvatures.
HWY_INLINE VHit MeetSag(const FloatStep& step, const V3& p, const V3& d) {
    constexpr int kSteps = 6;
    const V zero = hn::Zero(Floats());
    const float mean = 0.5F * (step.curvature_x + step.curvature_y);
    const VHit near = MeetQuadric(mean, step.conic, step.forward, p, d);
    const V plane = hn::Neg(hn::Div(p.z, d.z));
    V t = hn::IfThenElse(near.met, near.distance, plane);
    VSag sag = SagOf(step, p.x, p.y);
    V rate = zero;
    V height = zero;
    for (int i = 0; i <= kSteps; ++i) {
        const V3 q = Along(p, d, t);
        sag = SagOf(step, q.x, q.y);
        height = hn::Sub(q.z, sag.sag);
        rate = hn::NegMulAdd(sag.slope_x, d.x, hn::NegMulAdd(sag.slope_y, d.y, d.z));
        if (i == kSteps) break;
        const M good = hn::And(sag.inside, hn::Gt(hn::Abs(rate), Constant(1e-6F)));
        t = hn::Sub(t, hn::IfThenElseZero(good, hn::Div(height, rate)));
    }
    VHit hit;
    hit.distance = t;
    hit.point = Along(p, d, t);
    const V scale = hn::Div(
        Constant(1.0F), hn::Sqrt(hn::MulAdd(sag.slope_x, sag.slope_x,
                                            hn::MulAdd(sag.slope_y, sag.slope_y, Constant(1.0F)))));
    hit.normal = {hn::Neg(hn::Mul(sag.slope_x, scale)), hn::Neg(hn::Mul(sag.slope_y, scale)),
                  scale};
    hit.cosine = hn::Mul(rate, scale);
    const M right_way = step.forward ? hn::Gt(rate, zero) : hn::Lt(rate, zero);
    const M settled = hn::Lt(hn::Abs(height), Constant(5e-5F));
    hit.met = hn::And(hn::And(sag.inside, right_way), settled);
    return hit;
}

HWY_INLINE VHit Meet(const FloatStep& step, const V3& p, const V3& d) {
    if (step.flat) return MeetPlane(step.forward, p, d);
    switch (step.form) {
        case SurfaceForm::kCylinderX:
            return MeetCylinder(step.curvature_x, true, step.forward, p, d);
        case SurfaceForm::kCylinderY:
            return MeetCylinder(step.curvature_y, false, step.forward, p, d);
        case SurfaceForm::kAsphere:
        case SurfaceForm::kToroid:
            return MeetSag(step, p, d);
        case SurfaceForm::kQuadric:
            break;
    }
    return MeetQuadric(step.curvature_x, step.conic, step.forward, p, d);
}

// What a block keeps for each ray between interactions, besides its place and direction.
struct BlockMemory {
    alignas(64) float ended[kBlockRays];     // -1, or the interaction where it was lost
    alignas(64) float fate[kBlockRays];      // of lost rays
    alignas(64) float disorder[kBlockRays];  // 0, 1, 2
    alignas(64) float widest[kBlockRays];    // largest rim ratio so far
    alignas(64) float path[kBlockRays];
};

HWY_INLINE void OneStep(const FloatStep& step, std::size_t index, BlockColumns& block,
                        BlockMemory& memory, const BlockOutput& out) {
    const Floats tag;
    const V zero = hn::Zero(tag);
    const V shift = Constant(step.shift);
    const std::size_t row = index * out.stride;
    for (std::size_t k = 0; k < kBlockRays; k += hn::Lanes(tag)) {
        const V3 p = {hn::Load(tag, block.state[0] + k), hn::Load(tag, block.state[1] + k),
                      hn::Sub(hn::Load(tag, block.state[2] + k), shift)};
        V3 d = {hn::Load(tag, block.state[3] + k), hn::Load(tag, block.state[4] + k),
                hn::Load(tag, block.state[5] + k)};
        V ended = hn::Load(tag, memory.ended + k);
        const M alive = hn::Lt(ended, zero);

        const VHit hit = Meet(step, p, d);
        const V at = Constant(static_cast<float>(index));
        V fate = hn::Load(tag, memory.fate + k);
        M lost = hn::AndNot(hit.met, alive);
        fate = hn::IfThenElse(lost, Constant(static_cast<float>(RayFate::kMissed)), fate);

        const V ratio2 =
            hn::Mul(hn::MulAdd(hit.point.x, hit.point.x, hn::Mul(hit.point.y, hit.point.y)),
                    Constant(step.inverse_semi2));
        hn::StoreU(ratio2, tag, out.rim_ratio2 + row + k);
        V widest = hn::Load(tag, memory.widest + k);
        if (step.kind != InteractionKind::kStop) widest = hn::Max(widest, ratio2);
        hn::Store(widest, tag, memory.widest + k);
        if (index > 0) {
            const M before = hn::And(hn::And(alive, hit.met),
                                     hn::Lt(hit.distance, Constant(-kFloatOrderTolerance_mm)));
            const V how =
                hn::IfThenElse(hn::Le(widest, Constant(1.0F)), Constant(2.0F), Constant(1.0F));
            const V disorder = hn::Load(tag, memory.disorder + k);
            hn::Store(hn::Max(disorder, hn::IfThenElseZero(before, how)), tag, memory.disorder + k);
        }
        hn::Store(hn::MulAdd(Constant(step.n_in), hit.distance, hn::Load(tag, memory.path + k)),
                  tag, memory.path + k);
        if (step.segment >= 0) {
            const std::size_t column = static_cast<std::size_t>(step.segment) * out.stride;
            hn::StoreU(hit.distance, tag, out.segment_mm + column + k);
        }
        if (out.hit_x != nullptr) {
            hn::StoreU(hit.point.x, tag, out.hit_x + row + k);
            hn::StoreU(hit.point.y, tag, out.hit_y + row + k);
        }

        if (step.kind == InteractionKind::kStop) {
            const std::size_t column = static_cast<std::size_t>(step.crossing) * out.stride;
            hn::StoreU(hit.point.x, tag, out.stop_x + column + k);
            hn::StoreU(hit.point.y, tag, out.stop_y + column + k);
            if (out.rare_cos2 != nullptr) {
                hn::StoreU(Constant(1.0F), tag, out.rare_cos2 + row + k);
            }
        } else {
            const V3 across = Along(d, hit.normal, hn::Neg(hit.cosine));
            const V eta = Constant(step.eta);
            const V sin2_out = hn::Mul(hn::Mul(eta, eta), Dot(across, across));
            const V cos2_out = hn::Sub(Constant(1.0F), sin2_out);
            if (out.rare_cos2 != nullptr) {
                const V rare = step.from_rare ? hn::Mul(hit.cosine, hit.cosine) : cos2_out;
                hn::StoreU(rare, tag, out.rare_cos2 + row + k);
            }
            if (step.kind == InteractionKind::kReflect) {
                d = Along(d, hit.normal, hn::Mul(Constant(-2.0F), hit.cosine));
            } else {
                const M total = hn::And(hn::AndNot(lost, alive), hn::Le(cos2_out, zero));
                fate = hn::IfThenElse(total, Constant(static_cast<float>(RayFate::kTir)), fate);
                lost = hn::Or(lost, total);
                const V size = hn::Sqrt(hn::Max(cos2_out, zero));
                const V cosine = hn::CopySign(size, hit.cosine);
                d = {hn::MulAdd(eta, across.x, hn::Mul(cosine, hit.normal.x)),
                     hn::MulAdd(eta, across.y, hn::Mul(cosine, hit.normal.y)),
                     hn::MulAdd(eta, across.z, hn::Mul(cosine, hit.normal.z))};
            }
            // Back to unit length: one step of Newton's method, its length being so near to 1.
            const V scale = hn::NegMulAdd(Constant(0.5F), Dot(d, d), Constant(1.5F));
            d = {hn::Mul(d.x, scale), hn::Mul(d.y, scale), hn::Mul(d.z, scale)};
        }
        ended = hn::IfThenElse(lost, at, ended);
        hn::Store(ended, tag, memory.ended + k);
        hn::Store(fate, tag, memory.fate + k);
        hn::Store(hit.point.x, tag, block.state[0] + k);
        hn::Store(hit.point.y, tag, block.state[1] + k);
        hn::Store(hit.point.z, tag, block.state[2] + k);
        hn::Store(d.x, tag, block.state[3] + k);
        hn::Store(d.y, tag, block.state[4] + k);
        hn::Store(d.z, tag, block.state[5] + k);
    }
}

// To the tangent plane of the last vertex; a ray that goes back towards the scene is lost.
HWY_INLINE void Leave(const BlockColumns& block, BlockMemory& memory, const BlockOutput& out) {
    const Floats tag;
    for (std::size_t k = 0; k < kBlockRays; k += hn::Lanes(tag)) {
        const V dz = hn::Load(tag, block.state[5] + k);
        const V inverse = hn::Div(Constant(1.0F), dz);
        const V slope_x = hn::Mul(hn::Load(tag, block.state[3] + k), inverse);
        const V slope_y = hn::Mul(hn::Load(tag, block.state[4] + k), inverse);
        const V z = hn::Load(tag, block.state[2] + k);
        hn::StoreU(hn::NegMulAdd(z, slope_x, hn::Load(tag, block.state[0] + k)), tag,
                   out.exit_x + k);
        hn::StoreU(hn::NegMulAdd(z, slope_y, hn::Load(tag, block.state[1] + k)), tag,
                   out.exit_y + k);
        hn::StoreU(slope_x, tag, out.slope_x + k);
        hn::StoreU(slope_y, tag, out.slope_y + k);
        hn::StoreU(hn::NegMulAdd(z, inverse, hn::Load(tag, memory.path + k)), tag, out.path_mm + k);
    }
    for (std::size_t k = 0; k < kBlockRays; ++k) {
        const bool arrived = memory.ended[k] < 0.0F && block.state[5][k] > 0.0F;
        out.ended_at[k] = static_cast<std::int32_t>(memory.ended[k]);
        out.fate[k] = memory.ended[k] < 0.0F ? static_cast<std::uint8_t>(arrived ? RayFate::kArrived
                                                                                 : RayFate::kMissed)
                                             : static_cast<std::uint8_t>(memory.fate[k]);
        out.disorder[k] = static_cast<std::uint8_t>(memory.disorder[k]);
    }
}

void TraceBlock(const FloatStep* steps, std::size_t count, BlockColumns& block,
                const BlockOutput& out) {
    BlockMemory memory;
    for (std::size_t k = 0; k < kBlockRays; ++k) {
        memory.ended[k] = -1.0F;
        memory.fate[k] = memory.disorder[k] = memory.widest[k] = memory.path[k] = 0.0F;
    }
    for (std::size_t index = 0; index < count; ++index) {
        OneStep(steps[index], index, block, memory, out);
    }
    Leave(block, memory, out);
}

std::int64_t TargetOfBlock() {
    return HWY_TARGET;
}

}  // namespace HWY_NAMESPACE
}  // namespace flare
HWY_AFTER_NAMESPACE();

#endif  // per target
