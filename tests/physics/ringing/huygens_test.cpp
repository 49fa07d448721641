// SPDX-License-Identifier: Apache-2.0
//
// Where the fringes of ghosts lie: Huygens' sum over exact optical paths against the distances that
// profiles are drawn with, and those of first order.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "core/tracing/paraxial_ghost.h"
#include "tests/support/huygens.h"
#include "tests/support/lenses.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::MeridionalHuygens;

constexpr double kLambda_nm = 550.0;
constexpr double kLambda_mm = kLambda_nm * 1e-6;

std::size_t WidestCrossing(const ParaxialPath& path) {
    std::size_t widest = 0;
    for (std::size_t i = 1; i < path.front_to_stop.size(); ++i) {
        if (std::abs(path.front_to_stop[i].a) > std::abs(path.front_to_stop[widest].a)) widest = i;
    }
    return widest;
}

// The extremes of a straight edge's profile, in v: maximum, minimum, maximum, ...
constexpr std::array<double, 4> kExtremes = {1.2172, 1.8725, 2.3445, 2.7390};

// One ghost's edge at x = -+ the iris's radius.
struct Fringes {
    bool known = false;
    double paraxial_z_mm = 0.0, local_z_mm = 0.0;
    double paraxial_miss = 0.0, local_miss = 0.0;  // fringes, the largest of those looked at
};

// Where the extremes of the brute-force sum lie, as v by the paraxial and by the local distance.
Fringes MeasureFringes(const Lens& lens, const BounceSequence& sequence, double side) {
    const double radius = StopForFNumber(lens, 8.0).semi_diameter_mm;
    const ParaxialPath path = ParaxialPathOf(WriteOut(lens, sequence, kLambda_nm));
    const std::size_t crossing = WidestCrossing(path);
    const MeridionalHuygens huygens(lens, sequence, crossing, RadiansFromDegrees(5.0), kLambda_nm);
    Fringes out;
    out.paraxial_z_mm = std::abs(path.stop_to_sensor[crossing].b * path.front_to_stop[crossing].a /
                                 path.front_to_sensor.a);
    const auto at_edge = huygens.JacobianAt(side * radius);
    if (!at_edge || !at_edge->Distance({1.0, 0.0})) return out;
    out.local_z_mm = std::abs(*at_edge->Distance({1.0, 0.0}));
    const double unit_mm = std::sqrt(0.5 * kLambda_mm * out.local_z_mm);
    const auto bright = [&](double inside_mm) {
        const double to = side * radius;
        const double middle = to - side * inside_mm;
        const double far = 100.0 * side;
        return huygens.Relative(middle, std::min(to, -far), std::max(to, -far), 14.0 * unit_mm);
    };
    // From the edge inwards, uphill and downhill in turn, and a parabola through the three places
    // about each extreme. No distance says where to look.
    constexpr double kStep_t = 0.1;
    constexpr int kMostSteps = 60;
    const double step = kStep_t * unit_mm;
    int place = 0;
    std::optional<double> before, here = bright(0.0), next = bright(step);
    for (std::size_t n = 0; n < kExtremes.size(); ++n) {
        const double sign = n % 2 == 0 ? 1.0 : -1.0;
        while (here && next && sign * *next > sign * *here && place < kMostSteps) {
            before = here;
            here = next;
            ++place;
            next = bright((place + 1) * step);
        }
        if (!before || !here || !next || place == kMostSteps) return out;
        const double best =
            place * step + 0.5 * step * (*next - *before) / (2.0 * *here - *before - *next);
        // A third of the way to the edge (ghost_fringes.h).
        const auto between = huygens.JacobianAt(side * (radius - best * 2.0 / 3.0));
        if (!between || !between->Distance({1.0, 0.0})) return out;
        // v^2 grows by 4 from fringe to fringe.
        const auto miss = [&](double z) {
            return 0.25 * std::abs(2.0 * best * best / (kLambda_mm * std::abs(z)) -
                                   kExtremes[n] * kExtremes[n]);
        };
        out.local_miss = std::max(out.local_miss, miss(*between->Distance({1.0, 0.0})));
        out.paraxial_miss = std::max(out.paraxial_miss, miss(out.paraxial_z_mm));
    }
    out.known = true;
    return out;
}

TEST(Ringing, HasItsFringesWhereHuygensSumOverExactPathsHasThem) {
    const auto lens = testing::BuildLens(testing::SeedLens());
    // Both edges in the meridional plane. From one edge of (8, 4) inwards the distance grows from
    // 174 to 838 mm within 1.7 mm.
    const std::vector<BounceSequence> ghosts = {{2, 0}, {4, 2}, {6, 0}, {6, 4},  {8, 2},
                                                {8, 4}, {8, 6}, {9, 6}, {10, 4}, {10, 8}};
    double worst_paraxial = 0.0;
    for (const BounceSequence& ghost : ghosts) {
        for (const double side : {-1.0, 1.0}) {
            const Fringes fringes = MeasureFringes(*lens, ghost, side);
            std::printf(
                "(%d,%d) edge %+.0f: z paraxial %.2f local %.2f mm; off by %.3f, %.3f "
                "fringes\n",
                ghost[0], ghost[1], side, fringes.paraxial_z_mm, fringes.local_z_mm,
                fringes.paraxial_miss, fringes.local_miss);
            EXPECT_TRUE(fringes.known) << ghost[0] << ", " << ghost[1];
            EXPECT_LT(fringes.local_miss, 0.1) << ghost[0] << ", " << ghost[1];
            worst_paraxial = std::max(worst_paraxial, fringes.paraxial_miss);
        }
    }
    EXPECT_GT(worst_paraxial, 1.0);
}

TEST(StopJacobian, OfParaxialRaysIsTheFirstOrderDistance) {
    const auto lens = testing::BuildLens(testing::SeedLens());
    const LightBundle bundle(*lens, 0.0, 0.0);
    for (const BounceSequence& ghost : TwoReflectionSequences(*lens)) {
        const InteractionList list = WriteOut(*lens, ghost, kLambda_nm);
        const ParaxialPath path = ParaxialPathOf(list);
        for (std::size_t c = 0; c < path.front_to_stop.size(); ++c) {
            const auto jacobian = StopPassage(list, c).At(bundle, 1e-3, 0.0);
            ASSERT_TRUE(jacobian.has_value());
            const double z =
                path.stop_to_sensor[c].b * path.front_to_stop[c].a / path.front_to_sensor.a;
            for (const Vec2d& n : {Vec2d(1.0, 0.0), Vec2d(0.6, 0.8)})
                EXPECT_NEAR(std::abs(*jacobian->Distance(n)), std::abs(z), 1e-4 * std::abs(z));
        }
    }
}

}  // namespace
}  // namespace flare
