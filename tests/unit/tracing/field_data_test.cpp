// SPDX-License-Identifier: Apache-2.0
//
// Field data against closed forms. A ball with its stop in the middle is the same from every
// direction: its chief rays go straight on, so it has no distortion, cos^4 relative illumination
// and one transmittance for the whole field.
#include "core/tracing/field_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/tracing/passing_beam.h"
#include "tests/support/lenses.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::BuildLens;
using testing::Sphere;
using testing::Stop;

constexpr double kBallRadius = 50.0, kBallIndex = 1.5, kBallStop = 0.2, kBallRim = 45.0;
// From the centre: n R / (2 (n - 1)).
constexpr double kBallFocal = 75.0;

Prescription Ball() {
    Prescription lens = testing::Assemble(
        "ball", {Sphere(kBallRadius, kBallRadius, kBallIndex, 0.0, kBallRim),
                 Stop(kBallRadius, kBallStop), Sphere(-kBallRadius, 0.0, 1.0, 0.0, kBallRim)});
    lens.surfaces[1].nd = kBallIndex;
    return lens;
}

TEST(FieldOfABall, HasNoDistortionAndFollowsTheCosineLaws) {
    Prescription prescription = Ball();
    prescription.design_image_circle_mm = 120.0;
    const FieldData data = FieldDataOf(*BuildLens(prescription));
    ASSERT_EQ(data.tables.size(), 1u);
    const FieldTable& table = data.tables[0];
    EXPECT_EQ(table.edge, FieldEdge::kImageCircle);
    ASSERT_EQ(table.rows.size(), 11u);
    EXPECT_NEAR(table.rows.back().field_rad, std::atan(60.0 / kBallFocal), 1e-8);
    // Its own stop seen through one half is n times as large.
    const double axis_area = kPi * kBallIndex * kBallIndex * kBallStop * kBallStop;
    const double normal = 1.0 - std::pow((kBallIndex - 1.0) / (kBallIndex + 1.0), 2);
    for (const FieldRow& row : table.rows) {
        const double cosine = std::cos(row.field_rad);
        EXPECT_NEAR(*row.image_height_mm, kBallFocal * std::tan(row.field_rad), 1e-9);
        EXPECT_NEAR(*row.ideal_height_mm, kBallFocal * std::tan(row.field_rad), 1e-9);
        EXPECT_NEAR(*row.distortion, 0.0, 1e-6);
        EXPECT_FALSE(row.f_theta_distortion.has_value());
        EXPECT_NEAR(row.beam_area_mm2 / (axis_area * cosine), 1.0, 3e-4);
        EXPECT_NEAR(row.beam_share / cosine, 1.0, 3e-4);
        EXPECT_NEAR(*row.relative_illumination / std::pow(cosine, 4), 1.0, 3e-4);
        EXPECT_NEAR(*row.transmittance, normal * normal, 1e-5);
        EXPECT_NEAR(row.flux_mm2, row.beam_area_mm2 * normal * normal, 1e-5);
        ASSERT_EQ(row.transmittances.size(), data.wavelengths_nm.size());
        for (const double t : row.transmittances) EXPECT_NEAR(t, normal * normal, 1e-5);
    }
}

// A plane scene at half a metre: perspective alone, which is the same cosine law.
TEST(FieldOfABall, IsTheSameForANearPlane) {
    Prescription prescription = Ball();
    prescription.design_image_circle_mm = 120.0;
    FieldOptions options;
    options.focus_m = 0.5;
    options.rows = 4;
    const FieldData data = FieldDataOf(*BuildLens(prescription), options);
    ASSERT_EQ(data.tables[0].rows.size(), 4u);
    for (const FieldRow& row : data.tables[0].rows) {
        EXPECT_NEAR(*row.distortion, 0.0, 1e-6);
        EXPECT_NEAR(*row.relative_illumination / std::pow(std::cos(row.field_rad), 4), 1.0, 5e-4);
    }
    // The scene would stand behind the ball.
    options.focus_m = 0.02;
    EXPECT_TRUE(FieldDataOf(*BuildLens(prescription), options).tables[0].rows.empty());
}

