// SPDX-License-Identifier: Apache-2.0
//
// Fresnel numbers and fringes of the double Gauss's 45 ghosts against figures of an independent
// program, and the rule against systems whose answer is known.
#include "core/tracing/ghost_ringing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/optics/paraxial.h"
#include "tests/support/lenses.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

// At the passage with the largest |A1|.
std::vector<GhostRinging> OfSeedLens(double f_number, double source_rad) {
    const auto lens = testing::BuildLens(testing::SeedLens());
    RingingConditions conditions;
    conditions.aperture_radius_mm = StopForFNumber(*lens, f_number).semi_diameter_mm;
    conditions.wavelength_nm = 550.0;
    conditions.source_rad = source_rad;
    conditions.pixel_mm = 0.01875;
    std::vector<GhostRinging> all;
    for (const BounceSequence& sequence : TwoReflectionSequences(*lens)) {
        const ParaxialPath path = ParaxialPathOf(WriteOut(*lens, sequence, kLineD));
        std::size_t widest = 0;
        for (std::size_t i = 1; i < path.front_to_stop.size(); ++i) {
            if (std::abs(path.front_to_stop[i].a) > std::abs(path.front_to_stop[widest].a)) {
                widest = i;
            }
        }
        all.push_back(RingingOf(path, widest, conditions));
    }
    return all;
}

double Median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

TEST(GhostRinging, HasTheFresnelNumbersOfTheSeedLens) {
    for (const auto& [f_number, least, median, most] :
         {std::array{8.0, 1.2, 515.0, 1e4}, {22.0, 0.16, 68.0, 1.4e3}}) {
        std::vector<double> numbers, fringes_px;
        for (const GhostRinging& ringing : OfSeedLens(f_number, 0.0)) {
            numbers.push_back(ringing.fresnel_number);
            fringes_px.push_back(ringing.fringe_mm / 0.01875);
        }
        EXPECT_NEAR(*std::min_element(numbers.begin(), numbers.end()), least, 0.06 * least);
        EXPECT_NEAR(Median(numbers), median, 0.05 * median);
        EXPECT_NEAR(*std::max_element(numbers.begin(), numbers.end()), most, 0.05 * most);
        EXPECT_NEAR(Median(fringes_px), 9.6, 0.5);
    }
}

// A point shows fringes of more than a pixel in all ghosts but one; the sun leaves eight.
TEST(GhostRinging, SurvivesTheSunInEightGhostsOf45) {
    int wide = 0, sun = 0;
    for (const GhostRinging& ringing : OfSeedLens(8.0, 0.0)) {
        // Behind the geometric edge; the one ghost that is nearly in focus has a wider ring.
        const double edge_mm =
            1.2172 * std::abs(ringing.m) * std::sqrt(0.5 * 550e-6 * std::abs(ringing.z_eff_mm));
        EXPECT_GE(ringing.fringe_mm, edge_mm * (1.0 - 1e-12));
        wide += edge_mm > 0.01875 ? 1 : 0;
        EXPECT_EQ(ringing.model == RingingModel::kPropagation, ringing.fresnel_number <= 50.0);
        EXPECT_EQ(ringing.reason, RingingReason::kVisible);
    }
    for (const GhostRinging& ringing : OfSeedLens(8.0, 9.3e-3)) {
        const bool visible = ringing.model != RingingModel::kGeometric;
        EXPECT_EQ(visible, ringing.reason == RingingReason::kVisible);
        sun += visible ? 1 : 0;
    }
    EXPECT_EQ(wide, 44);
    EXPECT_EQ(sun, 8);
}

// A stop, then a distance d: z_eff is d itself, m is 1, and a degree of the light moves it by d.
TEST(GhostRinging, OfAFreeDistanceIsThatDistance) {
    ParaxialPath path;
    path.front_to_stop = {Drift(5.0)};
    path.stop_to_sensor = {Drift(80.0)};
    path.front_to_sensor = Then(Drift(5.0), Drift(80.0));
    RingingConditions conditions{2.0, 500.0, 1e-3, 0.005, 0.0};
    const GhostRinging free = RingingOf(path, 0, conditions);
    EXPECT_DOUBLE_EQ(free.m, 1.0);
    EXPECT_DOUBLE_EQ(free.z_eff_mm, 80.0);
    EXPECT_DOUBLE_EQ(free.fresnel_number, 4.0 / (500e-6 * 80.0));
    EXPECT_NEAR(free.fringe_mm, 1.2172 * std::sqrt(500e-6 * 40.0), 1e-12);
    EXPECT_NEAR(free.blur_mm, 0.08, 1e-12);
    EXPECT_EQ(free.model, RingingModel::kEdgeProfile);
    conditions.pixel_mm = 1.0;
    EXPECT_EQ(RingingOf(path, 0, conditions).reason, RingingReason::kPixel);
    conditions.source_rad = 0.01;
    EXPECT_EQ(RingingOf(path, 0, conditions).reason, RingingReason::kSource);
    conditions = {2.0, 500.0, 0.0, 0.005, 1.5};
    EXPECT_EQ(RingingOf(path, 0, conditions).reason, RingingReason::kBandwidth);
    // A third of the wavelength, as a channel of a colour picture sums up, leaves two.
    conditions.relative_bandwidth = 0.33;
    EXPECT_NEAR(RingingOf(path, 0, conditions).fringes, 2.1, 0.1);
}

TEST(GhostRinging, IsAbsentInTheStopsImageAndWholeInFocus) {
    RingingConditions conditions{2.0, 500.0, 0.0, 0.001, 0.0};
    ParaxialPath imaged;
    imaged.front_to_stop = {Drift(5.0)};
    imaged.stop_to_sensor = {Abcd{-1.0, 0.0, -0.1, -1.0}};
    imaged.front_to_sensor = Then(imaged.front_to_stop[0], imaged.stop_to_sensor[0]);
    EXPECT_EQ(RingingOf(imaged, 0, conditions).reason, RingingReason::kStopInFocus);
    EXPECT_EQ(RingingOf(imaged, 0, conditions).model, RingingModel::kGeometric);
    // A thin lens of 100 mm at the stop, the sensor in its focus: Airy's pattern.
    ParaxialPath focused;
    focused.front_to_stop = {Abcd{}};
    focused.stop_to_sensor = {Then(Abcd{1.0, 0.0, -0.01, 1.0}, Drift(100.0))};
    focused.front_to_sensor = focused.stop_to_sensor[0];
    ASSERT_EQ(focused.front_to_sensor.a, 0.0);
    const GhostRinging airy = RingingOf(focused, 0, conditions);
    EXPECT_EQ(airy.fresnel_number, 0.0);
    EXPECT_EQ(airy.model, RingingModel::kPropagation);
    // Its first bright ring: 1.635 lambda f / D.
    EXPECT_NEAR(airy.fringe_mm, 1.635 * 500e-6 * 100.0 / 4.0, 1e-4);
}

}  // namespace
}  // namespace flare
