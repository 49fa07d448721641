// SPDX-License-Identifier: Apache-2.0
//
// The colour of coated lenses' ghosts: transmittances at the renderer's colour bands and its sum
// over them, against the characteristic matrix at every 5 nm and the plain sum over the spectrum.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "core/base/units.h"
#include "core/mesh/transmission.h"
#include "core/optics/lens_coatings.h"
#include "core/render/quality.h"
#include "core/spectrum/wavelength_plan.h"
#include "tests/support/lenses.h"

namespace flare {
namespace {

// The product of R and T along a path, straight from the matrix; every face is met at the same
// angle in its rarer medium.
double ExactWeight(const Lens& lens, const BounceSequence& sequence, double rare_cos,
                   double wavelength) {
    double weight = 1.0;
    for (const Interaction& step : WriteOut(lens, sequence, wavelength).steps) {
        if (step.kind == InteractionKind::kStop) continue;
        const double ratio = std::min(1.0, step.n_out / step.n_in);
        const double c = std::sqrt(1.0 - ratio * ratio * (1.0 - rare_cos * rare_cos));
        const Reflection r = ReflectionAt(lens, step, c, wavelength);
        weight *= step.kind == InteractionKind::kReflect ? r.reflectance : r.transmittance;
    }
    return weight;
}

// The light of a path in Rec.709: `smear_nm` 1, each 5 nm sample at its own wavelength; 5, each as
// a triangle of 1 nm steps to its neighbours, which is what a spectrum that is straight in between
// holds. Beyond the ends there is nothing to know.
Vec3d SpectralSum(const Lens& lens, const BounceSequence& sequence, double rare_cos, int smear_nm) {
    Vec3d rgb(0.0, 0.0, 0.0);
    for (int i = 0; i < kSpectrumSamples; ++i) {
        const auto s = static_cast<std::size_t>(i);
        double weight = 0.0;
        for (int nm = -smear_nm + 1; nm < smear_nm; ++nm) {
            const double wavelength = std::clamp(SampleWavelength(i) + nm, 380.0, 780.0);
            weight += (smear_nm - std::abs(nm)) *
                      ExactWeight(lens, sequence, rare_cos, wavelength) / (smear_nm * smear_nm);
        }
        rgb += Rec709Response()[s] * (WhiteSpectrum()[s] * weight);
    }
    return rgb;
}

// What the renderer makes of it.
class BandSum {
  public:
    BandSum(const Lens& lens, int bands, ThreadPool& threads)
        : lens_(lens), tables_(lens, EvenInWavelength(380.0, 780.0, bands), threads) {
        shares_ = BandShares(EvenInDispersion(kDrawnLow_nm, kDrawnHigh_nm, 14),
                             tables_.wavelengths_nm(), WhiteSpectrum());
    }
    Vec3d Of(const BounceSequence& sequence, double rare_cos) const {
        const TransmissionTables::Path path = tables_.PathOf(lens_, sequence);
        const std::vector<double> cos2(WriteOut(lens_, sequence, kLineD).steps.size(),
                                       rare_cos * rare_cos);
        Vec3d rgb(0.0, 0.0, 0.0);
        for (const BandShare& share : shares_) rgb += share.rgb * path.Weight(share.colour, cos2);
        return rgb;
    }

  private:
    const Lens& lens_;
    TransmissionTables tables_;
    std::vector<BandShare> shares_;
};

double Largest(const Vec3d& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

// One ghost in three, at three angles, and their exact colours.
struct Sample {
    BounceSequence sequence;
    double rare_cos = 1.0;
    Vec3d smeared, plain;
};

std::vector<Sample> Samples(const Lens& lens) {
    std::vector<Sample> samples;
    const std::vector<BounceSequence> sequences = TwoReflectionSequences(lens);
    for (std::size_t i = 0; i < sequences.size(); i += 3) {
        for (const double angle : {0.0, 25.0, 50.0}) {
            const double c = std::cos(RadiansFromDegrees(angle));
            samples.push_back({sequences[i], c, SpectralSum(lens, sequences[i], c, 5),
                               SpectralSum(lens, sequences[i], c, 1)});
        }
    }
    return samples;
}

// Of the worst ghost, relative to its strongest channel.
double WorstError(const BandSum& sum, const std::vector<Sample>& samples, Vec3d Sample::*truth) {
    double worst = 0.0;
    for (const Sample& sample : samples) {
        const Vec3d& want = sample.*truth;
        const Vec3d off = sum.Of(sample.sequence, sample.rare_cos) - want;
        worst = std::max(worst, Largest(off) / Largest(want));
    }
    return worst;
}

// How many colour bands a coating needs. The error is that of the bands alone: both sides hold the
// same integral. A stack of more layers has a steeper edge at the ends of the visible, where its
// ghosts have most of their light.
TEST(CoatedGhostColour, FollowsTheSpectrumWithEnoughBands) {
    struct Limit {
        const char* coating;
        double with_21, with_41, with_81;
    };
    ThreadPool threads(2);
    const auto seed = testing::LibraryLens(testing::kSeedName);
    for (const Limit& limit :
         {Limit{"mgf2-550", 3e-3, 3e-4, 3e-5}, Limit{"v-550", 6e-3, 5e-4, 5e-5},
          Limit{"broadband-550", 5e-2, 4e-3, 3e-4}, Limit{"multi-550", 0.5, 3e-2, 2e-3}}) {
        const auto lens = *seed->WithCoatings({limit.coating, {}, {}});
        const std::vector<Sample> samples = Samples(*lens);
        Vec3d all(0.0, 0.0, 0.0);
        for (const Sample& sample : samples) all += sample.smeared;
        all /= Largest(all);
        std::printf("%-14s light of all (%.2f, %.2f, %.2f); worst error with", limit.coating, all.x,
                    all.y, all.z);
        for (const auto& [bands, bound] :
             {std::pair(21, limit.with_21), {41, limit.with_41}, {81, limit.with_81}}) {
            const double error =
                WorstError(BandSum(*lens, bands, threads), samples, &Sample::smeared);
            std::printf("  %d bands %.1e", bands, error);
            EXPECT_LT(error, bound) << limit.coating << " " << bands;
        }
        std::printf("\n");
    }
}

// The plain sum over 5 nm samples is itself only so good: it takes the light between them for light
// at them.
TEST(CoatedGhostColour, OfABroadbandCoatIsThatOfAFiveNanometreSum) {
    ThreadPool threads(2);
    const auto seed = testing::LibraryLens(testing::kSeedName);
    const auto lens = *seed->WithCoatings({"broadband-550", {}, {}});
    const std::vector<Sample> samples = Samples(*lens);
    EXPECT_LT(WorstError(BandSum(*lens, 21, threads), samples, &Sample::plain), 5e-2);
    EXPECT_LT(WorstError(BandSum(*lens, 41, threads), samples, &Sample::plain), 1.5e-2);
}

}  // namespace
}  // namespace flare
