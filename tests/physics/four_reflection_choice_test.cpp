// SPDX-License-Identifier: Apache-2.0
//
// Ghosts of four reflections: all their light, by counted rays; those chosen against the peaks that
// a raster of every ghost shows; and what a picture gains by them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "core/base/units.h"
#include "core/render/ghost_choice.h"
#include "core/render/ghost_list.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::Studio;

struct Light {
    PlacedLight placed;
    Iris iris;
};

Light WideOpen(const Lens& lens, double field_deg) {
    const double rim =
        lens.surfaces()[static_cast<std::size_t>(lens.stop_index())].semi_diameter_mm;
    Light light{{}, Iris({}, rim, rim)};
    light.placed.field_rad = RadiansFromDegrees(field_deg);
    light.placed.pose = PoseOf(lens, 0.0);
    return light;
}

GhostChoice Chosen(const Lens& lens, double field_deg, double threshold, Studio& studio) {
    ModelSpec model;
    model.reflections = 4;
    model.four_reflection_threshold = threshold;
    const Light light = WideOpen(lens, field_deg);
    const auto choice =
        ChooseFourReflections(lens, model, light.iris, light.placed, studio.Context());
    FLARE_CHECK(choice.ok());
    return *choice;
}

// By a grid of clipped rays over the beam, the same few for every sequence: single ghosts are
// poorly counted, their sum well.
double Counted(const Lens& lens, double field_deg, const std::vector<BounceSequence>& sequences) {
    constexpr int kSide = 72;
    const LightBundle bundle(lens, RadiansFromDegrees(field_deg), 0.0);
    const double step = 2.0 * bundle.half_width() / kSide;
    std::vector<double> sums(sequences.size());
    ThreadPool threads(2);
    threads.For(static_cast<int>(sequences.size()), [&](int item) {
        const auto n = static_cast<std::size_t>(item);
        const InteractionList list = WriteOut(lens, sequences[n], kLineD);
        RayRecord record;
        for (int j = 0; j < kSide / 2; ++j) {
            for (int i = 0; i < kSide; ++i) {
                const double shift = static_cast<double>((j * 7 + item * 5) % 16) / 16.0;
                const Ray ray = bundle.At(
                    bundle.centre_u() - bundle.half_width() + (i + shift) * step, (j + 0.5) * step);
                if (TraceRay(list, ray, {}, &record).fate != RayFate::kArrived) continue;
                sums[n] += 2.0 * step * step * PathWeight(lens, list, record);
            }
        }
    });
    double sum = 0.0;
    for (const double s : sums) sum += s;
    return sum;
}

TEST(FourReflectionChoice, OfTheBareSeedLensHoldTheLightOfCountedRays) {
    const auto lens = testing::LibraryLens(testing::kSeedName)->WithBareGlass();
    const std::vector<BounceSequence> all = FourReflectionSequences(*lens);
    EXPECT_EQ(all.size(), 1695U);
    Studio studio;
    for (const double field_deg : {0.0, 5.0}) {
        const GhostChoice choice = Chosen(*lens, field_deg, 1e-3, studio);
        EXPECT_EQ(choice.facts.sequences, 1695U);
        EXPECT_EQ(choice.facts.rendered, choice.sequences.size());
        EXPECT_GT(choice.facts.rendered_flux_mm2, 0.0);
        EXPECT_GT(choice.facts.lost_flux_mm2, 0.0);
        const double four = Counted(*lens, field_deg, all);
        const double two = Counted(*lens, field_deg, TwoReflectionSequences(*lens));
        // Sequences that are dropped by first-order optics are added up by it.
        EXPECT_NEAR(choice.facts.rendered_flux_mm2 + choice.facts.lost_flux_mm2, four, 0.03 * four)
            << field_deg;
        if (field_deg == 0.0) {
            EXPECT_NEAR(two, 15.49, 0.01 * 15.49);
            EXPECT_NEAR(four / two, 0.0436, 0.001);
        }
        std::printf(
            "%g deg: four %.4f mm2, %.2f %% of two; rendered %zu with %.4f mm2, lost %.4f\n",
            field_deg, four, 100.0 * four / two, choice.sequences.size(),
            choice.facts.rendered_flux_mm2, choice.facts.lost_flux_mm2);
    }
}

// Fast and simple: two equal biconvex lenses about a stop, 41 sequences.
std::shared_ptr<const Lens> TwoLenses() {
    return testing::BuildLens(testing::Assemble(
        "two-lenses",
        {testing::Sphere(60.0, 7.0, 1.6, 60.0, 15.0), testing::Sphere(-90.0, 4.0, 1.0, 0.0, 15.0),
         testing::Stop(4.0, 11.0), testing::Sphere(80.0, 7.0, 1.6, 60.0, 15.0),
         testing::Sphere(-70.0, 0.0, 1.0, 0.0, 15.0)}));
}

