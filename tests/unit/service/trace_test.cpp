// SPDX-License-Identifier: Apache-2.0
//
// `flare trace` from text to text, on a singlet whose axial ray has a closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "protocol/codec/json_document.h"
#include "server/translate/trace_from_wire.h"

namespace flare {
namespace {

using wire::JsonDocument;
using wire::JsonView;

constexpr double kIndex = 1.5168;

// Bare singlet of 5 mm, stop 1 mm behind it, sensor 50 mm behind the stop.
std::string Input(const std::string& members) {
    return R"({"prescription":{"name":"singlet","surface":[
        {"kind":"sphere","radius_mm":50,"gap_mm":5,"nd":1.5168,"semi_diameter_mm":10},
        {"kind":"sphere","radius_mm":-50,"gap_mm":1,"semi_diameter_mm":10},
        {"kind":"stop","gap_mm":50,"semi_diameter_mm":6}]},)" +
           members + "}";
}

class TraceText : public testing::Test {
  protected:
    // The first ray of the output.
    JsonView Traced(const std::string& members) {
        const auto output = TraceJson(Input(members), LensLibrary());
        EXPECT_TRUE(output) << output.error().where << ": " << output.error().message;
        auto parsed = JsonDocument::Parse(output ? *output : R"({"rays":[{}]})");
        EXPECT_EQ(wire::RefusalOf(parsed), nullptr);
        document_ = std::get<JsonDocument>(std::move(parsed));
        return *document_.root().Find("rays")->FirstChild();
    }
    static double Number(const JsonView& object, const char* name) {
        return object.Find(name)->number();
    }

    JsonDocument document_;
};

constexpr char kAxial[] = R"("rays":[{"origin":[0,0,-10],"direction":[0,0,7]}])";

TEST_F(TraceText, GivesTheAxialRayItsLengthAndWeight) {
    const JsonView ray = Traced(kAxial);
    EXPECT_EQ(ray.Find("fate")->string(), "arrived");
    EXPECT_NEAR(Number(ray, "path_mm"), 10 + kIndex * 5 + 1 + 50, 1e-12);
    const double r = (kIndex - 1) / (kIndex + 1);
    EXPECT_NEAR(Number(ray, "weight"), (1 - r * r) * (1 - r * r), 1e-14);
    EXPECT_EQ(ray.Find("sensor_mm")->FirstChild()->number(), 0.0);
    EXPECT_EQ(ray.Find("stops_mm")->child_count(), 1u);
    EXPECT_EQ(Number(ray, "max_rim_ratio"), 0.0);
    EXPECT_FALSE(ray.Find("out_of_order")->boolean());
}

TEST_F(TraceText, FollowsABounceSequence) {
    const JsonView ray = Traced(std::string(R"("sequence":[1,0],)") + kAxial);
    EXPECT_EQ(ray.Find("fate")->string(), "arrived");
    EXPECT_NEAR(Number(ray, "path_mm"), 10 + 3 * kIndex * 5 + 1 + 50, 1e-12);
    const double r = (kIndex - 1) / (kIndex + 1);
    EXPECT_NEAR(Number(ray, "weight"), r * r * r * r * (1 - r * r) * (1 - r * r), 1e-14);
}

TEST_F(TraceText, NamesTheSurfaceThatEndedARay) {
    const char* outside = R"("rays":[{"origin":[0,12,-10],"direction":[0,0,1]}])";
    JsonView ray = Traced(outside);
    EXPECT_EQ(ray.Find("fate")->string(), "vignetted");
    EXPECT_EQ(ray.Find("sensor_mm")->kind(), wire::JsonKind::kNull);
    EXPECT_EQ(Number(ray, "ended_at_surface"), 0.0);
    EXPECT_NEAR(Number(ray, "max_rim_ratio"), 1.2, 1e-12);

    ray = Traced(std::string(R"("clip":false,)") + outside);
    EXPECT_EQ(ray.Find("fate")->string(), "arrived");
    EXPECT_NEAR(Number(ray, "max_rim_ratio"), 1.2, 1e-12);
}

