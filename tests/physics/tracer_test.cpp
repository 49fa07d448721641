// SPDX-License-Identifier: Apache-2.0
//
// The exact tracer against plain trigonometry.
#include <gtest/gtest.h>

#include <cmath>

#include "core/tracing/trace_reference.h"
#include "tests/support/lenses.h"

namespace flare {
namespace {

// The light of a point on the axis through a plano-convex lens, by plain trigonometry: a ray
// parallel to the axis that goes through the plane first bends only at the sphere.
TEST(OneRefraction, FollowsTheClosedFormOfAPlanoConvexLens) {
    Prescription prescription;
    prescription.name = "plano";
    SurfacePrescription stop, plane, sphere;
    stop.kind = SurfaceKind::kStop;
    stop.gap_mm = 1.0;
    stop.semi_diameter_mm = 9.0;
    plane.kind = SurfaceKind::kPlane;
    plane.gap_mm = 5.0;
    plane.nd = 1.5;
    plane.semi_diameter_mm = 9.0;
    sphere.radius_mm = -30.0;
    sphere.semi_diameter_mm = 9.0;
    prescription.surfaces = {stop, plane, sphere};
    const auto lens = testing::BuildLens(prescription);
    const InteractionList list = WriteOut(*lens, {}, kLineD);
    for (const double h : {0.5, 3.0, 8.5}) {
        const TraceResult ray =
            TraceRay(list, {Vec3d(0.0, h, -10.0), Vec3d(0.0, 0.0, 1.0)}, {}, nullptr);
        ASSERT_EQ(ray.fate, RayFate::kArrived);
        const double in = std::asin(h / 30.0);
        const double out = std::asin(1.5 * h / 30.0);
        const double z = 6.0 - 30.0 * (1.0 - std::cos(in));
        const double y = h - (lens->sensor_z_mm() - z) * std::tan(out - in);
        EXPECT_NEAR(ray.sensor_mm.y, y, 1e-12);
        EXPECT_EQ(ray.sensor_mm.x, 0.0);
    }
}

}  // namespace
}  // namespace flare
