// SPDX-License-Identifier: Apache-2.0
//
// The exact tracer against a second one, written for the tests in another form and in long double
// (tests/support/scalar_tracer.h): same fates, same places, same angles, same weights, for random
// rays along random sequences of no, two and four reflections through every lens file, as it stands
// and in a random state, and through a lens with every kind of surface.
//
// A ray whose fate rounding decides (kMargin from a rim, from total reflection or from the order of
// two surfaces) is left out and counted; there must be next to none. Outside its rim a conic, an
// asphere or a toroid may be met or missed: both tracers lose the ray, one as vignetted, one as
// missed.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/units.h"
#include "core/optics/lens_state.h"
#include "core/tracing/chief_ray.h"
#include "core/tracing/light_bundle.h"
#include "core/tracing/trace_reference.h"
#include "tests/support/all_kinds_lens.h"
#include "tests/support/lenses.h"
#include "tests/support/random.h"
#include "tests/support/scalar_tracer.h"

namespace flare {
namespace {

using testing::Random;
using testing::Real;
using testing::Real3;
using testing::ScalarFate;
using testing::ScalarResult;

constexpr Real kMargin = 1e-9L;
constexpr double kPlace_mm = 1e-9;

// Every lens file there is, so that a new one is covered without a word here; and the lens of all
// kinds, which is no file.
constexpr const char* kAllKinds = "all-kinds";

std::vector<std::string> LensNames() {
    std::vector<std::string> names{kAllKinds};
    for (const auto& file : std::filesystem::directory_iterator(FLARE_SOURCE_DIR "/lenses")) {
        if (file.path().extension() == ".toml") names.push_back(file.path().stem().string());
    }
    std::sort(names.begin(), names.end());
    return names;
}

// Bare, so that Fresnel's formula gives the weights.
std::shared_ptr<const Lens> BareLens(const std::string& name) {
    Prescription prescription =
        name == kAllKinds ? testing::AllKindsLens() : testing::LibraryPrescription(name);
    prescription.default_coating = "bare";
    for (SurfacePrescription& surface : prescription.surfaces) surface.coating.reset();
    return testing::BuildLens(prescription);
}

LensState RandomState(const StateTable& states, Random& random) {
    LensState state;
    if (!states.focal_mm.empty()) {
        state.zoom_mm = random.Uniform(states.focal_mm.front(), states.focal_mm.back());
    }
    if (!states.focus_m.empty()) {
        state.focus_m = 1.0 / random.Uniform(0.0, 1.0 / states.focus_m.back());
    }
    return state;
}

RayFate FateOf(ScalarFate fate) {
    switch (fate) {
        case ScalarFate::kArrived:
            return RayFate::kArrived;
        case ScalarFate::kVignetted:
            return RayFate::kVignetted;
        case ScalarFate::kStopped:
            return RayFate::kStopped;
        case ScalarFate::kMissed:
            return RayFate::kMissed;
        case ScalarFate::kTir:
            return RayFate::kTir;
    }
    return RayFate::kMissed;
}

Real3 ToReal(const Vec3d& v) {
    return {v.x, v.y, v.z};
}

class Comparison {
  public:
    explicit Comparison(const Lens& lens) : lens_(lens) {}

    std::array<int, 5> fates{};
    std::array<int, 3> arrived{};  // after 0, 2, 4 reflections
    int undecided = 0;
    double worst_mm = 0.0, worst_weight = 0.0;

    void Compare(const InteractionList& list, const BounceSequence& sequence,
                 const std::vector<testing::ScalarSurface>& surfaces, const Ray& ray) {
        for (const bool clip : {true, false}) {
            const TraceResult got = TraceRay(list, ray, {clip, nullptr, false}, &record_);
            const ScalarResult want =
                ScalarTrace(surfaces, lens_.sensor_z_mm(), sequence, ToReal(ray.origin),
                            testing::Unit(ToReal(ray.direction)), clip);
            if (want.margin < kMargin) {
                undecided += clip ? 1 : 0;
                continue;
            }
            // Unclipped, surfaces given by their sag are promised to be met within their rims only.
            if (!clip && (want.widest_sag > 1 || MetSagOutside(list))) continue;
            if (!clip && got.fate == RayFate::kMissed && OfSag(list, got.ended_at)) continue;
            ASSERT_NO_FATAL_FAILURE(CompareFates(list, got, want));
            if (clip) ++fates[static_cast<std::size_t>(got.fate)];
            if (got.fate != RayFate::kArrived) continue;
            ComparePlaces(list, got, want, clip);
            if (clip) {
                ++arrived[sequence.size() / 2];
                CompareWhatWasMet(list, got, want);
            }
        }
    }

