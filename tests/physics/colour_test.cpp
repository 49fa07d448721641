// SPDX-License-Identifier: Apache-2.0
//
// Colour: three traced wavelengths stand for all in place, not in transmittance; transmittances at
// any wavelength come from the cosines that a mesh keeps; the bands of the sum lose no light.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/mesh/transmission.h"
#include "core/render/quality.h"
#include "core/spectrum/wavelength_plan.h"
#include "core/tracing/chief_ray.h"
#include "core/tracing/light_bundle.h"
#include "core/tracing/trace_reference.h"
#include "tests/support/lenses.h"
#include "tests/support/random.h"

namespace flare {
namespace {

constexpr double kPixel_mm = 0.01875;

TEST(BandShares, AddUpToTheLightsOwnColour) {
    for (const Vec3d& rgb : {Vec3d(1.0, 1.0, 1.0), Vec3d(3.0, 0.2, 0.0), Vec3d(0.0, 0.0, 5.0)}) {
        const Spectrum power = LightSpectrum(rgb);
        for (const int drawn : {2, 5, 24}) {
            Vec3d sum(0.0, 0.0, 0.0);
            for (const BandShare& share : BandShares(EvenInDispersion(400.0, 700.0, drawn),
                                                     EvenInWavelength(380.0, 780.0, 21), power)) {
                EXPECT_GE(share.drawn, 0);
                EXPECT_LT(share.drawn, drawn);
                EXPECT_GE(share.colour, 0);
                EXPECT_LT(share.colour, 21);
                sum += share.rgb;
            }
            EXPECT_NEAR(sum.x, rgb.x, 1e-12);
            EXPECT_NEAR(sum.y, rgb.y, 1e-12);
            EXPECT_NEAR(sum.z, rgb.z, 1e-12);
        }
    }
}

// A filter that lets through what lies above 600 nm turns white light into the sum over those
// samples.
TEST(BandShares, IntegrateATransmittanceThatIsLinearBetweenBands) {
    const Spectrum power = LightSpectrum(Vec3d(1.0, 1.0, 1.0));
    const std::vector<double> colour = EvenInWavelength(380.0, 780.0, 81);
    const auto transmittance = [](double nm) { return (nm - 380.0) / 400.0; };
    Vec3d banded(0.0, 0.0, 0.0), direct(0.0, 0.0, 0.0);
    for (const BandShare& s : BandShares(EvenInDispersion(400.0, 700.0, 7), colour, power)) {
        banded += s.rgb * transmittance(colour[static_cast<std::size_t>(s.colour)]);
    }
    for (int i = 0; i < kSpectrumSamples; ++i) {
        const auto k = static_cast<std::size_t>(i);
        direct += Rec709Response()[k] * (power[k] * transmittance(SampleWavelength(i)));
    }
    EXPECT_NEAR((banded - direct).length(), 0.0, 1e-6);
    EXPECT_GT(direct.x, 1.5 * direct.z);
}

// Distances in pixels between exact and interpolated places, over all ghosts, for random rays that
// land within 22 mm of the axis.
std::vector<double> InterpolationErrors(const Lens& lens, int rays) {
    const std::vector<double> nodes = ChebyshevNodes(kTracedLow_nm, kTracedHigh_nm, 3);
    testing::Random random(11);
    std::vector<double> errors;
    const LightBundle bundle(lens, RadiansFromDegrees(5.0), 0.0);
    for (const BounceSequence& sequence : TwoReflectionSequences(lens)) {
        std::vector<InteractionList> lists;
        for (const double nm : nodes) lists.push_back(WriteOut(lens, sequence, nm));
        for (int k = 0; k < rays; ++k) {
            const Ray ray = bundle.At(bundle.centre_u() + random.Uniform(-13.0, 13.0),
                                      random.Uniform(-13.0, 13.0));
            const double nm = random.Uniform(kDrawnLow_nm, kDrawnHigh_nm);
            const TraceResult exact = TraceRay(WriteOut(lens, sequence, nm), ray, {}, nullptr);
            if (exact.fate != RayFate::kArrived || exact.sensor_mm.length() > 22.0) continue;
            const std::vector<double> weights = NodeWeights(nodes, nm);
            Vec2d place(0.0, 0.0);
            bool alive = true;
            for (std::size_t n = 0; n < nodes.size(); ++n) {
                const TraceResult node = TraceRay(lists[n], ray, {false, nullptr, false}, nullptr);
                alive = alive && node.fate == RayFate::kArrived;
                place += node.sensor_mm * weights[n];
            }
            if (alive) errors.push_back((place - exact.sensor_mm).length() / kPixel_mm);
        }
    }
    std::sort(errors.begin(), errors.end());
    return errors;
}

TEST(ThreeTracedWavelengths, PlaceEveryGhostOfTheSeedLensWithinAFiftiethOfAPixel) {
    const auto lens = testing::LibraryLens(testing::kSeedName);
    const std::vector<double> errors = InterpolationErrors(*lens, 300);
    ASSERT_GT(errors.size(), 1000U);
    RecordProperty("worst_px", std::to_string(errors.back()));
    EXPECT_LT(errors.back(), 0.02);
}

// A lens with a ghost that disperses far more (11,9): nearly all rays as above, the worst within a
// quarter of a pixel.
TEST(ThreeTracedWavelengths, ServeForStrongDispersionToo) {
    const auto lens = testing::LibraryLens(testing::kRetrofocusName);
    const std::vector<double> errors = InterpolationErrors(*lens, 1000);
    ASSERT_GT(errors.size(), 1000U);
    RecordProperty("worst_px", std::to_string(errors.back()));
    EXPECT_LT(errors[errors.size() * 95 / 100], 0.02);
    EXPECT_LT(errors.back(), 0.25);
}

TEST(ThreeTracedWavelengths, DoNotServeForTransmittances) {
    // The reason why transmittance is worked out at every band: through the same nodes the weight
    // of a coated ghost is off by far more than a per cent.
    const auto lens = testing::LibraryLens(testing::kSeedName);
    const std::vector<double> nodes = ChebyshevNodes(kTracedLow_nm, kTracedHigh_nm, 3);
    const Ray axis{Vec3d(0.0, 0.0, -1.0), Vec3d(0.0, 0.0, 1.0)};
    const auto weight = [&](double nm) {
        const InteractionList list = WriteOut(*lens, {10, 9}, nm);
        RayRecord record;
        TraceRay(list, axis, {}, &record);
        return PathWeight(*lens, list, record);
    };
    double interpolated = 0.0;
    const std::vector<double> shares = NodeWeights(nodes, 430.0);
    for (std::size_t n = 0; n < nodes.size(); ++n) interpolated += shares[n] * weight(nodes[n]);
    EXPECT_GT(std::abs(interpolated / weight(430.0) - 1.0), 0.01);
}

// The mesh keeps the squared cosine on the rarer side; the tables must give back the exact weight.
TEST(TransmissionTables, GiveTheWeightOfTheExactlyTracedRay) {
    ThreadPool threads(2);
    for (const char* name : {testing::kSeedName, testing::kFisheyeName}) {
        const auto coated = testing::LibraryLens(name);
        for (const auto& lens : {coated, coated->WithBareGlass()}) {
            const std::vector<double> wavelengths{400.0, 530.0, 690.0};
            const TransmissionTables tables(*lens, wavelengths, threads);
            testing::Random random(23);
            const std::vector<BounceSequence> sequences = TwoReflectionSequences(*lens);
            int compared = 0;
            for (int round = 0; round < 200; ++round) {
                const BounceSequence& sequence = sequences[static_cast<std::size_t>(
                    random.Below(static_cast<int>(sequences.size())))];
                const TransmissionTables::Path path = tables.PathOf(*lens, sequence);
                const LightBundle bundle(*lens, random.Uniform(0.0, 0.5), 0.0);
                const auto chief = FindChiefRay(*lens, bundle, kLineD);
                ASSERT_TRUE(chief.has_value());
                const int band = random.Below(3);
                const double nm = wavelengths[static_cast<std::size_t>(band)];
                const InteractionList list = WriteOut(*lens, sequence, nm);
                RayRecord record;
                for (int k = 0; k < 20; ++k) {
                    const double reach = 0.6 * lens->first_order().entrance.diameter_mm;
                    const Ray ray = bundle.At(chief->u + random.Uniform(-reach, reach),
                                              random.Uniform(-reach, reach));
                    const TraceResult result =
                        TraceRay(list, ray, {false, nullptr, false}, &record);
                    if (result.fate != RayFate::kArrived) continue;
                    std::vector<double> rare_cos2;
                    for (std::size_t i = 0; i < record.cos_in.size(); ++i) {
                        const Interaction& step = list.steps[i];
                        const double c2 = record.cos_in[i] * record.cos_in[i];
                        const double ratio = step.n_in / step.n_out;
                        rare_cos2.push_back(ratio <= 1.0 ? c2 : 1.0 - ratio * ratio * (1.0 - c2));
                    }
                    ++compared;
                    const double exact = PathWeight(*lens, list, record);
                    // Two reflectances of 1e-7 each at worst: 1e-7 of the stronger one.
                    EXPECT_NEAR(path.Weight(band, rare_cos2), exact,
                                1e-6 * exact + 2e-7 * std::sqrt(exact))
                        << name << " " << sequence[0] << "," << sequence[1];
                }
            }
            EXPECT_GT(compared, 300);
        }
    }
}

}  // namespace
}  // namespace flare