TEST(FieldOfABall, MarkedFisheyeIsHeldAgainstFTheta) {
    Prescription prescription = Ball();
    prescription.fisheye = true;
    prescription.design_image_circle_mm = 120.0;
    const FieldData data = FieldDataOf(*BuildLens(prescription), {.rows = 3});
    for (std::size_t i = 1; i < 3; ++i) {
        const FieldRow& row = data.tables[0].rows[i];
        EXPECT_NEAR(*row.f_theta_distortion, std::tan(row.field_rad) / row.field_rad - 1.0, 1e-9);
    }
}

TEST(FieldOfABall, WithoutAnImageCircleEndsWhereTheRimsEndTheLight) {
    const FieldData data = FieldDataOf(*BuildLens(Ball()), {.rows = 5});
    EXPECT_EQ(data.tables[0].edge, FieldEdge::kNoLight);
    // The beam is 2 * 0.3 cos(field) mm wide and bent a little on its way.
    const double rim = std::asin(kBallRim / kBallRadius);
    EXPECT_NEAR(data.tables[0].rows.back().field_rad, rim, 0.4 / kBallRadius);
    EXPECT_LT(data.tables[0].rows.back().beam_share, 0.02);
}

TEST(FieldOptions, FNumberSetsTheIrisAndIsClamped) {
    Prescription prescription = Ball();
    prescription.design_image_circle_mm = 40.0;
    const auto lens = BuildLens(prescription);
    const FieldData open = FieldDataOf(*lens, {.rows = 2});
    const double f_number = kBallFocal / (2.0 * kBallIndex * kBallStop);
    EXPECT_NEAR(open.f_number, f_number, 1e-9);
    const FieldData half = FieldDataOf(*lens, {.rows = 2, .f_number = 2.0 * f_number});
    EXPECT_NEAR(half.tables[0].rows[0].beam_area_mm2 / open.tables[0].rows[0].beam_area_mm2, 0.25,
                1e-4);
    const FieldData clamped = FieldDataOf(*lens, {.rows = 2, .f_number = 0.1});
    EXPECT_NEAR(clamped.f_number, f_number, 1e-9);
    EXPECT_EQ(clamped.tables[0].rows[1].beam_area_mm2, open.tables[0].rows[1].beam_area_mm2);
}

// A window's rim 20 mm in front of the stop: the beam is what two discs, apart by 20 tan(field),
// have in common.
TEST(PassingBeam, IsTheCommonPartOfRimAndStop) {
    constexpr double kWindow = 3.0, kStop = 4.0, kApart = 20.0;
    const auto lens = BuildLens(testing::Assemble(
        "two-discs",
        {Sphere(0.0, 1e-6, 1.5, 0.0, 50.0), Sphere(0.0, kApart, 1.0, 0.0, kWindow),
         Stop(2.0, kStop), Sphere(100.0, 6.0, 1.5, 0.0, 40.0), Sphere(0.0, 0.0, 1.0, 0.0, 40.0)}));
    const auto common = [&](double d) {
        const double r = kWindow, s = kStop;
        if (d <= s - r) return kPi * r * r;
        if (d >= s + r) return 0.0;
        const double p = r * r * std::acos((d * d + r * r - s * s) / (2.0 * d * r));
        const double q = s * s * std::acos((d * d + s * s - r * r) / (2.0 * d * s));
        return p + q - 0.5 * std::sqrt((-d + r + s) * (d + r - s) * (d - r + s) * (d + r + s));
    };
    const FieldData data = FieldDataOf(*lens, {.rows = 21});
    const FieldTable& table = data.tables[0];
    EXPECT_EQ(table.edge, FieldEdge::kNoLight);
    // The last sliver of light is narrower than the search for it.
    EXPECT_NEAR(table.rows.back().field_rad, std::atan((kWindow + kStop) / kApart), 2e-3);
    double worst = 0.0;
    for (const FieldRow& row : table.rows) {
        const double expected = common(kApart * std::tan(row.field_rad)) * std::cos(row.field_rad);
        worst = std::max(worst, std::abs(row.beam_area_mm2 - expected) / (kPi * 9.0));
        if (expected > 0.02) {
            EXPECT_NEAR(row.beam_area_mm2 / expected, 1.0, 1e-3) << row.field_rad;
        }
    }
    EXPECT_LT(worst, 3e-4);
}

