// SPDX-License-Identifier: Apache-2.0
//
// Layers for single ghosts and lights, and an artist's hand on single ghosts: the parts add up to
// the whole, the whole is what it is without them, and a ghost is what was asked times itself.
#include <gtest/gtest.h>

#include "core/render/ghost_split.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::PlaneNamed;
using testing::Studio;
using testing::Sum;

FlareRequest Small(ColorMode color) {
    FlareRequest request;
    request.lens = testing::BuildLens(testing::SeedLens());
    request.f_number = 4.0;
    request.image.width = 64;
    request.image.height = 40;
    request.lights = {LightAt(7.0, 30.0)};
    request.quality = QualityPreset::kDraft;
    request.color = color;
    if (color == ColorMode::kSpectral) request.wavelengths_nm = {kLineD};
    return request;
}

bool HasPlane(const FlareImage& image, const std::string& name) {
    return std::any_of(image.planes.begin(), image.planes.end(),
                       [&](const ImagePlane& plane) { return plane.name == name; });
}

// The sum of all planes whose names begin and end so.
std::vector<double> SumOf(const FlareImage& image, const std::string& begin,
                          const std::string& end) {
    std::vector<double> sum(image.planes[0].values.size(), 0.0);
    for (const ImagePlane& plane : image.planes) {
        if (!plane.name.starts_with(begin) || !plane.name.ends_with(end)) continue;
        if (plane.name == begin + end.substr(1)) continue;
        for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += static_cast<double>(plane.values[k]);
    }
    return sum;
}

TEST(SplitLayers, OfSingleGhostsAddUpToTheGhosts) {
    for (const ColorMode color : {ColorMode::kLinRec709, ColorMode::kSpectral}) {
        Studio studio;
        FlareRequest request = Small(color);
        // Two lights: a layer gathers both.
        if (color == ColorMode::kSpectral) request.lights.push_back(LightAt(4.0, 200.0));
        const FlareImage whole = studio.Shoot(request).image;
        request.split = SplitBy::kGhost;
        const Rendering split = studio.Shoot(request);
        const std::string channel = color == ColorMode::kSpectral ? ".S0.587,5618nm" : ".G";
        EXPECT_TRUE(HasPlane(split.image, "ghosts.9_1" + channel));
        EXPECT_EQ(PlaneNamed(split.image, "ghosts" + channel).values,
                  PlaneNamed(whole, "ghosts" + channel).values);
        const std::vector<double> sum = SumOf(split.image, "ghosts.", channel);
        const PlaneValues& ghosts = PlaneNamed(whole, "ghosts" + channel).values;
        double all = 0.0;
        for (const float value : ghosts) all += static_cast<double>(value);
        const double mean = all / static_cast<double>(ghosts.size());
        ASSERT_GT(mean, 0.0);
        for (std::size_t k = 0; k < sum.size(); ++k) {
            EXPECT_NEAR(sum[k], static_cast<double>(ghosts[k]),
                        3e-6 * (std::abs(static_cast<double>(ghosts[k])) + mean));
        }
    }
}

TEST(SplitLayers, OfSingleLightsAreTheirPicturesAndAddUpToAll) {
    Studio studio;
    FlareRequest request = Small(ColorMode::kLinRec709);
    request.lens = testing::BuildLens(testing::PlanoConvex());
    request.layers = {true, true, true};
    request.lights.push_back(LightAt(4.0, 200.0));
    const Rendering whole = studio.Shoot(request);
    request.split = SplitBy::kLight;
    const Rendering split = studio.Shoot(request);
    ASSERT_EQ(split.image.planes.size(), 12U + 2U * 3U);
    EXPECT_EQ(split.report.facts.ghosts.front().flux_mm2,
              whole.report.facts.ghosts.front().flux_mm2);
    for (std::size_t p = 0; p < 12; ++p) {
        const ImagePlane& plane = split.image.planes[p];
        EXPECT_EQ(plane.name, whole.image.planes[p].name);
        for (std::size_t k = 0; k < plane.values.size(); ++k) {
            const float value = whole.image.planes[p].values[k];
            EXPECT_NEAR(plane.values[k], value, 3e-6F * std::abs(value) + 1e-9F) << plane.name;
        }
    }
    request.split = SplitBy::kNone;
    for (std::size_t n = 0; n < 2; ++n) {
        FlareRequest one = request;
        one.lights = {request.lights[n]};
        const FlareImage alone = studio.Shoot(one).image;
        const ImagePlane& part = PlaneNamed(split.image, "light" + std::to_string(n) + ".R");
        for (std::size_t k = 0; k < part.values.size(); ++k) {
            const float value = alone.planes[0].values[k];
            EXPECT_NEAR(part.values[k], value, 3e-6F * std::abs(value) + 1e-9F);
        }
    }
}

TEST(SplitLayers, AreRefusedWhereTheyWouldNotFit) {
    FlareRequest request = Small(ColorMode::kLinRec709);
    request.split = SplitBy::kGhost;
    // A lens of 45 ghosts, all drawn; the most at this size is 256 layers, at 8 million pixels 16.
    request.model.culling = CullingRule::kNone;
    request.image.width = 4096;
    request.image.height = 2048;
    const RenderScene large(request);
    EXPECT_FALSE(CheckSplitLayers(large, 16));
    const std::optional<Error> error = CheckSplitLayers(large, 17);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, "limit");
    EXPECT_EQ(error->where, "/split");
    request.image.width = 64;
    const RenderScene small(request);
    EXPECT_FALSE(CheckSplitLayers(small, 256));
    EXPECT_TRUE(CheckSplitLayers(small, 257));

    request.layers = {false, true, false};
    EXPECT_EQ(CheckRequest(request)->where, "/split");
    request.layers = {};
    request.split = SplitBy::kLight;
    request.lights.assign(257, LightAt(1.0));
    EXPECT_EQ(CheckRequest(request)->where, "/split");
}