  private:
    static bool OfSag(const InteractionList& list, int step) {
        if (step < 0) return false;
        const SurfaceShape& shape = list.steps[static_cast<std::size_t>(step)].shape;
        return shape.form() == SurfaceForm::kAsphere || shape.form() == SurfaceForm::kToroid ||
               shape.conic() != 0.0;
    }

    bool MetSagOutside(const InteractionList& list) const {
        for (std::size_t i = 0; i < record_.rim_ratio2.size(); ++i) {
            if (OfSag(list, static_cast<int>(i)) && record_.rim_ratio2[i] > 1.0) return true;
        }
        return false;
    }

    void CompareFates(const InteractionList& list, const TraceResult& got,
                      const ScalarResult& want) const {
        const RayFate fate = FateOf(want.fate);
        ASSERT_EQ(got.ended_at, want.ended_at) << Name(got.fate) << " " << Name(fate);
        const auto lost_at_rim = [](RayFate f) {
            return f == RayFate::kMissed || f == RayFate::kVignetted;
        };
        if (OfSag(list, got.ended_at) && lost_at_rim(got.fate) && lost_at_rim(fate)) return;
        ASSERT_EQ(got.fate, fate);
        ASSERT_EQ(record_.cos_in.size(), want.cos_in.size());
    }

    void ComparePlaces(const InteractionList&, const TraceResult& got, const ScalarResult& want,
                       bool clip) {
        // Beyond the rims rays may fly far: there the error is relative.
        const double size = clip ? 1.0 : 1.0 + got.sensor_mm.length();
        const double error = std::hypot(got.sensor_mm.x - static_cast<double>(want.x_mm),
                                        got.sensor_mm.y - static_cast<double>(want.y_mm));
        if (clip) worst_mm = std::max(worst_mm, error);
        EXPECT_LT(error, kPlace_mm * size);
    }

    void CompareWhatWasMet(const InteractionList& list, const TraceResult& got,
                           const ScalarResult& want) {
        EXPECT_NEAR(got.path_mm, static_cast<double>(want.path_mm), 1e-9);
        for (std::size_t i = 0; i < want.cos_in.size(); ++i) {
            // The stop's cosine is not used.
            if (list.steps[i].kind == InteractionKind::kStop) continue;
            EXPECT_NEAR(record_.cos_in[i], static_cast<double>(want.cos_in[i]), 1e-11);
        }
        ASSERT_EQ(record_.stop_mm.size(), want.stops.size());
        for (std::size_t i = 0; i < want.stops.size(); ++i) {
            EXPECT_NEAR(record_.stop_mm[i].x, static_cast<double>(want.stops[i].x), kPlace_mm);
            EXPECT_NEAR(record_.stop_mm[i].y, static_cast<double>(want.stops[i].y), kPlace_mm);
        }
        const double weight = PathWeight(lens_, list, record_);
        const auto wanted = static_cast<double>(want.weight);
        EXPECT_NEAR(weight, wanted, 1e-12);
        // Weights of four reflections are small themselves.
        if (wanted > 0.0) worst_weight = std::max(worst_weight, std::abs(weight / wanted - 1.0));
        EXPECT_NEAR(weight, wanted, 1e-10 * wanted);
    }

