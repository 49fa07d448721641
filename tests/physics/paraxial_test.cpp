// SPDX-License-Identifier: Apache-2.0
//
// Near the axis the exact trace must become first-order optics. Two independent first-order results
// are held against it: the core's matrices, and a y-nu trace (height and reduced slope n u,
// textbook form) written here.
#include <gtest/gtest.h>

#include <cmath>

#include "core/tracing/paraxial_ghost.h"
#include "core/tracing/trace_reference.h"
#include "tests/support/lenses.h"
#include "tests/support/scalar_tracer.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::BuildLens;
using testing::Real;
using testing::ScalarSurface;
using testing::ScalarSurfaces;

struct Yu {
    Real y = 0, u = 0;        // at the sensor; u = dy/dz
    std::vector<Real> stops;  // y at each crossing
};

// y' = y + (nu) t/n, (nu)' = nu - y phi; after a reflection indices and gaps change sign.
Yu TraceYnu(const std::vector<ScalarSurface>& lens, Real sensor_z, const std::vector<int>& bounces,
            Real y, Real u) {
    Yu out;
    Real n = 1, z = 0;
    std::size_t bounce = 0;
    int way = 1;
    for (int i = 0; i < static_cast<int>(lens.size()); i += way) {
        const ScalarSurface& s = lens[static_cast<std::size_t>(i)];
        y += u * (s.z - z);
        z = s.z;
        if (s.stop) {
            out.stops.push_back(y);
            continue;
        }
        const bool reflects = bounce < bounces.size() && bounces[bounce] == i;
        Real behind = static_cast<Real>(way) * (way > 0 ? s.n_behind : s.n_before);
        if (reflects) {
            behind = -n;
            way = -way;
            ++bounce;
        }
        const Real power = s.radius == 0 ? 0 : (behind - n) / s.radius;
        u = (n * u - y * power) / behind;
        n = behind;
    }
    out.y = y + u * (sensor_z - z);
    out.u = u;
    return out;
}

// Errors are relative to the element, or to 1 where it is smaller (mm for B, 1/100 mm for C).
void ExpectClose(double value, Real expected, double tolerance, double floor, const char* what,
                 const BounceSequence& sequence) {
    const double scale = std::max(floor, static_cast<double>(std::abs(expected)));
    EXPECT_NEAR(value, static_cast<double>(expected), tolerance * scale)
        << what << " of (" << (sequence.empty() ? -1 : sequence[0]) << ","
        << (sequence.empty() ? -1 : sequence[1]) << ")";
}

std::vector<BounceSequence> DirectAndGhosts(const Lens& lens) {
    std::vector<BounceSequence> all = TwoReflectionSequences(lens);
    all.emplace_back();
    return all;
}

TEST(NearTheAxis, MatricesEqualAnIndependentYnuTraceForEveryGhost) {
    for (const char* name : testing::kLibraryNames) {
        const auto lens = testing::LibraryLens(name);
        for (const double wavelength : {450.0, kLineD, 700.0}) {
            const auto surfaces = ScalarSurfaces(lens->prescription(), wavelength);
            for (const BounceSequence& sequence : DirectAndGhosts(*lens)) {
                const ParaxialPath path = ParaxialPathOf(WriteOut(*lens, sequence, wavelength));
                const Yu parallel = TraceYnu(surfaces, lens->sensor_z_mm(), sequence, 1, 0);
                const Yu tilted = TraceYnu(surfaces, lens->sensor_z_mm(), sequence, 0, 1);
                // Elements of strong ghosts are differences of large terms: hence 1e-11.
                const double scale = std::max(1.0, std::abs(path.front_to_sensor.b) / 100.0);
                ExpectClose(path.front_to_sensor.a, parallel.y, 1e-11, scale, "A", sequence);
                ExpectClose(path.front_to_sensor.b, tilted.y, 1e-11, 100.0 * scale, "B", sequence);
                ExpectClose(path.front_to_sensor.c, parallel.u, 1e-11, scale, "C", sequence);
                ExpectClose(path.front_to_sensor.d, tilted.u, 1e-11, 100.0 * scale, "D", sequence);
                const double size = std::abs(path.front_to_sensor.a * path.front_to_sensor.d) + 1.0;
                EXPECT_NEAR(path.front_to_sensor.determinant(), 1.0, 1e-12 * size);
                ASSERT_EQ(path.front_to_stop.size(), parallel.stops.size());
                for (std::size_t k = 0; k < parallel.stops.size(); ++k) {
                    ExpectClose(path.front_to_stop[k].a, parallel.stops[k], 1e-11, scale, "A1",
                                sequence);
                    const Abcd joined = Then(path.front_to_stop[k], path.stop_to_sensor[k]);
                    ExpectClose(joined.a, parallel.y, 1e-10, scale, "A2 A1", sequence);
                }
            }
        }
    }
}

