// SPDX-License-Identifier: Apache-2.0
//
// Pictures whose ghosts were kept are the pictures that are made without, to the last bit, and a
// ghost is not taken for another: whatever of a request changes, one keeper serves all of them.
#include <gtest/gtest.h>

#include <map>
#include <mutex>

#include "core/render/kept_ghost.h"
#include "core/render/source_picture.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;

class KeepsAll final : public RenderKeeper {
    std::shared_ptr<const void> FindValue(KeptKind, const Fingerprint& key) override {
        const std::lock_guard lock(mutex_);
        const auto known = values_.find(key);
        return known == values_.end() ? nullptr : known->second;
    }
    void KeepValue(const Fingerprint& key, std::shared_ptr<const void> value,
                   std::size_t bytes) override {
        EXPECT_GT(bytes, 0U);
        const std::lock_guard lock(mutex_);
        values_[key] = std::move(value);
    }

    std::mutex mutex_;
    std::map<Fingerprint, std::shared_ptr<const void>> values_;
};

class KeptGhosts : public ::testing::Test {
  protected:
    FlareRequest Seed() const {
        FlareRequest request;
        request.lens = testing::LibraryLens(testing::kSeedName);
        request.f_number = 11.0;
        request.image.width = 96;
        request.image.height = 54;
        request.lights = {LightAt(6.0, 30.0)};
        request.quality = QualityPreset::kDraft;
        return request;
    }

    // The picture with kept ghosts, which must be the one without; how many ghosts were kept.
    std::uint64_t Check(const FlareRequest& request) {
        const Rendering fresh = studio_.Shoot(request);
        RenderContext context = studio_.Context();
        context.keeper = &keeper_;
        const Result<Rendering> kept = Render(request, context);
        EXPECT_TRUE(kept);
        if (!kept) return 0;
        EXPECT_EQ(kept->image.planes.size(), fresh.image.planes.size());
        for (std::size_t p = 0; p < fresh.image.planes.size(); ++p) {
            EXPECT_TRUE(kept->image.planes[p].values == fresh.image.planes[p].values)
                << fresh.image.planes[p].name;
        }
        const Facts& a = kept->report.facts;
        const Facts& b = fresh.report.facts;
        EXPECT_EQ(a.estimated_error.rel_l1, b.estimated_error.rel_l1);
        EXPECT_EQ(a.culling.culled, b.culling.culled);
        EXPECT_EQ(a.ghosts.size(), b.ghosts.size());
        for (std::size_t g = 0; g < b.ghosts.size(); ++g) {
            EXPECT_EQ(a.ghosts[g].flux_mm2, b.ghosts[g].flux_mm2);
            EXPECT_EQ(a.ghosts[g].model, b.ghosts[g].model);
        }
        EXPECT_EQ(kept->report.work.mesh_hits + kept->report.work.mesh_misses,
                  fresh.report.work.mesh_hits + fresh.report.work.mesh_misses);
        return kept->report.work.ghost_hits;
    }

    testing::Studio studio_;
    KeepsAll keeper_;
};

TEST_F(KeptGhosts, GiveTheSamePictureAgain) {
    const FlareRequest request = Seed();
    EXPECT_EQ(Check(request), 0U);
    const std::uint64_t hits = Check(request);
    EXPECT_GT(hits, 20U);
    // A second light, and layers beside the sum, change nothing of the first light's ghosts.
    FlareRequest more = request;
    more.lights.push_back(LightAt(10.0, 200.0));
    EXPECT_EQ(Check(more), hits);
    more = request;
    more.split = SplitBy::kGhost;
    EXPECT_EQ(Check(more), hits);
    more = request;
    more.layers.starburst = true;
    EXPECT_EQ(Check(more), hits);
}

