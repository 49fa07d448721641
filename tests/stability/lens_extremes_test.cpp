// SPDX-License-Identifier: Apache-2.0
//
// Prescriptions at the edge of sense: each is either built and traced without a special case, or
// refused at its place. Never half of both.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/optics/paraxial.h"
#include "core/prescription/prescription_reader.h"
#include "core/tracing/trace_reference.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::Assemble;
using testing::PlanoConvex;
using testing::SeedLens;
using testing::Sphere;
using testing::Stop;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

void ExpectRefused(const Prescription& prescription, const std::string& where) {
    const auto lens = Lens::Build(prescription);
    ASSERT_FALSE(lens.ok());
    EXPECT_EQ(lens.error().code, "bad_lens");
    EXPECT_EQ(lens.error().where, where) << lens.error().message;
    EXPECT_FALSE(lens.error().message.empty());
}

TEST(ARimWiderThanItsSphere, IsRefused) {
    Prescription lens = SeedLens();
    lens.surfaces[4].semi_diameter_mm = 12.75;  // the radius itself
    ExpectRefused(lens, "#4");
    lens.surfaces[4].semi_diameter_mm = 12.74;
    EXPECT_TRUE(Lens::Build(lens).ok());
}

TEST(AnIndexThatNoGlassHas, IsRefused) {
    for (const double nd : {0.999, -1.5, 4.1, 1e9, kNaN, kInfinity}) {
        Prescription lens = SeedLens();
        lens.surfaces[2].nd = nd;
        ExpectRefused(lens, "#2");
    }
    for (const double vd : {0.0, -40.0, 1e9, kNaN}) {
        Prescription lens = SeedLens();
        lens.surfaces[2].vd = vd;
        ExpectRefused(lens, "#2");
    }
    Prescription lens = SeedLens();
    lens.surfaces[2].vd.reset();  // no V-number: no dispersion
    const auto built = testing::BuildLens(lens);
    EXPECT_EQ(built->MediumBehind(2).Index(400.0), built->MediumBehind(2).Index(700.0));
}

TEST(GapsOf, ZeroAreBuiltAndNegativeOnesRefused) {
    Prescription lens = SeedLens();
    lens.surfaces[1].gap_mm = 0.0;
    EXPECT_TRUE(Lens::Build(lens).ok());
    for (const double gap : {-1e-9, -5.0, kNaN, kInfinity, 1e9}) {
        lens.surfaces[1].gap_mm = gap;
        ExpectRefused(lens, "#1");
    }
}

// In a picture: a cemented pair of one glass is one glass.
TEST(ACementedPairOfOneGlass, GivesThePictureOfOneElement) {
    Prescription split = PlanoConvex();
    SurfacePrescription inner = Sphere(80.0, 3.0, 1.5, 0.0, 10.0);
    inner.where = "#inner";
    split.surfaces[1].gap_mm = 3.0;
    split.surfaces.insert(split.surfaces.begin() + 2, inner);
    testing::Studio studio;
    FlareRequest request =
        testing::SpectralRequest(testing::BuildLens(PlanoConvex()), 12.0, 64, 36);
    request.lights = {testing::LightAt(3.0)};
    const Rendering whole = studio.Shoot(request);
    request.lens = testing::BuildLens(split);
    const Rendering cemented = studio.Shoot(request);
    ASSERT_EQ(whole.report.facts.ghosts.size(), 1U);
    ASSERT_EQ(cemented.report.facts.ghosts.size(), 1U);
    EXPECT_GT(whole.report.facts.ghosts[0].flux_mm2, 0.01);
    EXPECT_NEAR(cemented.report.facts.ghosts[0].flux_mm2 / whole.report.facts.ghosts[0].flux_mm2,
                1.0, 2e-3);
}

// In a picture: a step of 1e-7 makes ghosts of no account, and finite numbers.
TEST(AnIndexStepOf1e7, MakesGhostsOfNoAccount) {
    Prescription lens = SeedLens();
    lens.surfaces[3].nd = *lens.surfaces[2].nd + 1e-7;
    lens.surfaces[3].vd = lens.surfaces[2].vd;
    testing::Studio studio;
    FlareRequest request = testing::SpectralRequest(testing::BuildLens(lens), 8.0, 32, 18);
    request.lights = {testing::LightAt(3.0)};
    const Rendering rendering = studio.Shoot(request);
    double through_step = 0.0, others = 0.0;
    for (const GhostFacts& ghost : rendering.report.facts.ghosts) {
        ASSERT_TRUE(std::isfinite(ghost.flux_mm2));
        const bool step = ghost.sequence[0] == 3 || ghost.sequence[1] == 3;
        (step ? through_step : others) += ghost.flux_mm2;
    }
    EXPECT_LT(through_step, 1e-12 * others);
    for (const float value : rendering.image.planes[0].values) ASSERT_TRUE(std::isfinite(value));
}