TEST(Artist, MakesAGhostBrighterColouredAndNoOther) {
    Studio studio;
    FlareRequest request = Small(ColorMode::kLinRec709);
    request.split = SplitBy::kGhost;
    const FlareImage plain = studio.Shoot(request).image;
    request.artist = {{{9, 1}, 2.0, Vec3d(1.0, 0.5, 0.25), false}};
    const FlareImage changed = studio.Shoot(request).image;
    const std::pair<const char*, float> kChannels[] = {{"R", 2.0F}, {"G", 1.0F}, {"B", 0.5F}};
    for (const auto& channel : kChannels) {
        const std::string ghost = std::string("ghosts.9_1.") + channel.first;
        const PlaneValues& before = PlaneNamed(plain, ghost).values;
        EXPECT_GT(Sum(PlaneNamed(plain, ghost)), 0.0);
        const double mean = Sum(PlaneNamed(plain, ghost)) / static_cast<double>(before.size());
        for (std::size_t k = 0; k < before.size(); ++k) {
            const double want = static_cast<double>(channel.second * before[k]);
            EXPECT_NEAR(static_cast<double>(PlaneNamed(changed, ghost).values[k]), want,
                        1e-4 * (std::abs(want) + std::abs(mean)));
        }
        const std::string other = std::string("ghosts.8_4.") + channel.first;
        EXPECT_EQ(PlaneNamed(changed, other).values, PlaneNamed(plain, other).values);
    }
}

TEST(Artist, MutesAGhostAndKeepsAFaintOneAtWill) {
    Studio studio;
    FlareRequest request = Small(ColorMode::kLinRec709);
    request.split = SplitBy::kGhost;
    const Rendering plain = studio.Shoot(request);
    // One that preview culls, and one that it draws.
    const auto culled = std::find_if(
        plain.report.facts.ghosts.begin(), plain.report.facts.ghosts.end(),
        [](const GhostFacts& ghost) { return ghost.model == "culled" && ghost.flux_mm2 > 1e-9; });
    ASSERT_NE(culled, plain.report.facts.ghosts.end());
    const std::string faint = "ghosts." + SequenceLabel(culled->sequence) + ".G";
    EXPECT_FALSE(HasPlane(plain.image, faint));
    EXPECT_TRUE(HasPlane(plain.image, "ghosts.9_1.G"));
    request.artist = {{{9, 1}, 1.0, Vec3d(1.0, 1.0, 1.0), true},
                      {culled->sequence, 1.0, Vec3d(1.0, 1.0, 1.0), false}};
    const Rendering changed = studio.Shoot(request);
    EXPECT_FALSE(HasPlane(changed.image, "ghosts.9_1.G"));
    EXPECT_TRUE(HasPlane(changed.image, faint));
    const auto muted_facts =
        std::find_if(changed.report.facts.ghosts.begin(), changed.report.facts.ghosts.end(),
                     [](const GhostFacts& ghost) {
                         return ghost.sequence == BounceSequence{9, 1};
                     });
    EXPECT_EQ(muted_facts->model, "muted");
    const double before = Sum(PlaneNamed(plain.image, "G"));
    const double muted = Sum(PlaneNamed(plain.image, "ghosts.9_1.G"));
    const double kept = Sum(PlaneNamed(changed.image, faint));
    // What is culled and dimmed goes by the ghosts that are left.
    EXPECT_NEAR(Sum(PlaneNamed(changed.image, "G")), before - muted + kept, 0.02 * before);
}

TEST(Artist, MayOnlyNameGhostsOfTheLens) {
    FlareRequest request = Small(ColorMode::kLinRec709);
    const auto where = [&](ArtistGhost ghost) {
        request.artist = {std::move(ghost)};
        const std::optional<Error> error = CheckRequest(request);
        return error ? error->where : "";
    };
    EXPECT_EQ(where({{9, 1}}), "");
    for (const std::vector<int>& wrong : std::vector<std::vector<int>>{
             {}, {9}, {1, 9}, {9, 9}, {99, 1}, {9, 5}, {9, 1, 4, 2}, {9, -1}}) {
        EXPECT_EQ(where({wrong}), "/artist/ghosts/0/sequence");
    }
    request.model.reflections = 4;
    EXPECT_EQ(where({{9, 1, 4, 2}}), "");
    EXPECT_EQ(where({{9, 1, 4, 4}}), "/artist/ghosts/0/sequence");
    EXPECT_EQ(where({{9, 1}, -1.0}), "/artist/ghosts/0/gain");
    EXPECT_EQ(where({{9, 1}, 1.0, Vec3d(1.0, -1.0, 1.0)}), "/artist/ghosts/0/tint");
    request.artist = {{{9, 1}}, {{9, 1}}};
    EXPECT_EQ(CheckRequest(request)->where, "/artist/ghosts/1/sequence");
    request.layers = {false, true, false};
    EXPECT_EQ(CheckRequest(request)->where, "/artist");
    request = Small(ColorMode::kSpectral);
    EXPECT_EQ(where({{9, 1}, 2.0}), "");
    EXPECT_EQ(where({{9, 1}, 2.0, Vec3d(1.0, 0.5, 1.0)}), "/artist/ghosts/0/tint");
}

}  // namespace
}  // namespace flare
