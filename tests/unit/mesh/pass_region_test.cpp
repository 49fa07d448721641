// SPDX-License-Identifier: Apache-2.0
//
// The region must hold every ray that passes, and not be much larger than them: a mesh over empty
// space is coarse where the light is.
#include "core/mesh/pass_region.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "tests/support/anamorphic_lens.h"
#include "tests/support/lenses.h"
#include "tests/support/random.h"

namespace flare {
namespace {

struct Case {
    const char* lens;
    double field_deg, inverse_distance;
    double most;  // area of all regions over the area of the passing rays' boxes, at most
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
    return out << c.lens << " at " << c.field_deg << " degrees";
}

class PassRegions : public ::testing::TestWithParam<Case> {};

TEST_P(PassRegions, HoldAllPassingRaysAndLittleElse) {
    const Case& c = GetParam();
    const auto lens = testing::LibraryLens(c.lens);
    const LightBundle bundle(*lens, RadiansFromDegrees(c.field_deg), c.inverse_distance);
    testing::Random random(6);
    double region_area = 0.0, passing_area = 0.0;
    int passing = 0;
    std::vector<BounceSequence> sequences = TwoReflectionSequences(*lens);
    for (std::size_t s = 0; s < sequences.size(); s += sequences.size() / 20 + 1) {
        const std::vector<InteractionList> lists{WriteOut(*lens, sequences[s], 420.0),
                                                 WriteOut(*lens, sequences[s], kLineD),
                                                 WriteOut(*lens, sequences[s], 690.0)};
        const PassRegion region = FindPassRegion(lists, bundle);
        EXPECT_GT(region.rays, 0U);
        double u0 = 1e300, u1 = -1e300, v1 = 0.0;
        for (int k = 0; k < 6000; ++k) {
            // All over the bundle, and within the region where there is one.
            const bool all_over = k % 3 == 0 || !region.rect;
            const double h = bundle.half_width();
            const double u = all_over ? bundle.centre_u() + random.Uniform(-h, h)
                                      : random.Uniform(region.rect->u0, region.rect->u1);
            const double v =
                all_over ? random.Uniform(0.0, h) : random.Uniform(0.0, region.rect->v1);
            const InteractionList& list = lists[static_cast<std::size_t>(k % 2)];
            if (TraceRay(list, bundle.At(u, v), {}, nullptr).fate != RayFate::kArrived) continue;
            ++passing;
            ASSERT_TRUE(region.rect.has_value()) << sequences[s][0] << "," << sequences[s][1];
            EXPECT_GE(u, region.rect->u0) << sequences[s][0] << "," << sequences[s][1];
            EXPECT_LE(u, region.rect->u1) << sequences[s][0] << "," << sequences[s][1];
            EXPECT_LE(v, region.rect->v1) << sequences[s][0] << "," << sequences[s][1];
            u0 = std::min(u0, u);
            u1 = std::max(u1, u);
            v1 = std::max(v1, v);
        }
        if (u1 <= u0) continue;
        EXPECT_EQ(region.rect->v0, -region.rect->v1);
        region_area += (region.rect->u1 - region.rect->u0) * region.rect->v1;
        passing_area += (u1 - u0) * v1;
    }
    ASSERT_GT(passing, 500);
    EXPECT_LT(region_area, c.most * passing_area);
}

INSTANTIATE_TEST_SUITE_P(Lenses, PassRegions,
                         ::testing::Values(Case{testing::kSeedName, 0.0, 0.0, 5.0},
                                           Case{testing::kSeedName, 12.0, 0.0, 5.0},
                                           Case{testing::kSeedName, 5.0, 1.0 / 300.0, 5.0},
                                           Case{testing::kHeliarName, 8.0, 0.0, 5.0},
                                           Case{testing::kRetrofocusName, 15.0, 0.0, 25.0},
                                           Case{testing::kFisheyeName, 40.0, 0.0, 60.0},
                                           Case{testing::kFisheyeName, 95.0, 0.0, 60.0}),
                         [](const auto& test) { return "Case" + std::to_string(test.index); });

// Light reflected by cylinders passes in narrow strips, across all of v and slanted where nothing
// is symmetric.
TEST(PassRegion, HoldsAllRaysOfAnAnamorphicLens) {
    const auto lens = testing::BuildLens(testing::BehindAfocalPair(testing::SeedLens()));
    testing::Random random(8);
    for (const double azimuth_deg : {0.0, 37.0, 90.0}) {
        const CanonicalPose pose = PoseOf(*lens, RadiansFromDegrees(azimuth_deg));
        const LightBundle bundle(*lens, RadiansFromDegrees(5.0), 0.0, pose.azimuth_rad);
        for (const BounceSequence& sequence :
             {BounceSequence{2, 1}, {3, 1}, {4, 1}, {8, 2}, {14, 10}, {12, 8}}) {
            const InteractionList list = WriteOut(*lens, sequence, kLineD);
            const PassRegion region = FindPassRegion({list}, bundle);
            int passing = 0, outside = 0;
            for (int k = 0; k < 40000; ++k) {
                const double h = bundle.half_width();
                const double u = bundle.centre_u() + random.Uniform(-h, h);
                const double v = random.Uniform(-h, h);
                if (TraceRay(list, bundle.At(u, v), {}, nullptr).fate != RayFate::kArrived)
                    continue;
                ++passing;
                const bool inside = region.rect && u >= region.rect->u0 && u <= region.rect->u1 &&
                                    v >= region.rect->v0 && v <= region.rect->v1;
                outside += inside ? 0 : 1;
            }
            EXPECT_GT(passing, 40) << sequence[0] << "," << sequence[1] << " " << azimuth_deg;
            EXPECT_EQ(outside, 0) << sequence[0] << "," << sequence[1] << " " << azimuth_deg;
        }
    }
}

TEST(PassRegion, IsEmptyWhereNoRayCanPass) {
    const auto lens = testing::LibraryLens(testing::kTelephotoName);
    const LightBundle bundle(*lens, RadiansFromDegrees(30.0), 0.0);
    int empty = 0;
    const std::vector<BounceSequence> sequences = TwoReflectionSequences(*lens);
    for (const BounceSequence& sequence : sequences) {
        empty += FindPassRegion({WriteOut(*lens, sequence, kLineD)}, bundle).rect ? 0 : 1;
    }
    EXPECT_GT(empty, static_cast<int>(sequences.size()) / 2);
}

}  // namespace
}  // namespace flare
