// SPDX-License-Identifier: Apache-2.0
#include "core/drawing/section_outline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/lenses.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::Assemble;
using testing::BuildLens;
using testing::Sphere;
using testing::Stop;

// One element (between surfaces 1 and 2) behind a stop.
std::shared_ptr<const Lens> Singlet(double r1, double r2, double gap_mm, double semi1,
                                    double semi2) {
    Prescription file = Assemble("singlet", {Stop(5.0, 2.0), Sphere(r1, gap_mm, 1.5, 0.0, semi1),
                                             Sphere(r2, 0.0, 1.0, 0.0, semi2)});
    file.surfaces.back().gap_mm = 50.0;
    file.surfaces.back().gap_given = true;
    return BuildLens(file);
}

std::vector<Vec2d> Corners(const ElementOutline& element, double height) {
    std::vector<Vec2d> found;
    for (const Vec2d& p : element.outline) {
        if (std::abs(p.y - height) < 1e-12) found.push_back(p);
    }
    return found;
}

TEST(FaceOutline, LiesOnTheSphere) {
    const auto lens = BuildLens(testing::SeedLens());
    const Outline face = FaceOutline(*lens, 4, Section::kY);
    const double vertex = lens->surfaces()[4].vertex_z_mm;
    EXPECT_EQ(face.front().y, -9.0);
    EXPECT_EQ(face.back().y, 9.0);
    for (const Vec2d& p : face) {
        EXPECT_NEAR(std::hypot(p.x - vertex - 12.75, p.y), 12.75, 1e-12);
    }
    EXPECT_TRUE(std::is_sorted(face.begin(), face.end(),
                               [](const Vec2d& a, const Vec2d& b) { return a.y < b.y; }));
}

TEST(FaceOutline, ACylinderIsFlatInTheOtherSection) {
    Prescription file = Assemble("cylinder", {Stop(5.0, 2.0), Sphere(40.0, 4.0, 1.5, 0.0, 6.0),
                                              Sphere(-60.0, 0.0, 1.0, 0.0, 6.0)});
    file.surfaces[1].kind = SurfaceKind::kCylinderX;
    const auto lens = BuildLens(file);
    for (const Vec2d& p : FaceOutline(*lens, 1, Section::kX)) {
        EXPECT_NEAR(std::hypot(p.x - 5.0 - 40.0, p.y), 40.0, 1e-12);
    }
    const Outline flat = FaceOutline(*lens, 1, Section::kY);
    EXPECT_EQ(flat, (Outline{{5.0, -6.0}, {5.0, 6.0}}));
}

TEST(FaceOutline, AnAsphereFollowsItsFormula) {
    Prescription file = Assemble("asphere", {Stop(5.0, 2.0), Sphere(30.0, 6.0, 1.5, 0.0, 8.0),
                                             Sphere(0.0, 0.0, 1.0, 0.0, 8.0)});
    file.surfaces[1].kind = SurfaceKind::kAsphere;
    file.surfaces[1].conic = -1.0;  // a parabola
    file.surfaces[1].asphere = {1e-5};
    const auto lens = BuildLens(file);
    for (const Vec2d& p : FaceOutline(*lens, 1, Section::kY)) {
        const double h2 = p.y * p.y;
        EXPECT_NEAR(p.x - 5.0, h2 / 60.0 + 1e-5 * h2 * h2, 1e-12);
    }
}

TEST(ElementOutlines, JoinEqualRimsStraight) {
    const auto elements = ElementOutlines(*Singlet(30.0, -30.0, 5.0, 8.0, 8.0), Section::kY);
    ASSERT_EQ(elements.size(), 1U);
    EXPECT_EQ(elements[0].front, 1);
    EXPECT_EQ(elements[0].nd, 1.5);
    const double sag = 30.0 - std::sqrt(900.0 - 64.0);
    const std::vector<Vec2d> corners = Corners(elements[0], 8.0);
    ASSERT_EQ(corners.size(), 2U);
    EXPECT_NEAR(corners[0].x, 5.0 + sag, 1e-12);
    EXPECT_NEAR(corners[1].x, 10.0 - sag, 1e-12);
}

TEST(ElementOutlines, StepWhereTheRimsDiffer) {
    // Concave back of 5 mm in a front of 8 mm: its rim stands out flat.
    const auto elements = ElementOutlines(*Singlet(30.0, 10.0, 5.0, 8.0, 5.0), Section::kY);
    const double back = 10.0 + (10.0 - std::sqrt(75.0));
    const std::vector<Vec2d> wide = Corners(elements[0], 8.0);
    ASSERT_EQ(wide.size(), 2U);
    EXPECT_NEAR(wide[1].x, back, 1e-12);
    const std::vector<Vec2d> narrow = Corners(elements[0], 5.0);
    ASSERT_GE(narrow.size(), 1U);
    EXPECT_NEAR(narrow.back().x, back, 1e-12);
}

TEST(ElementOutlines, SlantWhereAStepWouldCutTheOtherFace) {
    // The front's rim (sag 4.54 mm at 9 mm) lies behind the back's (at 3 - 0.42 mm).
    const auto elements = ElementOutlines(*Singlet(11.2, -30.0, 3.0, 9.0, 5.0), Section::kY);
    EXPECT_EQ(Corners(elements[0], 9.0).size(), 1U);
    EXPECT_EQ(Corners(elements[0], 5.0).size(), 1U);
}

TEST(ElementOutlines, EndWhereTheFacesCross) {
    // Equal spheres of radius R, vertices t apart, meet at h^2 = R^2 - (R - t/2)^2.
    const auto elements = ElementOutlines(*Singlet(20.0, -20.0, 2.0, 8.0, 8.0), Section::kY);
    double highest = 0.0;
    for (const Vec2d& p : elements[0].outline) highest = std::max(highest, p.y);
    EXPECT_NEAR(highest, std::sqrt(400.0 - 361.0), 1e-6);
}

TEST(ElementOutlines, CementedElementsShareTheirFace) {
    const auto lens = BuildLens(testing::SeedLens());
    const std::vector<ElementOutline> elements = ElementOutlines(*lens, Section::kY);
    ASSERT_EQ(elements.size(), 6U);
    EXPECT_EQ(elements[1].front, 2);
    EXPECT_EQ(elements[2].front, 3);
    for (const Vec2d& p : FaceOutline(*lens, 3, Section::kY)) {
        for (const std::size_t k : {1U, 2U}) {
            const Outline& outline = elements[k].outline;
            EXPECT_NE(std::find(outline.begin(), outline.end(), p), outline.end());
        }
    }
}

}  // namespace
}  // namespace flare