    const Lens& lens_;
    RayRecord record_;
};

BounceSequence RandomSequence(const std::vector<std::vector<BounceSequence>>& sequences,
                              Random& random, int round) {
    // As many of two as of four; one in nine is the direct path.
    if (round % 9 == 0) return {};
    const std::vector<BounceSequence>& all = sequences[static_cast<std::size_t>(round % 2)];
    return all[static_cast<std::size_t>(random.Below(static_cast<int>(all.size())))];
}

// A thousand rays, ten a sequence and light.
void CompareAThousandRays(const Lens& lens, Random& random, Comparison& comparison) {
    constexpr int kRounds = 100, kRays = 10;
    const std::vector<std::vector<BounceSequence>> sequences = {
        TwoReflectionSequences(lens, true), FourReflectionSequences(lens, true)};
    const bool fisheye = lens.prescription().fisheye;
    // Telephotos see but a few degrees.
    const double widest = fisheye ? RadiansFromDegrees(100.0)
                                  : std::min(0.35, std::atan(20.0 / lens.first_order().efl_mm));
    for (int round = 0; round < kRounds; ++round) {
        const BounceSequence sequence = RandomSequence(sequences, random, round);
        const double field = random.Uniform(0.0, widest);
        const double inverse_distance = round % 3 == 0 ? 1.0 / random.Uniform(800.0, 5000.0) : 0.0;
        const double wavelength = random.Uniform(400.0, 700.0);
        const double azimuth = lens.rotational() ? 0.0 : random.Uniform(0.0, 0.5 * kPi);
        const LightBundle bundle(lens, field, inverse_distance, azimuth);
        const InteractionList list = WriteOut(lens, sequence, wavelength);
        const auto surfaces = testing::ScalarSurfaces(lens.prescription(), wavelength);
        const auto chief = FindChiefRay(lens, bundle, wavelength);
        for (int k = 0; k < kRays; ++k) {
            // Most of them where the entrance pupil is, so that many get through.
            const bool anywhere = k % 4 == 0 || !chief;
            const double reach =
                anywhere ? bundle.half_width() : 0.5 * lens.first_order().entrance.diameter_mm;
            const double u =
                (anywhere ? bundle.centre_u() : chief->u) + random.Uniform(-reach, reach);
            const double v = (anywhere ? 0.0 : chief->v) + random.Uniform(-reach, reach);
            SCOPED_TRACE("round " + std::to_string(round) + " ray " + std::to_string(k) + " of " +
                         ::testing::PrintToString(sequence));
            ASSERT_NO_FATAL_FAILURE(comparison.Compare(list, sequence, surfaces, bundle.At(u, v)));
        }
    }
}

class SecondTracer : public ::testing::TestWithParam<std::string> {};

TEST_P(SecondTracer, AgreesOnFatePlaceAndWeightOfEveryRay) {
    const auto base = BareLens(GetParam());
    Random random(17);
    const StateTable& states = base->prescription().states;
    for (const bool in_state : {false, true}) {
        if (in_state && states.empty()) break;
        auto lens = base;
        if (in_state) {
            const Result<LensInState> set = SetState(base, RandomState(states, random));
            ASSERT_TRUE(set.ok());
            lens = set->lens;
        }
        SCOPED_TRACE(in_state ? "in a random state" : "as it stands");
        Comparison seen(*lens);
        ASSERT_NO_FATAL_FAILURE(CompareAThousandRays(*lens, random, seen));
        // The comparison must have seen rays of every common sort.
        EXPECT_GT(seen.arrived[0], 10);
        EXPECT_GT(seen.arrived[1] + seen.arrived[2], 20);
        EXPECT_GT(seen.fates[static_cast<int>(RayFate::kVignetted)], 50);
        EXPECT_LT(seen.undecided, 3);
        const std::string state = in_state ? "_in_state" : "";
        RecordProperty("worst_mm" + state, ::testing::PrintToString(seen.worst_mm));
        RecordProperty("worst_weight" + state, ::testing::PrintToString(seen.worst_weight));
        RecordProperty("arrived" + state, ::testing::PrintToString(seen.arrived));
        RecordProperty("fates" + state, ::testing::PrintToString(seen.fates));
        RecordProperty("undecided" + state, seen.undecided);
    }
}

INSTANTIATE_TEST_SUITE_P(AllLenses, SecondTracer, ::testing::ValuesIn(LensNames()),
                         [](const auto& test) {
                             std::string name = test.param;
                             for (char& c : name) {
                                 if (c == '-') c = '_';
                             }
                             return name;
                         });

}  // namespace
}  // namespace flare