TEST(StopsMissingOrMany, AreRefusedAndFirstOrLastOnesBuilt) {
    Prescription none = SeedLens();
    none.surfaces.erase(none.surfaces.begin() + 5);
    ExpectRefused(none, "");
    Prescription two = SeedLens();
    SurfacePrescription second = Stop(0.1, 9.0);
    second.where = "#second";
    two.surfaces[5].gap_mm -= 0.1;
    two.surfaces.insert(two.surfaces.begin() + 6, second);
    ExpectRefused(two, "#second");

    // A stop in front is its own entrance pupil; a stop behind, its own exit pupil.
    const auto first = testing::BuildLens(PlanoConvex());
    EXPECT_NEAR(first->first_order().entrance.z_mm, 0.0, 1e-12);
    EXPECT_NEAR(first->first_order().entrance.diameter_mm, 10.0, 1e-12);
    Prescription behind = Assemble("behind", {Sphere(50.0, 6.0, 1.5, 0.0, 10.0),
                                              Sphere(0.0, 2.0, 1.0, 0.0, 10.0), Stop(0.0, 5.0)});
    const auto last = testing::BuildLens(behind);
    EXPECT_NEAR(last->first_order().exit.z_mm, 8.0, 1e-12);
    EXPECT_NEAR(last->first_order().exit.diameter_mm, 10.0, 1e-12);
    // Both are rendered.
    testing::Studio studio;
    for (const auto& lens : {first, last}) {
        FlareRequest request = testing::SpectralRequest(lens, 12.0, 32, 18);
        request.lights = {testing::LightAt(2.0)};
        EXPECT_GT(testing::Sum(studio.Shoot(request).image.planes[0]), 0.0);
    }
}

// A telecentric exit pupil lies at infinity; pixels still have directions.
TEST(ATelecentricLens, PlacesLightsByPixel) {
    // The stop one focal length in front of a thin-ish lens.
    const auto lens = testing::BuildLens(Assemble(
        "telecentric",
        {Stop(96.0, 5.0), Sphere(0.0, 6.0, 1.5, 0.0, 20.0), Sphere(-50.0, 0.0, 1.0, 0.0, 20.0)}));
    ASSERT_TRUE(std::isinf(lens->first_order().exit.z_mm));
    testing::Studio studio;
    FlareRequest request = testing::SpectralRequest(lens, 10.0, 36, 20);
    LightSpec light;
    light.pixel = Vec2d(28.0, 10.0);
    request.lights = {light};
    const Rendering rendering = studio.Shoot(request);
    const LightFacts& facts = rendering.report.facts.lights.at(0);
    EXPECT_NEAR(facts.field_deg, DegreesFromRadians(std::atan(10.0 / 100.0)), 1e-9);
    for (const float value : rendering.image.planes[0].values) ASSERT_TRUE(std::isfinite(value));
}

// The small end: two reflections need two surfaces.
TEST(TheSmallestLens, HasOneGhostAndIsBlackWithoutLight) {
    const auto built = testing::BuildLens(PlanoConvex());
    EXPECT_EQ(TwoReflectionSequences(*built).size(), 1U);
    testing::Studio studio;
    FlareRequest request = testing::SpectralRequest(built, 10.0, 16, 9);
    const Rendering unlit = studio.Shoot(request);  // no lights at all
    for (const float value : unlit.image.planes[0].values) {
        EXPECT_EQ(value, 0.0F);
    }
}

// toml++ takes it for impossible that a letter beyond ASCII is asked whether it is white space.
TEST(ALetterBehindANumber, IsRefusedAtItsPlace) {
    for (const char* letter :
         {"\u0140", "\u00e9", "\u0431", "\u1680", "\u3000", "\ufeff", "\xff"}) {
        const auto lens =
            ReadPrescriptionToml(std::string("name = \"x\"\nyear = 1967") + letter + "\n");
        ASSERT_FALSE(lens.ok()) << letter;
        EXPECT_EQ(lens.error().code, "bad_lens");
        EXPECT_FALSE(lens.error().where.empty());
    }
}

TEST(ASensorThatCannotStand, IsRefused) {
    Prescription afocal = PlanoConvex();
    afocal.surfaces[1] = Sphere(0.0, 6.0, 1.5, 0.0, 10.0);
    afocal.surfaces[1].where = "#1";
    ExpectRefused(afocal, "#2");
    afocal.surfaces[2].gap_given = true;
    afocal.surfaces[2].gap_mm = 30.0;
    EXPECT_TRUE(Lens::Build(afocal).ok());
    Prescription diverging = PlanoConvex();
    diverging.surfaces[1].radius_mm = -50.0;
    ExpectRefused(diverging, "#2");
}

}  // namespace
}  // namespace flare
