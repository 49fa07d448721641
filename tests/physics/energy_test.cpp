// SPDX-License-Identifier: Apache-2.0
//
// No light is made or lost. A counter that knows nothing of bounce sequences follows one ray
// through the lens and splits it at every surface, whichever way it travels, into what is reflected
// and what goes through. Whatever comes out somewhere must add up to what went in; and what reaches
// the sensor after exactly two reflections must be what the enumerated sequences say.
#include <gtest/gtest.h>

#include <cmath>

#include "core/tracing/trace_reference.h"
#include "tests/support/lenses.h"
#include "tests/support/scalar_tracer.h"

namespace flare {
namespace {

using testing::Real;
using testing::Real3;
using testing::ScalarHit;
using testing::ScalarSurface;

struct Outcome {
    Real out_front = 0, at_sensor = 0, elsewhere = 0, cut_off = 0;
    Real direct = 0, two_reflections = 0;
    int total_reflections = 0;  // events where everything is reflected
    long branches = 0;
    Real Sum() const { return out_front + at_sensor + elsewhere + cut_off; }
};

// Textbook Fresnel with sines and cosines, long double.
Reflection Textbook(Real n1, Real n2, Real cos1) {
    const Real sin2 = n1 / n2 * std::sqrt(1 - cos1 * cos1);
    if (sin2 >= 1) return {1.0, 0.0};
    const Real cos2 = std::sqrt(1 - sin2 * sin2);
    const Real rs = (n1 * cos1 - n2 * cos2) / (n1 * cos1 + n2 * cos2);
    const Real rp = (n2 * cos1 - n1 * cos2) / (n2 * cos1 + n1 * cos2);
    const Real r = (rs * rs + rp * rp) / 2;
    return {static_cast<double>(r), static_cast<double>(1 - r)};
}

class BranchCounter {
  public:
    BranchCounter(const Lens& lens, double wavelength_nm, bool textbook, Real cut_off,
                  int most_reflections = 1000)
        : lens_(lens),
          surfaces_(testing::ScalarSurfaces(lens.prescription(), wavelength_nm)),
          wavelength_nm_(wavelength_nm),
          textbook_(textbook),
          cut_off_(cut_off),
          most_reflections_(most_reflections) {}

    // A ray with power `weight` on its way to surface `next`.
    void Follow(int next, bool forward, Real3 p, Real3 d, Real weight, int reflections) {
        ++outcome.branches;
        if (weight < cut_off_ || reflections > most_reflections_) {
            outcome.cut_off += weight;
            return;
        }
        if (next < 0) {
            outcome.out_front += weight;
            return;
        }
        if (next == static_cast<int>(surfaces_.size())) {
            (d.z > 0 ? outcome.at_sensor : outcome.elsewhere) += weight;
            if (d.z > 0 && reflections == 0) outcome.direct += weight;
            if (d.z > 0 && reflections == 2) outcome.two_reflections += weight;
            return;
        }
        const ScalarSurface& s = surfaces_[static_cast<std::size_t>(next)];
        const ScalarHit hit = ScalarMeet(s, p, d, forward);
        if (!hit.met) {
            outcome.elsewhere += weight;
            return;
        }
        if (s.stop) {
            Follow(next + (forward ? 1 : -1), forward, hit.point, d, weight, reflections);
            return;
        }
        Split(s, next, forward, hit, d, weight, reflections);
    }

    Outcome outcome;

  private:
    void Split(const ScalarSurface& s, int at, bool forward, const ScalarHit& hit, Real3 d,
               Real weight, int reflections) {
        const Real n1 = forward ? s.n_before : s.n_behind;
        const Real n2 = forward ? s.n_behind : s.n_before;
        const Real cosine = std::abs(hit.cosine);
        const Reflection share =
            textbook_ ? Textbook(n1, n2, cosine)
                      : ReflectionOf(lens_.surfaces()[static_cast<std::size_t>(at)].coating,
                                     n1 > n2, static_cast<double>(n1), static_cast<double>(n2),
                                     static_cast<double>(cosine), wavelength_nm_);
        if (share.transmittance == 0.0) ++outcome.total_reflections;
        if (share.reflectance > 0.0) {
            const Real3 back = Unit(d - hit.normal * (2 * hit.cosine));
            Follow(at + (forward ? -1 : 1), !forward, hit.point, back, weight * share.reflectance,
                   reflections + 1);
        }
        if (share.transmittance > 0.0) {
            const Real eta = n1 / n2;
            const Real sin2 = eta * eta * (1 - hit.cosine * hit.cosine);
            const Real sign = hit.cosine > 0 ? 1 : -1;
            const Real3 on =
                Unit(d * eta + hit.normal * (sign * std::sqrt(std::max<Real>(0, 1 - sin2)) -
                                             eta * hit.cosine));
            Follow(at + (forward ? 1 : -1), forward, hit.point, on, weight * share.transmittance,
                   reflections);
        }
    }