TEST(NearTheAxis, ExactRaysOfTheSeedLensFollowFirstOrderTo1e10) {
    const auto lens = BuildLens(testing::SeedLens());
    const auto surfaces = ScalarSurfaces(lens->prescription(), kLineD);
    const std::vector<BounceSequence> sequences = DirectAndGhosts(*lens);
    ASSERT_EQ(sequences.size(), 46U);
    // Third-order aberration grows with the cube of the height: at 10 nm it is below 1e-12.
    constexpr double kHeight = 1e-5, kSlope = 2e-7;
    TraceOptions options;
    options.clip = false;
    for (const BounceSequence& sequence : sequences) {
        const InteractionList list = WriteOut(*lens, sequence, kLineD);
        const Yu a = TraceYnu(surfaces, lens->sensor_z_mm(), sequence, 1, 0);
        const Yu b = TraceYnu(surfaces, lens->sensor_z_mm(), sequence, 0, 1);
        RayRecord record;
        const TraceResult parallel =
            TraceRay(list, {Vec3d(kHeight, 0.0, 0.0), Vec3d(0.0, 0.0, 1.0)}, options, &record);
        ASSERT_EQ(parallel.fate, RayFate::kArrived);
        ExpectClose(parallel.sensor_mm.x / kHeight, a.y, 1e-10, 1.0, "A", sequence);
        ExpectClose(parallel.exit_direction.x / parallel.exit_direction.z / kHeight, a.u, 1e-10,
                    0.01, "C", sequence);
        EXPECT_EQ(parallel.sensor_mm.y, 0.0);
        ASSERT_EQ(record.stop_mm.size(), a.stops.size());
        for (std::size_t k = 0; k < a.stops.size(); ++k) {
            ExpectClose(record.stop_mm[k].x / kHeight, a.stops[k], 1e-10, 1.0, "A1", sequence);
        }
        const TraceResult tilted = TraceRay(
            list, {Vec3d(0.0, 0.0, 0.0), Vec3d(kSlope, 0.0, 1.0).normalized()}, options, &record);
        ASSERT_EQ(tilted.fate, RayFate::kArrived);
        ExpectClose(tilted.sensor_mm.x / kSlope, b.y, 1e-10, 50.0, "B", sequence);
        ExpectClose(tilted.exit_direction.x / tilted.exit_direction.z / kSlope, b.u, 1e-10, 1.0,
                    "D", sequence);
    }
}

// Figures of the focused ghost and of others, from an independent program.
TEST(NearTheAxis, GhostsOfTheSeedLensHaveTheKnownMagnifications) {
    const auto lens = BuildLens(testing::SeedLens());
    struct Known {
        BounceSequence sequence;
        int crossings;
        double a, tolerance;
    };
    for (const Known& known : {Known{{9, 1}, 3, 0.0043, 5e-5}, Known{{8, 4}, 3, 0.065, 5e-4},
                               Known{{6, 0}, 3, 0.198, 5e-4}, Known{{10, 8}, 1, -0.331, 5e-4},
                               Known{{10, 4}, 3, 0.455, 5e-4}, Known{{6, 2}, 3, -0.564, 5e-4},
                               Known{{2, 0}, 1, -0.734, 5e-4}}) {
        const ParaxialPath path = ParaxialPathOf(WriteOut(*lens, known.sequence, kLineD));
        EXPECT_EQ(static_cast<int>(path.front_to_stop.size()), known.crossings);
        EXPECT_NEAR(path.front_to_sensor.a, known.a, known.tolerance);
    }
}

}  // namespace
}  // namespace flare
