// SPDX-License-Identifier: Apache-2.0
//
// What is left out below the floor, against the same picture with all of it: no pixel may differ by
// the floor, and the report's bounds must hold.
#include "core/render/visible.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/lenses.h"
#include "tests/support/rendering.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::Studio;

struct Case {
    const char* name;
    const char* lens;
    double f_number;
    bool ringing = true, starburst = false, disc = false;
    QualityPreset preset = QualityPreset::kPreview;
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
    return out << c.name;
}

FlareRequest RequestOf(const Case& c) {
    FlareRequest request;
    request.lens = testing::LibraryLens(c.lens);
    request.f_number = c.f_number;
    request.iris.blades = 6;
    request.image.width = 96;
    request.image.height = 54;
    request.model.ringing = c.ringing;
    request.layers.starburst = c.starburst;
    request.lights = {LightAt(9.0, 20.0), LightAt(4.0, 140.0)};
    request.lights[1].irradiance = Vec3d(0.02, 0.05, 0.3);
    if (c.disc) request.lights[0].angular_diameter_deg = 1.0;
    request.quality = c.preset;
    return request;
}

// Over the root and all layers, beyond the rounding of floats.
double LargestDifference(const FlareImage& a, const FlareImage& b) {
    constexpr double kRounding = 0x1.0p-22;
    double most = 0.0;
    for (std::size_t p = 0; p < a.planes.size(); ++p) {
        for (std::size_t k = 0; k < a.planes[p].values.size(); ++k) {
            const double x = a.planes[p].values[k], y = b.planes[p].values[k];
            most = std::max(most, std::abs(x - y) - kRounding * std::abs(x));
        }
    }
    return most;
}

double Largest(const ImagePlane& plane) {
    return *std::max_element(plane.values.begin(), plane.values.end());
}

class Unseen : public ::testing::TestWithParam<Case> {};

TEST_P(Unseen, ChangesNoPixelByTheFloor) {
    FlareRequest request = RequestOf(GetParam());
    Studio studio;
    const Rendering all = studio.Shoot(request);
    double brightest = Largest(testing::PlaneNamed(all.image, "ghosts.R"));
    // Beside a starburst: where its tails are within the frame.
    if (GetParam().starburst) brightest = 1e-4 * Largest(testing::PlaneNamed(all.image, "R"));
    bool ghosts = false, details = false, tails = false;
    for (const double share : {100.0, 1.0, 0.1, 0.01}) {
        request.visible = {2.0, 4.0 * share * brightest};
        const Rendering seen = studio.Shoot(request);
        const VisibleFacts& facts = *seen.report.facts.visible;
        const double floor = share * brightest;
        EXPECT_NEAR(facts.floor, floor, 1e-12 * floor);
        const double bound = facts.ghosts.peak + facts.details.peak + facts.starburst.peak;
        EXPECT_LE(bound, floor * (1.0 + 1e-12));
        const double difference = LargestDifference(seen.image, all.image);
        EXPECT_LE(difference, bound * (1.0 + 1e-6)) << share;
        if (facts.ghosts.count + facts.details.count + facts.starburst.count > 0) {
            EXPECT_GT(difference, 0.0);
        }
        EXPECT_LE(seen.report.work.polygons, all.report.work.polygons);
        ghosts = ghosts || facts.ghosts.count > 0;
        details = details || facts.details.count > 0;
        tails = tails || facts.starburst.count > 0;
    }
    EXPECT_TRUE(ghosts);
    EXPECT_TRUE(details);
    EXPECT_EQ(tails, GetParam().starburst);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Unseen,
                         ::testing::Values(Case{"seed", testing::kSeedName, 4.0},
                                           Case{"seed_dense", testing::kSeedName, 5.6, false, false,
                                                false, QualityPreset::kFinal},
                                           Case{"starburst", testing::kSeedName, 11.0, true, true},
                                           Case{"disc", testing::kSeedName, 8.0, true, false, true},
                                           Case{"retrofocus", testing::kRetrofocusName, 16.0, true,
                                                false, false, QualityPreset::kDraft}),
                         [](const auto& scene) { return scene.param.name; });

// A floor that nothing reaches: no mesh is traced and nothing drawn; one that all reaches changes
// no bit.
TEST(Visible, GoesFromNothingToAll) {
    FlareRequest request = RequestOf({"seed", testing::kSeedName, 8.0});
    Studio studio;
    request.visible = {0.0, 1e12};
    const Rendering dark = studio.Shoot(request);
    EXPECT_EQ(dark.report.work.mesh_misses, 0U);
    EXPECT_EQ(dark.report.work.polygons, 0U);
    for (const ImagePlane& plane : dark.image.planes) EXPECT_EQ(testing::Sum(plane), 0.0);
    EXPECT_TRUE(std::any_of(dark.report.facts.ghosts.begin(), dark.report.facts.ghosts.end(),
                            [](const GhostFacts& ghost) { return ghost.model == "unseen"; }));
    request.visible = {0.0, 1e-30};
    const Rendering every = studio.Shoot(request);
    request.visible.reset();
    const Rendering plain = studio.Shoot(request);
    EXPECT_EQ(LargestDifference(every.image, plain.image), 0.0);
    EXPECT_GT(testing::Sum(plain.image.planes[0]), 0.0);
}

// A ghost that an artist has a hand on is drawn whatever it is without him.
TEST(Visible, LeavesTheArtistsGhost) {
    FlareRequest request = RequestOf({"seed", testing::kSeedName, 8.0});
    request.artist.push_back({{9, 1}});
    request.artist.back().gain = 1e6;
    request.visible = {0.0, 1e12};
    Studio studio;
    EXPECT_GT(testing::Sum(studio.Shoot(request).image.planes[0]), 0.0);
}

TEST(Visible, RefusesWhatItCannotTell) {
    FlareRequest request = RequestOf({"seed", testing::kSeedName, 8.0});
    const auto where = [&] {
        const std::optional<Error> error = CheckRequest(request);
        return error ? error->where + " " + error->code : "";
    };
    request.visible = {0.0, 1.0};
    EXPECT_EQ(where(), "");
    request.image.overscan = {1, 0, 0, 0};
    EXPECT_EQ(where(), "/visible unsupported");
    request.image.overscan = {};
    request.layers = {false, false, true};
    EXPECT_EQ(where(), "/visible unsupported");
    request.layers = {};
    request.quality = QualityPreset::kReference;
    request.photon = PhotonSpec{};
    EXPECT_EQ(where(), "/visible unsupported");
    request.photon.reset();
    request.visible->noise_floor = 0.0;
    EXPECT_EQ(where(), "/visible/noise_floor bad_value");
    request.visible = {61.0, 1.0};
    EXPECT_EQ(where(), "/visible/exposure_stops bad_value");
}

}  // namespace
}  // namespace flare