TEST_F(KeptGhosts, AreNotTakenForOthers) {
    EXPECT_EQ(Check(Seed()), 0U);
    const auto change = [&](auto edit) {
        FlareRequest request = Seed();
        edit(request);
        EXPECT_EQ(Check(request), 0U);
        EXPECT_GT(Check(request), 0U);
    };
    change([](FlareRequest& r) { r.lens = testing::LibraryLens("leica-summicron-50mm-f2"); });
    change([](FlareRequest& r) { r.lens = SetState(r.lens, {0.7, {}})->lens; });
    change([](FlareRequest& r) { r.f_number = 10.9; });
    change([](FlareRequest& r) { r.iris.blades = 7; });
    change([](FlareRequest& r) { r.iris = {7, 0.3}; });
    change([](FlareRequest& r) { r.iris = {7, 0.0, 5.0}; });
    change([](FlareRequest& r) { r.iris = {7, 0.0, 0.0, 0.2}; });
    change([](FlareRequest& r) { r.iris = {7, 0.0, 0.0, 0.2, 3}; });
    change([](FlareRequest& r) { r.image.width = 98; });
    change([](FlareRequest& r) { r.image.sensor_width_mm = 36.5; });
    change([](FlareRequest& r) { r.image.center_offset_mm = {0.1, 0.0}; });
    change([](FlareRequest& r) { r.image.pixel_aspect = 1.1; });
    change([](FlareRequest& r) { r.image.crop = {48, 8, 16, 16}; });
    change([](FlareRequest& r) { r.image.overscan = {80, 0, 8, 0}; });
    change([](FlareRequest& r) { r.lights = {LightAt(6.001, 30.0)}; });
    change([](FlareRequest& r) { r.lights = {LightAt(6.0, 31.0)}; });
    change([](FlareRequest& r) { r.lights[0].distance_m = 3.0; });
    change([](FlareRequest& r) { r.lights[0].irradiance = {1.0, 1.0, 0.9}; });
    change([](FlareRequest& r) { r.lights[0].temperature_k = 3200.0; });
    change([](FlareRequest& r) { r.model.ringing = true; });
    change([](FlareRequest& r) { r.color = ColorMode::kAcesCg; });
    change([](FlareRequest& r) { r.quality = QualityPreset::kPreview; });
    change([](FlareRequest& r) { r.quality = Quality::Tolerance(0.04); });
    // The ghosts that are drawn are the same; there are more of them.
    FlareRequest all = Seed();
    all.model.culling = CullingRule::kNone;
    EXPECT_GT(Check(all), 0U);
}

TEST_F(KeptGhosts, FollowTheShapeOfALight) {
    const auto shaped = [&](float dark) {
        FlareRequest request = Seed();
        request.lights[0].angular_diameter_deg = 0.3;
        request.lights[0].shape = SourcePicture::Of(2, 1, {1.0F, dark});
        return request;
    };
    for (const float dark : {0.0F, 0.5F, 0.0F}) Check(shaped(dark));
}

TEST_F(KeptGhosts, FollowWhatCanBeSeen) {
    FlareRequest request = Seed();
    request.model.ringing = true;
    Check(request);
    for (const double floor : {1e-4, 1e-2, 1.0, 1e-4}) {
        request.visible = VisibleSpec{0.0, floor};
        Check(request);
    }
}

TEST_F(KeptGhosts, FollowTheIrisesPicture) {
    const auto masked = [&](float shade) {
        StopGrid grid;
        grid.side = 16;
        grid.half_width_mm = 1.0;
        grid.values.assign(256, 1.0F);
        for (std::size_t k = 100; k < 108; ++k) grid.values[k] = shade;
        FlareRequest request = Seed();
        request.iris.mask = StopPicture::Sharp(std::move(grid));
        return request;
    };
    EXPECT_EQ(Check(masked(0.0F)), 0U);
    EXPECT_GT(Check(masked(0.0F)), 0U);  // read anew, the same values
    EXPECT_EQ(Check(masked(0.3F)), 0U);
}

TEST_F(KeptGhosts, ServeWhatOneArtistLeavesAlone) {
    const FlareRequest request = Seed();
    Check(request);
    const std::uint64_t hits = Check(request);
    FlareRequest graded = request;
    const BounceSequence first = TwoReflectionSequences(*request.lens).front();
    graded.artist = {{first, 2.0, {1.0, 0.5, 1.0}, false}};
    // It weighs more when others are culled, so that a few of those fade.
    const std::uint64_t left = Check(graded);
    EXPECT_LT(left, hits);
    EXPECT_GT(left, hits / 2);
    graded.artist = {{first, 1.0, {1.0, 1.0, 1.0}, true}};
    EXPECT_GT(Check(graded), hits / 2);
}

}  // namespace
}  // namespace flare