TEST_F(TraceText, SetsARoundIrisByTheFNumber) {
    const char* rays = R"("rays":[{"origin":[0,3,-10],"direction":[0,0,1]}])";
    EXPECT_EQ(Traced(rays).Find("fate")->string(), "arrived");
    const JsonView ray = Traced(std::string(R"("f_number":22,)") + rays);
    EXPECT_EQ(ray.Find("fate")->string(), "stopped");
    EXPECT_EQ(Number(ray, "ended_at_surface"), 2.0);
}

// Unit focusing by the closed form: the singlet is equiconvex, so f and HH' follow from the
// lensmaker's formula for thick lenses.
TEST_F(TraceText, FocusesTheLens) {
    const double path_far = Number(Traced(kAxial), "path_mm");
    const JsonView ray = Traced(std::string(R"("focus_m":0.5,)") + kAxial);
    const double f = 1.0 / ((kIndex - 1) * (2.0 / 50 - (kIndex - 1) * 5 / (kIndex * 2500)));
    const double from_vertex = f * (kIndex - 1) * 5 / (kIndex * 50);  // vertex to principal plane
    const double s = 500.0 - (5 - 2 * from_vertex);
    const double shift = 0.5 * (s - std::sqrt(s * s - 4 * f * s)) - f;
    EXPECT_NEAR(Number(ray, "path_mm") - path_far, shift, 1e-9);
    const JsonView state = *document_.root().Find("state");
    EXPECT_EQ(Number(state, "focus_m"), 0.5);
    EXPECT_NEAR(Number(state, "focus_shift_mm"), shift, 1e-9);
    EXPECT_EQ(state.Find("zoom_mm")->kind(), wire::JsonKind::kNull);
}

TEST_F(TraceText, SaysWhatWasClamped) {
    Traced(std::string(R"("focus_m":0.001,"f_number":0.5,)") + kAxial);
    const JsonView clamped = *document_.root().Find("state")->Find("clamped");
    ASSERT_EQ(clamped.child_count(), 1u);
    EXPECT_EQ(clamped.FirstChild()->Find("field")->string(), "focus_m");
    // The stop lies behind the lens: its image is as large as the beam that fills it.
    EXPECT_GT(Number(document_.root(), "f_number"), 3.0);
}

// A quarter wave at the traced wavelength: R = ((n - c^2) / (n + c^2))^2 for a layer of index c.
TEST_F(TraceText, WeighsTheCoatingsThatWereAskedFor) {
    const double c2 = 1.38 * 1.38;
    const double r = (kIndex - c2) / (kIndex + c2);
    const double bare = (kIndex - 1) / (kIndex + 1);
    const char* rays = R"("wavelength_nm":550,"rays":[{"origin":[0,0,-10],"direction":[0,0,1]}])";
    EXPECT_NEAR(Number(Traced(std::string(R"("coatings":"mgf2-550",)") + rays), "weight"),
                (1 - r * r) * (1 - r * r), 1e-9);
    EXPECT_NEAR(Number(Traced(std::string(R"("coatings":{"surfaces":{"1":"mgf2-550"}},)") + rays),
                       "weight"),
                (1 - bare * bare) * (1 - r * r), 1e-9);
}

TEST_F(TraceText, KeepsTheOrderOfManyRays) {
    Traced(
        R"("rays":[{"origin":[1,0,-1],"direction":[0,0,1]},{"origin":[0,0,-1],"direction":[0,0,1]},
                      {"origin":[-1,0,-1],"direction":[0,0,1]}])");
    const JsonView rays = *document_.root().Find("rays");
    ASSERT_EQ(rays.child_count(), 3u);
    std::vector<double> stop_x;
    for (auto ray = rays.FirstChild(); ray; ray = ray->NextSibling()) {
        stop_x.push_back(ray->Find("stops_mm")->FirstChild()->FirstChild()->number());
    }
    EXPECT_GT(stop_x[0], 0.5);
    EXPECT_EQ(stop_x[1], 0.0);
    EXPECT_EQ(stop_x[2], -stop_x[0]);
}

TEST(TraceJson, NamesThePlaceOfASequenceThatTheLensCannotHave) {
    for (const char* sequence : {"[1]", "[0,1]", "[2,0]", "[9,0]"}) {
        const auto output = TraceJson(
            Input(std::string(R"("sequence":)") + sequence + "," + kAxial), LensLibrary());
        ASSERT_FALSE(output) << sequence;
        EXPECT_EQ(output.error().where, "/sequence") << sequence;
    }
}

}  // namespace
}  // namespace flare
