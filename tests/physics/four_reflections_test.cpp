// SPDX-License-Identifier: Apache-2.0
//
// Ghosts of four reflections: how many there are, and what they weigh.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "core/tracing/trace_reference.h"
#include "tests/support/lenses.h"
#include "tests/support/scalar_tracer.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

// What all these sequences let through along the axis.
double AxialSum(const Lens& lens, const std::vector<BounceSequence>& sequences) {
    RayRecord record;
    double sum = 0.0;
    for (const BounceSequence& sequence : sequences) {
        const InteractionList list = WriteOut(lens, sequence, kLineD);
        const TraceResult ray = TraceRay(list, {Vec3d(0.0, 0.0, -1.0), Vec3d(0.0, 0.0, 1.0)},
                                         {false, nullptr, false}, &record);
        EXPECT_EQ(ray.fate, RayFate::kArrived);
        sum += PathWeight(lens, list, record);
    }
    return sum;
}

// Power that arrives after 0, 2, 4, ... reflections, by counting: light on its way to surface i,
// forwards or back, is shared out at each surface. No list of sequences.
std::vector<double> AxialByCounting(const std::vector<double>& reflectance, int most) {
    const std::size_t n = reflectance.size();
    std::vector<double> arrived(static_cast<std::size_t>(most) + 1, 0.0);
    // forward[r][i]: power that travels forwards to surface i after r reflections. Light that goes
    // forwards from a reflection at i meets i + 1 next, so each generation is one sweep.
    std::vector<double> going(n + 1, 0.0);
    going[0] = 1.0;
    for (int r = 0; r <= most; ++r) {
        const bool forward = r % 2 == 0;
        std::vector<double> turned(n + 1, 0.0);
        if (forward) {
            double power = 0.0;
            for (std::size_t i = 0; i < n; ++i) {
                power += going[i];
                // Sent back from i it meets i - 1 next.
                if (i > 0) turned[i - 1] += power * reflectance[i];
                power *= 1.0 - reflectance[i];
            }
            arrived[static_cast<std::size_t>(r)] = power + going[n];
        } else {
            double power = 0.0;
            for (std::size_t i = n; i-- > 0;) {
                power += going[i];
                turned[i + 1] += power * reflectance[i];
                power *= 1.0 - reflectance[i];
            }
        }
        going = turned;
    }
    return arrived;
}

TEST(FourReflections, OfTheSeedLensHaveTheKnownNumberAndWeight) {
    const auto bare = testing::LibraryLens(testing::kSeedName)->WithBareGlass();
    const std::vector<BounceSequence> four = FourReflectionSequences(*bare);
    EXPECT_EQ(four.size(), 1695U);
    const double direct = AxialSum(*bare, {{}});
    const double two_sum = AxialSum(*bare, TwoReflectionSequences(*bare));
    const double four_sum = AxialSum(*bare, four);
    EXPECT_NEAR(direct, 0.589977, 1e-6);
    EXPECT_NEAR(two_sum, 0.05296, 5e-6);
    EXPECT_NEAR(four_sum, 0.00380, 5e-6);
    EXPECT_NEAR(four_sum / two_sum, 0.072, 5e-4);

    std::vector<double> reflectance;
    for (const auto& s : testing::ScalarSurfaces(bare->prescription(), kLineD)) {
        if (s.stop) continue;
        reflectance.push_back(
            static_cast<double>(testing::FresnelReflectance(s.n_before, s.n_behind, 1)));
    }
    const std::vector<double> counted = AxialByCounting(reflectance, 4);
    EXPECT_NEAR(direct, counted[0], 1e-14);
    EXPECT_NEAR(two_sum, counted[2], 1e-14);
    EXPECT_NEAR(four_sum, counted[4], 1e-14);
}

// As many sequences as there are ways to go up and down between n places.
TEST(FourReflections, AreAsManyAsCombinatoricsSays) {
    for (const auto& [surfaces, sequences] : {std::pair(2, 1), std::pair(3, 8), std::pair(10, 1695),
                                              std::pair(20, 30115), std::pair(27, 102726)}) {
        std::vector<SurfacePrescription> prescription{testing::Stop(1.0, 3.0)};
        for (int k = 0; k < surfaces; ++k) {
            // Every surface has another medium on each side, the last one air.
            const double nd = k + 1 == surfaces ? 1.0 : k % 2 == 0 ? 1.5 : 1.3;
            prescription.push_back(testing::Sphere(k == 0 ? 40.0 : 0.0, 1.0, nd, 0.0, 5.0));
        }
        const auto lens = testing::BuildLens(testing::Assemble("many", prescription));
        const std::vector<BounceSequence> all = FourReflectionSequences(*lens);
        EXPECT_EQ(static_cast<int>(all.size()), sequences) << surfaces;
        EXPECT_TRUE(std::is_sorted(all.begin(), all.end()));
        EXPECT_EQ(std::set<BounceSequence>(all.begin(), all.end()).size(), all.size());
        // Counted by brute force, where that is quick.
        if (surfaces > 10) continue;
        int sound = 0;
        for (int a = 1; a <= surfaces; ++a) {
            for (int b = 1; b <= surfaces; ++b) {
                for (int c = 1; c <= surfaces; ++c) {
                    for (int d = 1; d <= surfaces; ++d) {
                        sound += CheckSequence(*lens, {a, b, c, d}).has_value() ? 0 : 1;
                    }
                }
            }
        }
        EXPECT_EQ(sound, sequences);
    }
}

TEST(FourReflections, CountTheSensorIfItReflects) {
    Prescription prescription = testing::SeedLens();
    prescription.surfaces.push_back({});
    prescription.surfaces.back().kind = SurfaceKind::kSensor;
    prescription.surfaces.back().semi_diameter_mm = 22.0;
    prescription.surfaces.back().reflectance = 0.1;
    const auto lens = testing::BuildLens(prescription);
    EXPECT_EQ(FourReflectionSequences(*lens).size(), 1695U);
    EXPECT_EQ(TwoReflectionSequences(*lens, true).size(), 55U);  // 11 * 10 / 2
    const std::vector<BounceSequence> four = FourReflectionSequences(*lens, true);
    EXPECT_EQ(four.size(), 2530U);  // as for 11 surfaces
    for (const BounceSequence& s : four) {
        EXPECT_FALSE(CheckSequence(*lens, s).has_value());
        // Nothing is behind the sensor that could send light to its back.
        EXPECT_LT(s[1], lens->sensor_index());
        EXPECT_LT(s[3], lens->sensor_index());
    }
    // A sensor that reflects nothing makes no ghosts.
    prescription.surfaces.back().reflectance = 0.0;
    EXPECT_EQ(TwoReflectionSequences(*testing::BuildLens(prescription), true).size(), 45U);
}

}  // namespace
}  // namespace flare
