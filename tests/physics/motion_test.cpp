// SPDX-License-Identifier: Apache-2.0
//
// A picture in motion must not pop: no step of a sweep changes it by more than three times what the
// median step does. Short sweeps with small pictures; tests/bench/motion makes the long ones.
#include <gtest/gtest.h>

#include "tests/support/lenses.h"
#include "tests/support/motion.h"
#include "tests/support/rendering.h"

namespace flare {
namespace {

using testing::Motion;
using testing::Moving;

struct Sweep {
    const char* name;
    Moving moving;
    double from, step;
    int frames;
};

Motion MotionOf(const Sweep& sweep) {
    Motion motion;
    motion.moving = sweep.moving;
    motion.lens = testing::LibraryLens(testing::kSeedName);
    motion.from = sweep.from;
    motion.step = sweep.step;
    motion.width = 192;
    motion.height = 108;
    motion.quality = QualityPreset::kDraft;
    return motion;
}

// Of each frame but the first, from the one before.
std::vector<double> Changes(const Sweep& sweep, int popping_frame) {
    const Motion motion = MotionOf(sweep);
    testing::Studio studio;
    std::vector<double> changes;
    FlareImage before;
    for (int n = 0; n < sweep.frames; ++n) {
        FlareRequest request = testing::FrameOf(motion, n);
        if (n == popping_frame) request.model.culling = CullingRule::kReport;
        FlareImage image = studio.Shoot(request).image;
        if (n > 0) changes.push_back(testing::ChangeFrom(before, image));
        before = std::move(image);
    }
    return changes;
}

double LargestOverMedian(const std::vector<double>& changes) {
    return *std::max_element(changes.begin(), changes.end()) / testing::Median(changes);
}

class SmoothMotion : public ::testing::TestWithParam<Sweep> {};

TEST_P(SmoothMotion, ChangesThePictureEvenly) {
    const std::vector<double> changes = Changes(GetParam(), -1);
    for (const double change : changes) EXPECT_GT(change, 0.0) << "each step must show";
    const double ratio = LargestOverMedian(changes);
    RecordProperty("largest_over_median", std::to_string(ratio));
    EXPECT_LT(ratio, 3.0);
}

INSTANTIATE_TEST_SUITE_P(Sweeps, SmoothMotion,
                         ::testing::Values(Sweep{"light", Moving::kLight, 5.0, 0.01, 24},
                                           Sweep{"iris", Moving::kIris, 3.9, 0.01, 32},
                                           Sweep{"focus", Moving::kFocus, 2.0, 0.01, 24},
                                           Sweep{"distance", Moving::kDistance, 2.0, 0.02, 12}),
                         [](const auto& tested) { return tested.param.name; });

// Ghosts that the old rules drop from one frame are such a pop.
TEST(SmoothMotion, IsMeasuredSoThatAPopShows) {
    EXPECT_GT(LargestOverMedian(Changes({"iris", Moving::kIris, 3.9, 0.01, 9}, 5)), 3.0);
}

}  // namespace
}  // namespace flare
