// SPDX-License-Identifier: Apache-2.0
//
// The SIMD tracer in floats against the reference tracer in doubles, ray by ray.
#include "core/tracing/trace_columns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/mesh/pass_region.h"
#include "core/tracing/light_bundle.h"
#include "tests/support/lenses.h"
#include "tests/support/random.h"

namespace flare {
namespace {

constexpr double kPixel_mm = 36.0 / 1920.0;

struct Case {
    const char* name;
    double allowed_px;  // p99.9 over the rays of all ghosts
};

class FloatTracer : public ::testing::TestWithParam<Case> {};

// Rays over each ghost's own pass region; compared are those that pass all rims.
TEST_P(FloatTracer, LandsWhereTheReferenceLands) {
    const auto lens = testing::LibraryLens(GetParam().name)->WithBareGlass();
    const LightBundle bundle(*lens, RadiansFromDegrees(5.0), 0.0, lens->rotational() ? 0.0 : 0.5);
    const std::vector<BounceSequence> sequences = TwoReflectionSequences(*lens);
    const std::size_t every = std::max<std::size_t>(1, sequences.size() / 60);
    testing::Random random(7);
    std::vector<double> miss_px;
    std::size_t fates = 0, differ = 0;
    TraceColumns out;
    for (std::size_t n = 0; n < sequences.size(); n += every) {
        InteractionList list = WriteOut(*lens, sequences[n], kLineD);
        const PassRegion region = FindPassRegion({list}, bundle);
        if (!region.rect) continue;
        RayColumns rays;
        rays.Resize(500);
        std::vector<Ray> exact;
        for (std::size_t k = 0; k < rays.size(); ++k) {
            exact.push_back(bundle.AtFront(random.Uniform(region.rect->u0, region.rect->u1),
                                           random.Uniform(region.rect->v0, region.rect->v1)));
            rays.Set(k, exact[k].origin, exact[k].direction);
        }
        TraceInColumns(list, rays, {}, out);
        list.sensor_z_mm = lens->surfaces().back().vertex_z_mm;
        TraceOptions options;
        options.clip = false;
        RayRecord record;
        for (std::size_t k = 0; k < exact.size(); ++k) {
            const TraceResult wanted = TraceRay(list, exact[k], options, &record);
            const bool lives = static_cast<RayFate>(out.fate[k]) == RayFate::kArrived;
            ++fates;
            if (lives != (wanted.fate == RayFate::kArrived)) ++differ;
            if (!lives || wanted.fate != RayFate::kArrived || wanted.max_rim_ratio2 > 1.0) continue;
            const double gap = lens->sensor_gap_mm();
            const Vec3d& d = wanted.exit_direction;
            // Far off the picture a ray nearly along the sensor magnifies any error.
            if (std::hypot(wanted.sensor_mm.x + gap * d.x / d.z,
                           wanted.sensor_mm.y + gap * d.y / d.z) > 40.0) {
                continue;
            }
            miss_px.push_back(
                std::hypot(static_cast<double>(out.exit_x[k]) - wanted.sensor_mm.x +
                               gap * (static_cast<double>(out.slope_x[k]) - d.x / d.z),
                           static_cast<double>(out.exit_y[k]) - wanted.sensor_mm.y +
                               gap * (static_cast<double>(out.slope_y[k]) - d.y / d.z)) /
                kPixel_mm);
            // What the masks and the weights are made of.
            for (std::size_t s = 0; s < list.steps.size(); ++s) {
                EXPECT_NEAR(static_cast<double>(out.rim_ratio2[s * out.stride + k]),
                            record.rim_ratio2[s], 2e-4 * (1.0 + record.rim_ratio2[s]));
            }
            EXPECT_NEAR(static_cast<double>(out.path_mm[k]), wanted.path_mm, 1e-2);
        }
    }
    ASSERT_GT(miss_px.size(), 1000U);
    std::sort(miss_px.begin(), miss_px.end());
    const double p999 = miss_px[miss_px.size() * 999 / 1000];
    RecordProperty("p999_px", std::to_string(p999));
    EXPECT_LT(p999, GetParam().allowed_px);
    EXPECT_LT(static_cast<double>(differ), 1e-4 * static_cast<double>(fates) + 1.0);
}

INSTANTIATE_TEST_SUITE_P(Library, FloatTracer,
                         ::testing::Values(Case{"tronnier-double-gauss-50mm-f2", 0.02},
                                           Case{"zeiss-master-prime-50mm-t1_3", 0.02},
                                           Case{"angenieux-double-gauss-50mm-f1_1", 0.02},
                                           Case{"canon-rf-85mm-f1_2", 0.02},  // aspheres
                                           Case{"schneider-anamorphic-31mm-f2",
                                                0.02},  // cylinders, skew light
                                           Case{"canon-zoom-70-200mm-f2_8", 0.02},
                                           Case{"kreitzer-telephoto-400mm-f5_6", 0.05},
                                           Case{"shimizu-fisheye-6mm-f2_8-220deg", 0.05}),
                         [](const auto& tested) {
                             std::string name = tested.param.name;
                             std::replace_if(
                                 name.begin(), name.end(),
                                 [](char c) { return c == '-' || c == '.'; }, '_');
                             return name;
                         });

// A toroid and a reflecting sensor occur in no library lens.
TEST(FloatTracer, KnowsEverySurfaceKind) {
    testing::Random random(8);
    for (const SurfaceShape& shape :
         {SurfaceShape::Toroid(0.02, -0.01), SurfaceShape::CylinderX(0.03),
          SurfaceShape::CylinderY(-0.02), SurfaceShape::Asphere(0.02, -1.5, {1e-5, -2e-8}),
          SurfaceShape::Asphere(0.03, 0.4, {}), SurfaceShape::Sphere(-0.015), SurfaceShape()}) {
        InteractionList list;
        Interaction step;
        step.shape = shape;
        step.semi_diameter_mm = 10.0;
        step.n_out = 1.6;
        list.steps.push_back(step);
        list.sensor_z_mm = 0.0;
        RayColumns rays;
        rays.Resize(300);
        std::vector<Ray> exact;
        for (std::size_t k = 0; k < rays.size(); ++k) {
            const Vec3d d =
                Vec3d(random.Uniform(-0.4, 0.4), random.Uniform(-0.4, 0.4), 1.0).normalized();
            exact.push_back({Vec3d(random.Uniform(-8.0, 8.0), random.Uniform(-8.0, 8.0), -3.0), d});
            rays.Set(k, exact[k].origin, d);
        }
        TraceColumns out;
        ColumnNeeds needs;
        needs.hits = true;
        TraceInColumns(list, rays, needs, out);
        TraceOptions options;
        options.clip = false;
        options.record_points = true;
        RayRecord record;
        int met = 0;
        for (std::size_t k = 0; k < exact.size(); ++k) {
            const TraceResult wanted = TraceRay(list, exact[k], options, &record);
            ASSERT_EQ(static_cast<RayFate>(out.fate[k]), wanted.fate);
            if (wanted.fate != RayFate::kArrived) continue;
            ++met;
            EXPECT_NEAR(static_cast<double>(out.hit_x[k]), record.points[0].x, 1e-5);
            EXPECT_NEAR(static_cast<double>(out.hit_y[k]), record.points[0].y, 1e-5);
            const Vec3d& d = wanted.exit_direction;
            EXPECT_NEAR(static_cast<double>(out.slope_x[k]), d.x / d.z, 1e-6);
            EXPECT_NEAR(static_cast<double>(out.slope_y[k]), d.y / d.z, 1e-6);
            EXPECT_NEAR(static_cast<double>(out.rare_cos2[k]), record.cos_in[0] * record.cos_in[0],
                        1e-5);
        }
        EXPECT_GT(met, 250);
    }
}

TEST(FloatTracer, FillsTheLastBlockWithoutTouchingOtherRays) {
    const auto lens = testing::LibraryLens(testing::kSeedName);
    const LightBundle bundle(*lens, 0.05, 0.0);
    const InteractionList list = WriteOut(*lens, {8, 4}, kLineD);
    RayColumns many, few;
    many.Resize(700);
    few.Resize(13);
    for (std::size_t k = 0; k < 700; ++k) {
        const Ray ray = bundle.AtFront(0.01 * static_cast<double>(k), 0.5);
        many.Set(k, ray.origin, ray.direction);
        if (k < 13) few.Set(k, ray.origin, ray.direction);
    }
    TraceColumns a, b;
    TraceInColumns(list, many, {}, a);
    TraceInColumns(list, few, {}, b);
    for (std::size_t k = 0; k < 13; ++k) {
        EXPECT_EQ(a.exit_x[k], b.exit_x[k]);
        EXPECT_EQ(a.slope_y[k], b.slope_y[k]);
    }
    EXPECT_FALSE(ArithmeticClass().empty());
}

}  // namespace
}  // namespace flare