    const Lens& lens_;
    std::vector<ScalarSurface> surfaces_;
    double wavelength_nm_;
    bool textbook_;
    Real cut_off_;
    int most_reflections_;
};

struct Enumerated {
    double direct = 0.0, two_reflections = 0.0;
};

Enumerated SumOfSequences(const Lens& lens, const Ray& ray, double wavelength_nm) {
    Enumerated sum;
    RayRecord record;
    std::vector<BounceSequence> sequences = TwoReflectionSequences(lens);
    sequences.emplace_back();
    for (const BounceSequence& sequence : sequences) {
        const InteractionList list = WriteOut(lens, sequence, wavelength_nm);
        if (TraceRay(list, ray, {false, nullptr, false}, &record).fate != RayFate::kArrived)
            continue;
        (sequence.empty() ? sum.direct : sum.two_reflections) += PathWeight(lens, list, record);
    }
    return sum;
}

struct Case {
    const char* name;
    Vec3d origin, direction;
};

// On the axis, in the field, at the edge of the front, and skew.
const Case kRays[] = {
    {"axis", {0.0, 0.0, -1.0}, {0.0, 0.0, 1.0}},
    {"field", {1.0, 0.5, -1.0}, {0.0871557427, 0.0, 0.9961946981}},
    {"marginal", {0.0, 9.0, -1.0}, {0.0, -0.05, 1.0}},
    {"skew", {4.0, -5.0, -1.0}, {-0.1, 0.15, 1.0}},
};

TEST(BranchingCount, AddsUpToOneAndMatchesTheEnumeratedSequences) {
    const auto coated = testing::LibraryLens(testing::kSeedName);
    const auto bare = coated->WithBareGlass();
    int total_reflections = 0;
    for (const bool is_bare : {true, false}) {
        const Lens& lens = is_bare ? *bare : *coated;
        for (const Case& c : kRays) {
            SCOPED_TRACE(std::string(c.name) + (is_bare ? " bare" : " coated"));
            const Ray ray{c.origin, c.direction.normalized()};
            // Bare glass: the textbook's own Fresnel, so that nothing of the core is in the count.
            BranchCounter counter(lens, kLineD, is_bare, is_bare ? 1e-9L : 1e-12L);
            counter.Follow(0, true, {ray.origin.x, ray.origin.y, ray.origin.z},
                           {ray.direction.x, ray.direction.y, ray.direction.z}, 1, 0);
            const Outcome& o = counter.outcome;
            EXPECT_GT(o.branches, 1000);
            EXPECT_NEAR(static_cast<double>(o.Sum()), 1.0, 1e-12);
            EXPECT_LT(static_cast<double>(o.cut_off), 1e-3);
            const Enumerated sum = SumOfSequences(lens, ray, kLineD);
            EXPECT_NEAR(static_cast<double>(o.direct), sum.direct, 1e-13);
            // Cut-off branches may hold a few of the weakest two-reflection ghosts.
            EXPECT_NEAR(static_cast<double>(o.two_reflections), sum.two_reflections,
                        is_bare ? 45 * 1e-9 : 45 * 1e-12);
            total_reflections += o.total_reflections;
        }
    }
    EXPECT_GT(total_reflections, 0) << "no ray met total reflection: the test lost its bite";
}

TEST(BranchingCount, GivesTheKnownAxialFigures) {
    const auto bare = testing::LibraryLens(testing::kSeedName)->WithBareGlass();
    // Everything up to four reflections, however weak.
    BranchCounter counter(*bare, kLineD, true, 0.0L, 4);
    counter.Follow(0, true, {0, 0, -1}, {0, 0, 1}, 1, 0);
    EXPECT_NEAR(static_cast<double>(counter.outcome.direct), 0.589977, 1e-6);
    EXPECT_NEAR(static_cast<double>(counter.outcome.two_reflections), 0.05296, 1e-5);
    const Enumerated sum =
        SumOfSequences(*bare, {Vec3d(0.0, 0.0, -1.0), Vec3d(0.0, 0.0, 1.0)}, kLineD);
    EXPECT_NEAR(sum.two_reflections, static_cast<double>(counter.outcome.two_reflections), 1e-15);
    EXPECT_NEAR(static_cast<double>(counter.outcome.Sum()), 1.0, 1e-15);
}

}  // namespace
}  // namespace flare
