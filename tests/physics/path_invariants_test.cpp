// SPDX-License-Identifier: Apache-2.0
//
// What no path through a lens may break, of whatever surfaces: light finds its way back, the
// Lagrange invariant is kept by first-order matrices and by real rays, and the matrices are the
// limit of the rays.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/tracing/paraxial_ghost.h"
#include "core/tracing/trace_reference.h"
#include "tests/support/all_kinds_lens.h"
#include "tests/support/lenses.h"
#include "tests/support/random.h"

namespace flare {
namespace {

using testing::Random;

// ---- Every path backwards ----

// The way back: the steps in reverse, each surface crossed from its other side. A mirror is met
// from the side that it was met from.
InteractionList Reversed(const InteractionList& list) {
    InteractionList back = list;
    back.steps.assign(list.steps.rbegin(), list.steps.rend());
    for (Interaction& step : back.steps) {
        if (step.kind == InteractionKind::kReflect) continue;
        step.forward = !step.forward;
        std::swap(step.n_in, step.n_out);
    }
    return back;
}

// How far from the start the ray comes back, sideways, having been turned round at the sensor.
double MissOfStart(const InteractionList& list, const Ray& ray, const TraceResult& end) {
    RayRecord record;
    const Vec3d on_sensor(end.sensor_mm.x, end.sensor_mm.y, list.sensor_z_mm);
    const TraceResult back =
        TraceRay(Reversed(list), {on_sensor, -end.exit_direction}, {false, nullptr, true}, &record);
    if (record.points.size() != list.steps.size()) return 1e300;
    // It leaves at the front, so there is no sensor; but it has a place and a direction.
    const Vec3d to_start = ray.origin - record.points.back();
    return (to_start - back.exit_direction * to_start.dot(back.exit_direction)).length() +
           (back.exit_direction + ray.direction).length();
}

struct Lenses {
    std::string name;
    std::shared_ptr<const Lens> lens;
};

std::vector<Lenses> TestLenses() {
    return {{"all kinds", testing::BuildLens(testing::AllKindsLens())},
            {"seed", testing::BuildLens(testing::SeedLens())},
            {"anamorphic", testing::LibraryLens("schneider-anamorphic-31mm-f2")},
            {"fisheye", testing::LibraryLens(testing::kFisheyeName)}};
}

// The direct path, all of two reflections and some of four.
std::vector<BounceSequence> Sequences(const Lens& lens, int fours) {
    std::vector<BounceSequence> all = TwoReflectionSequences(lens, true);
    all.emplace_back();
    const std::vector<BounceSequence> four = FourReflectionSequences(lens, true);
    Random random(6);
    for (int k = 0; k < fours; ++k) {
        all.push_back(four[static_cast<std::size_t>(random.Below(static_cast<int>(four.size())))]);
    }
    return all;
}

TEST(EveryPath, IsReversible) {
    double worst = 0.0;
    for (const auto& [name, lens] : TestLenses()) {
        Random random(9);
        int arrived = 0, of_four = 0;
        for (const BounceSequence& sequence : Sequences(*lens, 300)) {
            const InteractionList list = WriteOut(*lens, sequence, 550.0);
            for (int k = 0; k < 12; ++k) {
                const double h = 0.35 * lens->first_order().entrance.diameter_mm;
                const Vec3d pupil(random.Uniform(-h, h), random.Uniform(-h, h), lens->pupil_z_mm());
                const Vec3d direction =
                    Vec3d(random.Uniform(-0.1, 0.1), random.Uniform(-0.1, 0.1), 1.0).normalized();
                const Ray ray{pupil - direction * 60.0, direction};
                // Rays that get through: beyond the rims paths may be as sensitive as they like.
                const TraceResult end = TraceRay(list, ray, {}, nullptr);
                if (end.fate != RayFate::kArrived) continue;
                ++arrived;
                of_four += sequence.size() == 4 ? 1 : 0;
                const double miss = MissOfStart(list, ray, end);
                worst = std::max(worst, miss);
                EXPECT_LT(miss, 1e-10) << name << " " << ::testing::PrintToString(sequence);
            }
        }
        EXPECT_GT(arrived, 200) << name;
        EXPECT_GT(of_four, 50) << name;
    }
    RecordProperty("worst_mm", ::testing::PrintToString(worst));
}

// ---- Lagrange ----

// H = n (y1 u2 - y2 u1) of any two paraxial rays is that of the start: here of the rays (1, 0) and
// (0, 1), after every step of every path, in each section. Light that goes back has a negative
// index, as everywhere in first-order optics.
void ExpectInvariant(const InteractionList& list, Section section, const std::string& name) {
    Abcd rays;
    double z = 0.0, index = 1.0, size = 1.0, rounding = 0.0;
    for (const Interaction& step : list.steps) {
        rays = Then(Then(rays, Drift(step.vertex_z_mm - z)), StepMatrix(step, section));
        z = step.vertex_z_mm;
        if (step.kind == InteractionKind::kReflect) index = -index;
        if (step.kind == InteractionKind::kRefract) index *= step.n_out / step.n_in;
        // What cancels in the determinant stays behind as rounding.
        size = std::max(size, std::abs(rays.a * rays.d) + std::abs(rays.b * rays.c));
        rounding += 1e-15 * size;
        ASSERT_NEAR(index * rays.determinant(), 1.0, rounding) << name;
    }
    EXPECT_NEAR(index, 1.0, 1e-14) << name;
    const Abcd whole = ParaxialPathOf(list, section).front_to_sensor;
    const Abcd same = Then(rays, Drift(list.sensor_z_mm - z));
    EXPECT_EQ(whole.a, same.a);
    EXPECT_EQ(whole.b, same.b);
    EXPECT_EQ(whole.c, same.c);
    EXPECT_EQ(whole.d, same.d);
}

TEST(LagrangeInvariant, OfFirstOrderRaysIsKeptInEachSection) {
    for (const auto& [name, lens] : TestLenses()) {
        for (const BounceSequence& sequence : Sequences(*lens, 2000)) {
            const InteractionList list = WriteOut(*lens, sequence, 500.0);
            ExpectInvariant(list, Section::kX, name);
            ExpectInvariant(list, Section::kY, name);
        }
    }
}

using State = std::array<double, 4>;  // x, y and the direction cosines p, q: canonical, in air

// From the plane in front to the sensor.
bool Propagate(const InteractionList& list, double start_z, const State& in, State& out) {
    const double pz = std::sqrt(1.0 - in[2] * in[2] - in[3] * in[3]);
    const TraceResult ray = TraceRay(list, {Vec3d(in[0], in[1], start_z), Vec3d(in[2], in[3], pz)},
                                     {false, nullptr, false}, nullptr);
    if (ray.fate != RayFate::kArrived) return false;
    out = {ray.sensor_mm.x, ray.sensor_mm.y, ray.exit_direction.x, ray.exit_direction.y};
    return true;
}

// Central differences of sixth order, of x and y over `step` mm, of p and q over a hundredth of it.
// Columns are derivatives.
bool Differences(const InteractionList& list, double start_z, const State& at, double step_mm,
                 std::array<State, 4>& columns) {
    constexpr double kWeights[] = {3.0 / 4.0, -3.0 / 20.0, 1.0 / 60.0};
    for (std::size_t k = 0; k < 4; ++k) {
        const double step = k < 2 ? step_mm : 0.01 * step_mm;
        columns[k] = {};
        for (int j = 1; j <= 3; ++j) {
            State plus = at, minus = at, a{}, b{};
            plus[k] += j * step;
            minus[k] -= j * step;
            if (!Propagate(list, start_z, plus, a) || !Propagate(list, start_z, minus, b)) {
                return false;
            }
            for (std::size_t i = 0; i < 4; ++i) {
                columns[k][i] += kWeights[j - 1] * (a[i] - b[i]) / step;
            }
        }
    }
    return true;
}

// False where differences have no hold: beside total reflection or a graze half the step gives
// another derivative.
bool Jacobian(const InteractionList& list, double start_z, const State& at,
              std::array<State, 4>& columns) {
    std::array<State, 4> coarse{};
    if (!Differences(list, start_z, at, 2e-3, coarse) ||
        !Differences(list, start_z, at, 1e-3, columns)) {
        return false;
    }
    for (std::size_t k = 0; k < 4; ++k) {
        for (std::size_t i = 0; i < 4; ++i) {
            const double size = 1.0 + std::abs(columns[k][i]);
            if (std::abs(columns[k][i] - coarse[k][i]) > 1e-9 * size) return false;
        }
    }
    return true;
}

// The same for real rays, skew and far from the axis: the Lagrange bracket of any two small
// displacements, dx dp' - dx' dp + dy dq' - dy' dq, is kept (the map is symplectic).
TEST(LagrangeInvariant, OfRealRaysIsKeptOnEveryPath) {
    double worst = 0.0;
    for (const auto& [name, lens] : TestLenses()) {
        Random random(10);
        int looked_at = 0, left_out = 0;
        for (const BounceSequence& sequence : Sequences(*lens, 60)) {
            const InteractionList list = WriteOut(*lens, sequence, 550.0);
            for (int k = 0; k < 4; ++k) {
                const double h = 0.3 * lens->first_order().entrance.diameter_mm;
                const double p = random.Uniform(-0.1, 0.1), q = random.Uniform(-0.1, 0.1);
                const double start_z = -10.0;
                const double back = (start_z - lens->pupil_z_mm());
                const State at = {random.Uniform(-h, h) + p * back,
                                  random.Uniform(-h, h) + q * back, p, q};
                const double pz = std::sqrt(1.0 - p * p - q * q);
                if (TraceRay(list, {Vec3d(at[0], at[1], start_z), Vec3d(p, q, pz)}, {}, nullptr)
                        .fate != RayFate::kArrived) {
                    continue;
                }
                std::array<State, 4> j{};
                ++looked_at;
                if (!Jacobian(list, start_z, at, j)) {
                    ++left_out;
                    continue;
                }
                for (std::size_t a = 0; a < 4; ++a) {
                    for (std::size_t b = a + 1; b < 4; ++b) {
                        const State &u = j[a], &v = j[b];
                        const double bracket =
                            u[0] * v[2] - u[2] * v[0] + u[1] * v[3] - u[3] * v[1];
                        const double size = std::abs(u[0] * v[2]) + std::abs(u[2] * v[0]) +
                                            std::abs(u[1] * v[3]) + std::abs(u[3] * v[1]);
                        const double kept = b == a + 2 ? 1.0 : 0.0;
                        worst = std::max(worst, std::abs(bracket - kept) / (1.0 + size));
                        EXPECT_NEAR(bracket, kept, 1e-8 * (1.0 + size))
                            << name << " " << ::testing::PrintToString(sequence);
                    }
                }
            }
        }
        EXPECT_GT(looked_at, 50) << name;
        EXPECT_LT(left_out, looked_at / 6) << name << " of " << looked_at;
    }
    RecordProperty("worst", ::testing::PrintToString(worst));
}

// On the axis the derivatives of real rays are the elements of the matrices, and the sections know
// nothing of each other.
TEST(FirstOrder, IsTheLimitOfRealRaysInEachSection) {
    for (const auto& [name, lens] : TestLenses()) {
        const std::vector<BounceSequence> sequences = Sequences(*lens, 200);
        std::size_t looked_at = 0;
        for (const BounceSequence& sequence : sequences) {
            const InteractionList list = WriteOut(*lens, sequence, 500.0);
            std::array<State, 4> j{};
            // Very sensitive paths have no hold for differences.
            if (!Jacobian(list, 0.0, State{}, j)) continue;
            ++looked_at;
            for (std::size_t s = 0; s < 2; ++s) {
                const Abcd m =
                    ParaxialPathOf(list, s == 0 ? Section::kX : Section::kY).front_to_sensor;
                EXPECT_NEAR(j[s][s], m.a, 1e-8 * (1.0 + std::abs(m.a))) << name;
                EXPECT_NEAR(j[s + 2][s], m.b, 1e-8 * (1.0 + std::abs(m.b))) << name;
                EXPECT_NEAR(j[s][s + 2], m.c, 1e-8 * (1.0 + std::abs(m.c))) << name;
                EXPECT_NEAR(j[s + 2][s + 2], m.d, 1e-8 * (1.0 + std::abs(m.d))) << name;
                for (const std::size_t column : {s, s + 2}) {
                    EXPECT_EQ(j[column][1 - s], 0.0) << name;
                    EXPECT_EQ(j[column][3 - s], 0.0) << name;
                }
            }
        }
        EXPECT_GT(looked_at, sequences.size() / 3) << name;
    }
}

}  // namespace
}  // namespace flare