TEST(FourReflectionChoice, ThatAreChosenAreThoseWhosePeakReachesTheThreshold) {
    const auto lens = TwoLenses();
    Studio studio;
    for (const double field_deg : {0.0, 4.0}) {
        GhostListOptions options;
        options.field_deg = field_deg;
        options.model.reflections = 4;
        options.model.four_reflection_threshold = 1e-30;
        const auto list = RankGhosts(lens, options, studio.Context());
        ASSERT_TRUE(list.ok());
        std::size_t fours = 0;
        double brightest = 0.0;
        for (const GhostEntry& ghost : list->ghosts) {
            if (ghost.sequence.size() != 4 || ghost.flux_mm2 == 0.0) continue;
            ++fours;
            brightest = std::max(brightest, ghost.peak_irradiance);
        }
        EXPECT_GT(fours, 25U);
        std::size_t before = 0;
        for (const double threshold : {0.3 * brightest, 1e-3, 1e-4, 1e-5, 1e-6}) {
            const GhostChoice choice = Chosen(*lens, field_deg, threshold, studio);
            const std::set<BounceSequence> chosen(choice.sequences.begin(), choice.sequences.end());
            EXPECT_GE(chosen.size(), before) << "a lower threshold chooses more";
            before = chosen.size();
            for (const GhostEntry& ghost : list->ghosts) {
                if (ghost.sequence.size() != 4) continue;
                const bool in = chosen.count(ghost.sequence) > 0;
                const double over = ghost.peak_irradiance / threshold;
                EXPECT_TRUE(in || over < 2.0)
                    << field_deg << ": peak " << ghost.peak_irradiance << " at " << threshold;
                EXPECT_TRUE(!in || over > 0.2)
                    << field_deg << ": peak " << ghost.peak_irradiance << " at " << threshold;
            }
        }
        EXPECT_GT(before, 5U);
    }
}

TEST(FourReflectionChoice, AddTheirLightToThePicture) {
    const auto lens = TwoLenses();
    Studio studio;
    constexpr double kFrame_mm = 10000.0;  // all light lands on it
    FlareRequest request = testing::SpectralRequest(lens, lens->f_number(), 60, 60);
    request.image.sensor_width_mm = kFrame_mm;
    request.lights = {LightAt(4.0, 20.0)};
    const auto light = [&](const Rendering& rendering) {
        const double pitch = kFrame_mm / 60.0;
        return testing::Sum(rendering.image.planes[0]) * pitch * pitch;
    };
    const Rendering two = studio.Shoot(request);
    EXPECT_FALSE(two.report.facts.four_reflections.has_value());
    request.model.reflections = 4;
    request.model.four_reflection_threshold = 1e-5;
    const Rendering four = studio.Shoot(request);
    ASSERT_TRUE(four.report.facts.four_reflections.has_value());
    const FourReflectionFacts facts = *four.report.facts.four_reflections;
    const double gained = light(four) - light(two);
    EXPECT_GT(gained, 0.0);
    EXPECT_NEAR(gained, facts.rendered_flux_mm2, 0.02 * gained);
    // What is rendered and what is left out are all there is.
    const double all = Counted(*lens, 4.0, FourReflectionSequences(*lens));
    EXPECT_NEAR(facts.rendered_flux_mm2 + facts.lost_flux_mm2, all, 0.03 * all);
    EXPECT_EQ(four.report.facts.culled_flux_mm2, facts.lost_flux_mm2);
    EXPECT_EQ(four.report.facts.ghosts.size(), two.report.facts.ghosts.size() + facts.rendered);
    for (std::size_t g = two.report.facts.ghosts.size(); g < four.report.facts.ghosts.size(); ++g) {
        EXPECT_EQ(four.report.facts.ghosts[g].sequence.size(), 4U);
        EXPECT_GT(four.report.facts.ghosts[g].flux_mm2, 0.0);
    }
}

// Each light has its own; the report adds them up.
TEST(FourReflectionChoice, AreChosenForEachLight) {
    const auto lens = TwoLenses();
    Studio studio;
    FlareRequest request = testing::SpectralRequest(lens, lens->f_number(), 24, 16);
    request.quality = QualityPreset::kDraft;
    request.model.reflections = 4;
    request.model.four_reflection_threshold = 1e-4;
    const auto facts = [&](std::vector<LightSpec> lights) {
        request.lights = std::move(lights);
        return *studio.Shoot(request).report.facts.four_reflections;
    };
    const FourReflectionFacts one = facts({LightAt(0.0)}), other = facts({LightAt(6.0, 90.0)});
    const FourReflectionFacts both = facts({LightAt(0.0), LightAt(6.0, 90.0)});
    EXPECT_NEAR(both.rendered_flux_mm2, one.rendered_flux_mm2 + other.rendered_flux_mm2, 1e-12);
    EXPECT_NEAR(both.lost_flux_mm2, one.lost_flux_mm2 + other.lost_flux_mm2, 1e-12);
    EXPECT_GE(both.rendered, std::max(one.rendered, other.rendered));
    EXPECT_LE(both.rendered, one.rendered + other.rendered);
    EXPECT_EQ(both.sequences, one.sequences);
}

}  // namespace
}  // namespace flare
