// SPDX-License-Identifier: Apache-2.0
//
// The ghost list: what it prints, and what a query means to the core.
#include "server/translate/ghost_query.h"

#include <gtest/gtest.h>

#include <string>

#include "protocol/codec/json_document.h"
#include "server/lens_library.h"

namespace flare {
namespace {

using wire::JsonDocument;
using wire::JsonView;

constexpr char kSeed[] = "tronnier-double-gauss-50mm-f2";

std::shared_ptr<const Lens> LensOfFile(const std::string& name) {
    const auto lens = LoadLensFile(FLARE_SOURCE_DIR "/lenses/" + name + ".toml");
    EXPECT_TRUE(lens);
    return *lens;
}

JsonDocument Parsed(const std::string& text) {
    auto parsed = JsonDocument::Parse(text);
    EXPECT_EQ(wire::RefusalOf(parsed), nullptr) << text;
    return std::get<JsonDocument>(std::move(parsed));
}

double Number(const JsonView& object, const char* name) {
    const auto member = object.Find(name);
    EXPECT_TRUE(member.has_value()) << name;
    return member ? member->number() : 0.0;
}

GhostEntry Entry() {
    GhostEntry ghost;
    ghost.sequence = {9, 1};
    ghost.x.abcd = {1.5, -2.5, 0.25, 3.0};
    ghost.x.crossings = {{0.5, 3.0, 11.0}, {-0.75, -2.0, 12.0}, {0.25, 6.0, 13.0}};
    ghost.x.largest_crossing = 1;
    ghost.y = ghost.x;
    ghost.flux_mm2 = 0.5;
    ghost.centroid_mm = Vec2d(-1.25, 0.0);
    ghost.peak_irradiance = 0.125;
    return ghost;
}

TEST(GhostListJson, ShowsEveryNumberOfTheContract) {
    const RankedGhosts ghosts{{LensOfFile(kSeed), {}, {}}, {2.0, {Entry()}, {}}};
    GhostQuery query;
    query.field_deg = 5.0;
    query.coatings.none = true;
    const JsonDocument document = Parsed(GhostListJson(ghosts, query));
    const JsonView root = document.root();
    EXPECT_EQ(root.Find("lens")->string(), kSeed);
    EXPECT_EQ(Number(root, "total_flux_mm2"), 2.0);
    EXPECT_EQ(Number(root, "field_deg"), 5.0);
    EXPECT_NEAR(Number(root, "f_number"), 2.0302, 1e-4 * 2.0302);
    EXPECT_TRUE(root.Find("bare_glass")->boolean());
    EXPECT_FALSE(root.Find("four_reflections").has_value());
    const JsonView shown = *root.Find("ghosts")->FirstChild();
    EXPECT_EQ(shown.Find("sequence")->FirstChild()->number(), 9.0);
    EXPECT_EQ(Number(shown, "stop_crossings"), 3.0);
    EXPECT_EQ(shown.Find("abcd")->FirstChild()->NextSibling()->number(), -2.5);
    EXPECT_EQ(Number(shown, "m"), -2.0);
    EXPECT_EQ(Number(shown, "z_eff_mm"), 12.0);
    EXPECT_EQ(shown.Find("crossings")->child_count(), 3u);
    EXPECT_EQ(Number(*shown.Find("crossings")->FirstChild(), "a1"), 0.5);
    EXPECT_EQ(Number(shown, "flux_mm2"), 0.5);
    EXPECT_EQ(Number(shown, "share"), 0.25);
    EXPECT_EQ(shown.Find("centroid_mm")->FirstChild()->number(), -1.25);
    EXPECT_EQ(Number(shown, "peak_irradiance"), 0.125);
    EXPECT_FALSE(shown.Find("y").has_value()) << "both sections are one";
}

TEST(GhostListJson, ShowsTheYSectionOfAnAnamorphicLensAndFourReflections) {
    GhostEntry entry = Entry();
    entry.sequence = {9, 1, 7, 2};
    entry.y.abcd.a = 7.5;
    const FourReflectionFacts four{0.25, 1695, 12, 0.75, 0.125};
    const RankedGhosts ghosts{{LensOfFile("schneider-anamorphic-31mm-f2"), {}, {}},
                              {2.0, {entry}, four}};
    GhostQuery query;
    query.model.reflections = 4;
    query.azimuth_deg = 90.0;
    const JsonDocument document = Parsed(GhostListJson(ghosts, query));
    const JsonView root = document.root();
    EXPECT_EQ(Number(*root.Find("model"), "reflections"), 4.0);
    EXPECT_EQ(Number(root, "azimuth_deg"), 90.0);
    const JsonView told = *root.Find("four_reflections");
    EXPECT_EQ(Number(told, "threshold"), 0.25);
    EXPECT_EQ(Number(told, "sequences"), 1695.0);
    EXPECT_EQ(Number(told, "rendered"), 12.0);
    EXPECT_EQ(Number(told, "rendered_flux_mm2"), 0.75);
    EXPECT_EQ(Number(told, "lost_flux_mm2"), 0.125);
    const JsonView shown = *root.Find("ghosts")->FirstChild();
    EXPECT_EQ(shown.Find("sequence")->child_count(), 4u);
    EXPECT_EQ(shown.Find("abcd")->FirstChild()->number(), 1.5);
    EXPECT_EQ(shown.Find("y")->Find("abcd")->FirstChild()->number(), 7.5);
}

// A plano-convex lens behind a stop: three ghosts, quick to rank.
std::shared_ptr<const Lens> Small(bool with_sensor) {
    SurfacePrescription stop, front, back, sensor;
    stop.kind = SurfaceKind::kStop;
    stop.gap_mm = 2.0;
    stop.semi_diameter_mm = 5.0;
    front.radius_mm = 50.0;
    front.gap_mm = 6.0;
    front.nd = 1.5;
    front.semi_diameter_mm = 10.0;
    back.kind = SurfaceKind::kPlane;
    back.semi_diameter_mm = 10.0;
    stop.gap_given = front.gap_given = true;
    sensor.kind = SurfaceKind::kSensor;
    sensor.reflectance = 0.1;
    sensor.semi_diameter_mm = 20.0;
    Prescription file;
    file.name = "small";
    file.surfaces = {stop, front, back};
    if (with_sensor) file.surfaces.push_back(sensor);
    const auto lens = Lens::Build(file);
    EXPECT_TRUE(lens) << lens.error().message;
    return *lens;
}

class Ranking : public testing::Test {
  protected:
    Result<RankedGhosts> Rank(const std::shared_ptr<const Lens>& lens, const GhostQuery& query) {
        return RankGhostsFor(lens, query, {threads_, meshes_, CancelToken(), [] { return 0.0; }});
    }
    ThreadPool threads_{1};
    TracingMeshProvider meshes_;
};

TEST_F(Ranking, TakesANegativeAngleForTheOtherSide) {
    GhostQuery query;
    query.field_deg = 8.0;
    const auto right = Rank(Small(false), query);
    query.field_deg = -8.0;
    const auto left = Rank(Small(false), query);
    ASSERT_TRUE(right);
    ASSERT_TRUE(left) << left.error().message;
    ASSERT_EQ(right->list.ghosts.size(), 1u);
    const Vec2d a = right->list.ghosts[0].centroid_mm;
    const Vec2d b = left->list.ghosts[0].centroid_mm;
    EXPECT_GT(std::abs(a.x), 0.1);
    EXPECT_NEAR(a.x, -b.x, 1e-7);
    EXPECT_NEAR(b.y, 0.0, 1e-7);
    EXPECT_NEAR(left->list.total_flux_mm2, right->list.total_flux_mm2, 1e-12);
    EXPECT_NE(GhostListJson(*left, query).find("\"field_deg\": -8,"), std::string::npos);
}

TEST_F(Ranking, AddsTheSensorsGhostsWhereAsked) {
    GhostQuery query;
    const auto without = Rank(Small(true), query);
    query.model.sensor_reflection = true;
    const auto with = Rank(Small(true), query);
    ASSERT_TRUE(without);
    ASSERT_TRUE(with);
    EXPECT_EQ(without->list.ghosts.size(), 1u);  // (2,1)
    EXPECT_EQ(with->list.ghosts.size(), 3u);     // and the sensor, 3, with each surface
    const auto none = Rank(Small(false), query);
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().where, "sensor_reflection");
}

TEST_F(Ranking, FocusesTheLensFirst) {
    GhostQuery query;
    const auto far = Rank(Small(false), query);
    query.state.focus_m = 1.0;
    const auto near = Rank(Small(false), query);
    ASSERT_TRUE(far);
    ASSERT_TRUE(near);
    EXPECT_GT(near->lens.lens->sensor_z_mm(), far->lens.lens->sensor_z_mm() + 1.0);
    EXPECT_NE(near->list.ghosts[0].x.abcd.a, far->list.ghosts[0].x.abcd.a);
}

TEST_F(Ranking, NamesTheParameterOfABadCoating) {
    GhostQuery query;
    query.coatings.default_name = "no-such-coating";
    const auto ghosts = Rank(Small(false), query);
    ASSERT_FALSE(ghosts);
    EXPECT_EQ(ghosts.error().code, "bad_value");
    EXPECT_EQ(ghosts.error().where, "coatings");
}

}  // namespace
}  // namespace flare