// An ellipse known in closed form, far from the middle of its plane and small in it.
TEST(PassingBeam, IsFoundAndIntegrated) {
    constexpr double kA = 0.3, kB = 0.7, kU = 40.0;
    RayPlane plane;
    plane.half_width = 100.0;
    plane.passes = [&](double u, double v) { return std::hypot((u - kU) / kA, v / kB) <= 1.0; };
    const PassingBeam beam = FindPassingBeam(plane);
    EXPECT_NEAR(beam.area_mm2() / (kPi * kA * kB), 1.0, 5e-4);
    double area = 0.0, moment = 0.0;
    for (const PassingBeam::Node& node : beam.Nodes()) {
        area += node.area_mm2;
        moment += node.area_mm2 * (node.u - kU) * (node.u - kU);
        EXPECT_GT(node.u, beam.box.u0);
        EXPECT_LT(node.u, beam.box.u1);
        EXPECT_LT(node.v, beam.box.v1);
    }
    EXPECT_NEAR(area / beam.area_mm2(), 1.0, 1e-12);
    EXPECT_NEAR(moment / (0.25 * kPi * kA * kA * kA * kB), 1.0, 1e-3);

    // Narrower than the scan: only where the caller points.
    plane.passes = [&](double u, double v) { return std::hypot(u - kU, v) <= 0.01; };
    EXPECT_TRUE(FindPassingBeam(plane).empty());
    plane.hint_u = kU + 0.005;
    EXPECT_NEAR(FindPassingBeam(plane).area_mm2() / (kPi * 1e-4), 1.0, 5e-4);
}

// A cylinder of a million kilometres' radius bends nothing, but makes the lens anamorphic by name:
// both of its tables must be that of the lens with a plane in its place.
TEST(FieldOfAnAnamorphic, EqualsTheRotationalOneWhereBothSectionsAreAlike) {
    Prescription plane = testing::SeedLens();
    plane.surfaces.insert(plane.surfaces.begin(),
                          {Sphere(0.0, 1.0, 1.5, 0.0, 30.0), Sphere(0.0, 4.0, 1.0, 0.0, 30.0)});
    plane.design_image_circle_mm = 43.3;
    Prescription cylinder = plane;
    cylinder.surfaces[0].kind = SurfaceKind::kCylinderX;
    cylinder.surfaces[0].radius_mm = 1e12;
    const FieldData expected = FieldDataOf(*BuildLens(plane), {.rows = 4});
    const FieldData both = FieldDataOf(*BuildLens(cylinder), {.rows = 4});
    ASSERT_EQ(both.tables.size(), 2u);
    EXPECT_EQ(both.tables[0].section, Section::kX);
    EXPECT_EQ(both.tables[1].section, Section::kY);
    for (const FieldTable& table : both.tables) {
        ASSERT_EQ(table.rows.size(), 4u);
        for (std::size_t i = 0; i < 4; ++i) {
            const FieldRow& a = expected.tables[0].rows[i];
            const FieldRow& b = table.rows[i];
            EXPECT_NEAR(a.field_rad, b.field_rad, 1e-8);
            EXPECT_NEAR(*a.image_height_mm, *b.image_height_mm, 1e-6);
            EXPECT_NEAR(*a.distortion, *b.distortion, 1e-7);
            EXPECT_NEAR(*a.relative_illumination, *b.relative_illumination, 1e-5);
            EXPECT_NEAR(a.flux_mm2, b.flux_mm2, 1e-4);
        }
    }
}

}  // namespace
}  // namespace flare
