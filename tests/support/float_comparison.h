// SPDX-License-Identifier: Apache-2.0
//
// The tracer in floats against the reference in doubles, ray by ray, over one ghost's own pass
// region. No rim ends a ray here; where a lens would have ended it is found from the rim ratios
// that both tracers record, in the same way for both.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/mesh/pass_region.h"
#include "core/tracing/light_bundle.h"
#include "core/tracing/trace_columns.h"
#include "core/tracing/trace_reference.h"
#include "tests/support/random.h"

namespace flare::testing {

// Of a frame 36 mm wide with 1920 pixels in a row.
inline constexpr double kComparedPixel_mm = 36.0 / 1920.0;
// Beyond this distance from the axis nobody looks; a ray nearly along the sensor magnifies any
// error there.
inline constexpr double kSeen_mm = 40.0;

struct FloatComparison {
    std::vector<float> miss_px;       // of rays that pass every rim and land where they are seen
    std::vector<float> unclipped_px;  // of all that land where they are seen
    std::size_t rays = 0;
    std::size_t fates_differ = 0;  // passes the lens by one tracer and not by the other
    std::size_t ends_differ = 0;   // lost by both, but elsewhere or otherwise
    // Of the first of these the largest distance from the nearest edge of what passes: from a rim,
    // in semi-diameters, or from total reflection and grazing, in squared cosines.
    double farthest_from_edge = 0.0;

    void Add(const FloatComparison& other) {
        miss_px.insert(miss_px.end(), other.miss_px.begin(), other.miss_px.end());
        unclipped_px.insert(unclipped_px.end(), other.unclipped_px.begin(),
                            other.unclipped_px.end());
        rays += other.rays;
        fates_differ += other.fates_differ;
        ends_differ += other.ends_differ;
        farthest_from_edge = std::max(farthest_from_edge, other.farthest_from_edge);
    }
};

// The value that a share of all do not exceed; 0 of none. Sorts in part.
inline double Percentile(std::vector<float>& values, double share) {
    if (values.empty()) return 0.0;
    const auto rank = static_cast<std::size_t>(share * static_cast<double>(values.size()));
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::min(rank, values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return static_cast<double>(*at);
}

// Where a ray ended, rims and the stop's rim included.
struct RayEnd {
    RayFate fate = RayFate::kArrived;
    std::size_t step = 0;  // unless it arrived

    friend bool operator==(const RayEnd&, const RayEnd&) = default;
};

// `ratio2(s)` is the squared rim ratio at step s, of the `met` steps that the ray came to;
// `unclipped` its fate without rims.
template <class Ratio2>
RayEnd EndOf(const InteractionList& list, std::size_t met, RayFate unclipped,
             const Ratio2& ratio2) {
    for (std::size_t s = 0; s < met; ++s) {
        if (ratio2(s) <= 1.0) continue;
        const bool stop = list.steps[s].kind == InteractionKind::kStop;
        return {stop ? RayFate::kStopped : RayFate::kVignetted, s};
    }
    return {unclipped, unclipped == RayFate::kArrived ? 0 : met};
}

// Of a ray from the nearest edge of what passes.
inline double DistanceFromEdge(const InteractionList& list, const RayRecord& record) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t s = 0; s < record.rim_ratio2.size(); ++s) {
        nearest = std::min(nearest, std::abs(std::sqrt(record.rim_ratio2[s]) - 1.0));
        const Interaction& step = list.steps[s];
        if (step.kind == InteractionKind::kStop) continue;
        const double cos2 = record.cos_in[s] * record.cos_in[s];
        const double eta = step.n_in / step.n_out;
        nearest = std::min({nearest, cos2, std::abs(1.0 - eta * eta * (1.0 - cos2))});
    }
    return nearest;
}

class FloatTracerComparison {
  public:
    FloatTracerComparison(const Lens& lens, const LightBundle& bundle)
        : lens_(lens), bundle_(bundle) {}

    // The random rays of a ghost follow from `seed`. Nothing where no ray passes.
    FloatComparison Compare(const BounceSequence& sequence, std::size_t rays,
                            std::uint64_t seed) const {
        FloatComparison found;
        InteractionList list = WriteOut(lens_, sequence, kLineD);
        const PassRegion region = FindPassRegion({list}, bundle_);
        if (!region.rect) return found;
        list.sensor_z_mm = lens_.surfaces().back().vertex_z_mm;
        const Rect& r = *region.rect;
        testing::Random random(seed);
        constexpr std::size_t kBlock = 4096;
        for (std::size_t first = 0; first < rays; first += kBlock) {
            RayColumns columns;
            columns.Resize(std::min(kBlock, rays - first));
            std::vector<Ray> exact;
            for (std::size_t k = 0; k < columns.size(); ++k) {
                const double u = random.Uniform(r.u0, r.u1);
                exact.push_back(bundle_.AtFront(u, random.Uniform(r.v0, r.v1)));
                columns.Set(k, exact[k].origin, exact[k].direction);
            }
            CompareBlock(list, columns, exact, found);
        }
        return found;
    }

  private:
    void CompareBlock(const InteractionList& list, const RayColumns& columns,
                      const std::vector<Ray>& exact, FloatComparison& found) const {
        TraceColumns out;
        TraceInColumns(list, columns, {}, out);
        TraceOptions options;
        options.clip = false;
        RayRecord record;
        for (std::size_t k = 0; k < exact.size(); ++k) {
            const TraceResult wanted = TraceRay(list, exact[k], options, &record);
            const auto unclipped = static_cast<RayFate>(out.fate[k]);
            const std::size_t met = out.ended_at[k] == TraceColumns::kArrived
                                        ? list.steps.size()
                                        : static_cast<std::size_t>(out.ended_at[k]);
            const std::size_t met_exactly =
                wanted.ended_at < 0 ? list.steps.size() : static_cast<std::size_t>(wanted.ended_at);
            const RayEnd end = EndOf(list, met, unclipped, [&](std::size_t s) {
                return static_cast<double>(out.rim_ratio2[s * out.stride + k]);
            });
            const auto exact_ratio2 = [&](std::size_t s) { return record.rim_ratio2[s]; };
            const RayEnd exact_end = EndOf(list, met_exactly, wanted.fate, exact_ratio2);
            ++found.rays;
            if ((end.fate == RayFate::kArrived) == (exact_end.fate == RayFate::kArrived)) {
                if (!(end == exact_end)) ++found.ends_differ;
            } else {
                ++found.fates_differ;
                found.farthest_from_edge =
                    std::max(found.farthest_from_edge, DistanceFromEdge(list, record));
            }
            if (unclipped != RayFate::kArrived || wanted.fate != RayFate::kArrived) continue;
            const double gap = lens_.sensor_gap_mm();
            const Vec3d& d = wanted.exit_direction;
            const Vec2d place = wanted.sensor_mm + Vec2d(d.x / d.z, d.y / d.z) * gap;
            if (!(place.length() <= kSeen_mm)) continue;
            const Vec2d got =
                Vec2d(static_cast<double>(out.exit_x[k]), static_cast<double>(out.exit_y[k])) +
                Vec2d(static_cast<double>(out.slope_x[k]), static_cast<double>(out.slope_y[k])) *
                    gap;
            const auto miss_px = static_cast<float>((got - place).length() / kComparedPixel_mm);
            found.unclipped_px.push_back(miss_px);
            if (exact_end.fate == RayFate::kArrived) found.miss_px.push_back(miss_px);
        }
    }

    const Lens& lens_;
    const LightBundle& bundle_;
};

}  // namespace flare::testing
