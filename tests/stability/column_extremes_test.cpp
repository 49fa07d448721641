// SPDX-License-Identifier: Apache-2.0
//
// The tracer in floats at the edge of what geometry allows: the fates of the reference, finite
// numbers, and no digit lost that a float can keep.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"
#include "core/tracing/trace_columns.h"
#include "core/tracing/trace_reference.h"
#include "tests/support/extreme_lenses.h"
#include "tests/support/interaction_list.h"
#include "tests/support/random.h"

namespace flare {
namespace {

using testing::ListOf;

Interaction Surface(double radius_mm, double n_in, double n_out) {
    Interaction step;
    step.shape = SurfaceShape::Sphere(radius_mm == 0.0 ? 0.0 : 1.0 / radius_mm);
    step.semi_diameter_mm = 1e6;
    step.n_in = n_in;
    step.n_out = n_out;
    return step;
}

TraceColumns TraceAll(const InteractionList& list, const std::vector<Ray>& rays) {
    RayColumns columns;
    columns.Resize(rays.size());
    for (std::size_t k = 0; k < rays.size(); ++k) {
        columns.Set(k, rays[k].origin, rays[k].direction);
    }
    TraceColumns out;
    ColumnNeeds needs;
    needs.hits = true;
    TraceInColumns(list, columns, needs, out);
    return out;
}

bool Finite(const TraceColumns& out, std::size_t k) {
    return std::isfinite(out.exit_x[k]) && std::isfinite(out.exit_y[k]) &&
           std::isfinite(out.slope_x[k]) && std::isfinite(out.slope_y[k]) &&
           std::isfinite(out.path_mm[k]);
}

const Vec3d kAlong(0.0, 0.0, 1.0);

TEST(AColumnOfGrazingRays, IsMissedBeyondTheSphereAndFiniteOnIt) {
    const InteractionList list = ListOf({Surface(10.0, 1.0, 1.5)}, 100.0);
    std::vector<Ray> rays;
    for (const double h :
         {0.0, 5.0, 9.99, 9.9999, 9.999999, 10.0, 10.0001, 10.5, 100.0, 1e6, 1e12}) {
        rays.push_back({Vec3d(h, 0.0, -20.0), kAlong});
    }
    const TraceColumns out = TraceAll(list, rays);
    for (std::size_t k = 0; k < rays.size(); ++k) {
        const double h = rays[k].origin.x;
        const auto fate = static_cast<RayFate>(out.fate[k]);
        if (h < 9.9999) {
            EXPECT_EQ(fate, RayFate::kArrived) << h;
            const double cos2 = 1.0 - h * h / 100.0;  // in air, the rarer medium
            EXPECT_NEAR(out.rare_cos2[k], cos2, 2e-6) << h;
        }
        if (h > 10.00005) {
            EXPECT_EQ(fate, RayFate::kMissed) << h;
        }
        if (fate == RayFate::kArrived) {
            EXPECT_TRUE(Finite(out, k)) << h;
        }
    }
}

TEST(AColumnOfTotallyReflectedRays, EndsThereAndGoesOnWhereItIsToBeReflected) {
    std::vector<Ray> rays;
    for (const double angle : {0.0, 20.0, 41.0, 41.7, 41.9, 45.0, 80.0, 89.9}) {
        const double a = RadiansFromDegrees(angle);  // critical: 41.81 degrees
        rays.push_back({Vec3d(0.0, 0.0, -1.0), Vec3d(std::sin(a), 0.0, std::cos(a))});
    }
    const TraceColumns through = TraceAll(ListOf({Surface(0.0, 1.5, 1.0)}, 10.0), rays);
    Interaction mirror = Surface(0.0, 1.5, 1.0);
    mirror.kind = InteractionKind::kReflect;
    Interaction back = Surface(0.0, 1.5, 1.5);
    back.kind = InteractionKind::kReflect;
    back.forward = false;
    back.vertex_z_mm = -2.0;
    const TraceColumns kept = TraceAll(ListOf({mirror, back}, 10.0), rays);
    for (std::size_t k = 0; k < rays.size(); ++k) {
        EXPECT_EQ(static_cast<RayFate>(through.fate[k]), k < 4 ? RayFate::kArrived : RayFate::kTir);
        EXPECT_EQ(static_cast<RayFate>(kept.fate[k]), RayFate::kArrived);
        EXPECT_TRUE(Finite(kept, k));
        // Below 0: total reflection, for the transmission tables.
        EXPECT_EQ(kept.rare_cos2[k] < 0.0F, k >= 4) << k;
    }
}

// 5e-6 mm is asked for; by the centre of the sphere floats would miss by 0.94 mm.
TEST(AColumnOnAWeakSurface, KeepsTheDigitsOfAFloat) {
    testing::Random random(4);
    double worst = 0.0;
    for (const double radius : {0.0, 1e5, 1e7, -1e7, 1e12, 1e30}) {
        const InteractionList list =
            ListOf({Surface(radius, 1.0, 1.5), Surface(0.0, 1.5, 1.0)}, 5.0);
        std::vector<Ray> rays;
        for (int k = 0; k < 64; ++k) {
            const Vec3d d =
                Vec3d(random.Uniform(-0.3, 0.3), random.Uniform(-0.3, 0.3), 1.0).normalized();
            rays.push_back(
                {Vec3d(random.Uniform(-20.0, 20.0), random.Uniform(-20.0, 20.0), -1.0), d});
        }
        const TraceColumns out = TraceAll(list, rays);
        for (std::size_t k = 0; k < rays.size(); ++k) {
            RayRecord record;
            const TraceResult exact = TraceRay(list, rays[k], {false, nullptr, true}, &record);
            ASSERT_EQ(static_cast<RayFate>(out.fate[k]), exact.fate);
            worst =
                std::max(worst, std::abs(static_cast<double>(out.hit_x[k]) - record.points[0].x));
        }
    }
    RecordProperty("worst_mm", ::testing::PrintToString(worst));
    EXPECT_LT(worst, 5e-6);
}

// Every small lens that is at a limit: floats against doubles, on the sensor.
TEST(AColumnThroughAnExtremeLens, LandsWhereTheReferenceDoes) {
    testing::Random random(5);
    const Prescription lenses[] = {
        testing::Singlets(),
        testing::BehindAPlate(40.0, 38.0),
        testing::BehindAPlate(40.0, 38.0 + 1e-6),
        testing::BehindAPlate(0.0, -60.0, 0.0),
        testing::BehindAPlate(1e7, -1e7),
        testing::GhostInFocus(),
        testing::GhostFocusedInTheStop(),
        testing::GhostOfTheStopsImage(),
        testing::CementedSinglet(1.6, 1.6 + 1e-7),
    };
    double worst = 0.0;
    for (const Prescription& prescription : lenses) {
        const auto lens = testing::BuildLens(prescription);
        std::vector<Ray> rays;
        for (int k = 0; k < 64; ++k) {
            const Vec3d d =
                Vec3d(random.Uniform(-0.1, 0.1), random.Uniform(-0.1, 0.1), 1.0).normalized();
            rays.push_back({Vec3d(random.Uniform(-4.0, 4.0), random.Uniform(-4.0, 4.0), -5.0), d});
        }
        for (const BounceSequence& sequence : TwoReflectionSequences(*lens)) {
            InteractionList list = WriteOut(*lens, sequence, kLineD);
            const TraceColumns out = TraceAll(list, rays);
            for (std::size_t k = 0; k < rays.size(); ++k) {
                const TraceResult exact = TraceRay(list, rays[k], {}, nullptr);
                if (exact.fate != RayFate::kArrived) continue;
                ASSERT_EQ(static_cast<RayFate>(out.fate[k]), RayFate::kArrived);
                const double gap = lens->sensor_gap_mm();
                const Vec2d got(
                    static_cast<double>(out.exit_x[k]) + gap * static_cast<double>(out.slope_x[k]),
                    static_cast<double>(out.exit_y[k]) + gap * static_cast<double>(out.slope_y[k]));
                if (exact.sensor_mm.length() > 40.0) continue;
                worst = std::max(worst, (got - exact.sensor_mm).length());
            }
        }
    }
    RecordProperty("worst_mm", ::testing::PrintToString(worst));
    EXPECT_LT(worst, 3.75e-4);  // 0.02 pixels of 36 mm / 1920
}

// Whatever a ray is made of.
TEST(AColumnOfWildRays, ArrivesWithFiniteNumbersOrNotAtAll) {
    testing::Random random(6);
    for (const Prescription& prescription :
         {testing::Singlets(), testing::BehindAPlate(40.0, 38.0), testing::SixtySurfaces()}) {
        const auto lens = testing::BuildLens(prescription);
        const std::vector<BounceSequence> sequences = TwoReflectionSequences(*lens);
        for (int round = 0; round < 40; ++round) {
            std::vector<Ray> rays;
            for (int k = 0; k < 256; ++k) {
                const double size = std::pow(10.0, random.Uniform(-6.0, 6.0));
                const Vec3d d(random.Uniform(-1.0, 1.0), random.Uniform(-1.0, 1.0),
                              random.Uniform(-1.0, 1.0));
                rays.push_back({Vec3d(random.Uniform(-size, size), random.Uniform(-size, size),
                                      random.Uniform(-size, size)),
                                d.normalized()});
            }
            const auto n =
                static_cast<std::size_t>(random.Below(static_cast<int>(sequences.size())));
            const TraceColumns out = TraceAll(WriteOut(*lens, sequences[n], kLineD), rays);
            for (std::size_t k = 0; k < rays.size(); ++k) {
                if (static_cast<RayFate>(out.fate[k]) != RayFate::kArrived) continue;
                ASSERT_TRUE(Finite(out, k));
            }
        }
    }
}

}  // namespace
}  // namespace flare
