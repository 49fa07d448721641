// SPDX-License-Identifier: Apache-2.0
//
// The tracer in floats against the reference, for every lens of the library and every ghost: fewer
// rays than tests/bench/float_accuracy traces, and the same limits.
#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/units.h"
#include "tests/support/float_comparison.h"
#include "tests/support/lenses.h"

namespace flare {
namespace {

std::vector<std::string> AllNames() {
    std::vector<std::string> names;
    for (const auto& file : std::filesystem::directory_iterator(FLARE_SOURCE_DIR "/lenses")) {
        if (file.path().extension() == ".toml") names.push_back(file.path().stem().string());
    }
    std::sort(names.begin(), names.end());
    return names;
}

class FloatAccuracy : public ::testing::TestWithParam<std::string> {};

TEST_P(FloatAccuracy, OfAllGhostsIsWithinTheLimits) {
    const auto lens = testing::LibraryLens(GetParam());
    const LightBundle bundle(*lens, RadiansFromDegrees(5.0), 0.0, lens->rotational() ? 0.0 : 0.5);
    const testing::FloatTracerComparison comparison(*lens, bundle);
    testing::FloatComparison all;
    std::uint64_t seed = 100;
    const std::vector<BounceSequence> sequences = TwoReflectionSequences(*lens);
    const std::size_t rays = std::max<std::size_t>(200, 30'000 / sequences.size());
    for (const BounceSequence& sequence : sequences) {
        all.Add(comparison.Compare(sequence, rays, ++seed));
    }
    ASSERT_GT(all.miss_px.size(), 1000U);
    const double p999 = testing::Percentile(all.miss_px, 0.999);
    RecordProperty("p999_px", std::to_string(p999));
    // Before the mesh builder has traced the worst ghosts in doubles.
    const double limit_px = lens->first_order().efl_mm > 200.0 ? 0.05 : 0.02;
    EXPECT_LT(p999, 1.5 * limit_px);
    EXPECT_LT(testing::Percentile(all.miss_px, 0.99), limit_px);
    EXPECT_LE(static_cast<double>(all.fates_differ), 1e-4 * static_cast<double>(all.rays) + 2.0);
    EXPECT_LT(all.farthest_from_edge, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Library, FloatAccuracy, ::testing::ValuesIn(AllNames()),
                         [](const auto& tested) {
                             std::string name = tested.param;
                             std::replace_if(
                                 name.begin(), name.end(),
                                 [](char c) { return c == '-' || c == '.'; }, '_');
                             return name;
                         });

}  // namespace
}  // namespace flare
