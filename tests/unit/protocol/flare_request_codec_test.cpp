// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/flare_request_codec.h"

#include <gtest/gtest.h>

#include <string>

namespace flare::wire {
namespace {

FlareRequest Accepted(const std::string& body) {
    const Decoded<FlareRequest> decoded = DecodeFlareRequest(body);
    const Refusal* refusal = RefusalOf(decoded);
    EXPECT_EQ(refusal, nullptr) << refusal->code << " " << refusal->message << " "
                                << refusal->where;
    return refusal ? FlareRequest{} : std::get<FlareRequest>(decoded);
}

constexpr char kRest[] =
    R"("image":{"width":192,"height":108,"sensor_width_mm":36},"lights":[{"direction":[0,0,1]}])";

std::string With(const std::string& members) {
    return std::string(R"({"lens":"x",)") + kRest + "," + members + "}";
}

TEST(FlareRequestCodec, FillsInTheDefaultsOfTheContract) {
    const FlareRequest request = Accepted(std::string(R"({"lens":"x",)") + kRest + "}");
    EXPECT_EQ(request.lens.name, "x");
    EXPECT_FALSE(request.lens.prescription.has_value());
    EXPECT_TRUE(request.lens.coatings.own());
    EXPECT_FALSE(request.lens.f_number.has_value());
    EXPECT_FALSE(request.lens.focus_m.has_value());
    EXPECT_FALSE(request.lens.zoom_mm.has_value());
    EXPECT_EQ(request.model.reflections, 2);
    EXPECT_EQ(request.model.four_reflection_threshold, 1e-3);
    EXPECT_FALSE(request.model.sensor_reflection);
    EXPECT_EQ(request.model.ringing, Ringing::kAuto);
    EXPECT_EQ(request.model.culling, Culling::kAuto);
    EXPECT_FALSE(request.image.desqueeze);
    EXPECT_EQ(request.iris.blades, 0);
    EXPECT_EQ(request.units, Units::kSceneLinear);
    EXPECT_EQ(request.color_space, ColorSpace::kLinRec709);
    EXPECT_EQ(request.quality.preset, Preset::kPreview);
    EXPECT_EQ(request.output.compression, Compression::kZip);
    EXPECT_EQ(request.output.pixel, PixelType::kHalf);
    EXPECT_EQ(request.image.projection, Projection::kDefault);
    EXPECT_EQ(request.image.pixel_aspect, 1.0);
    ASSERT_EQ(request.lights.size(), 1u);
    EXPECT_FALSE(request.lights[0].distance_m.has_value());
    EXPECT_EQ(request.lights[0].irradiance, (std::array<double, 3>{1, 1, 1}));
}

TEST(FlareRequestCodec, ReadsEveryFieldThatIsBuilt) {
    const FlareRequest request = Accepted(R"({
        "lens": "tele", "f_number": 4.5, "focus_m": 1.25, "zoom_mm": 135, "coatings": "none",
        "iris": {"blades": 6, "roundness": 0.25, "rotation_deg": -10},
        "image": {"width": 1920, "height": 1080, "sensor_width_mm": 24.5, "crop": [10, 20, 30, 40],
                  "center_offset_mm": [1.5, -2.5], "pixel_aspect": 2,
                  "projection": "lens", "desqueeze": true},
        "lights": [{"direction": [0.1, -0.2, -3], "distance_m": 2.5, "irradiance": [3, 2, 1],
                    "angular_diameter_deg": 0},
                   {"pixel": [-400.5, 300]}],
        "layers": ["ghosts"], "units": "sensor_irradiance", "color_space": "lin_rec709",
        "quality": {"preset": "reference"},
        "model": {"reflections": 4, "four_reflection_threshold": 0.02, "ringing": "off",
                  "sensor_reflection": true, "culling": "report"},
        "output": {"compression": "none", "pixel": "float"} })");
    EXPECT_EQ(request.lens.name, "tele");
    EXPECT_EQ(request.lens.f_number, 4.5);
    EXPECT_EQ(request.lens.focus_m, 1.25);
    EXPECT_EQ(request.lens.zoom_mm, 135.0);
    EXPECT_TRUE(request.lens.coatings.none);
    EXPECT_EQ(request.iris.blades, 6);
    EXPECT_EQ(request.iris.roundness, 0.25);
    EXPECT_EQ(request.iris.rotation_deg, -10.0);
    EXPECT_EQ(request.image.width, 1920);
    EXPECT_EQ(request.image.height, 1080);
    EXPECT_EQ(request.image.sensor_width_mm, 24.5);
    EXPECT_EQ(request.image.crop, (std::array<int, 4>{10, 20, 30, 40}));
    EXPECT_EQ(request.image.center_offset_mm, (std::array<double, 2>{1.5, -2.5}));
    EXPECT_EQ(request.image.pixel_aspect, 2.0);
    EXPECT_EQ(request.image.projection, Projection::kLens);
    EXPECT_TRUE(request.image.desqueeze);
    ASSERT_EQ(request.lights.size(), 2u);
    EXPECT_EQ(request.lights[0].direction, (std::array<double, 3>{0.1, -0.2, -3.0}));
    EXPECT_FALSE(request.lights[0].pixel.has_value());
    EXPECT_EQ(request.lights[0].distance_m, 2.5);
    EXPECT_EQ(request.lights[0].irradiance, (std::array<double, 3>{3, 2, 1}));
    EXPECT_EQ(request.lights[1].pixel, (std::array<double, 2>{-400.5, 300}));
    EXPECT_FALSE(request.lights[1].direction.has_value());
    EXPECT_EQ(request.units, Units::kSensorIrradiance);
    EXPECT_EQ(request.quality.preset, Preset::kReference);
    EXPECT_EQ(request.model.reflections, 4);
    EXPECT_EQ(request.model.four_reflection_threshold, 0.02);
    EXPECT_TRUE(request.model.sensor_reflection);
    EXPECT_EQ(request.model.ringing, Ringing::kOff);
    EXPECT_EQ(request.model.culling, Culling::kReport);
    EXPECT_EQ(request.output.compression, Compression::kNone);
    EXPECT_EQ(request.output.pixel, PixelType::kFloat);
}

TEST(FlareRequestCodec, ReadsLayersAndTheStarburst) {
    const FlareRequest none = Accepted(With(R"("units":"scene_linear")"));
    EXPECT_TRUE(none.layers.ghosts);
    EXPECT_FALSE(none.layers.starburst);
    EXPECT_TRUE(none.starburst.core);
    EXPECT_EQ(none.starburst.jitter_deg, 0.0);
    const FlareRequest both = Accepted(With(R"("layers":["starburst","ghosts"])"));
    EXPECT_TRUE(both.layers.ghosts && both.layers.starburst);
    const FlareRequest one = Accepted(With(R"("layers":["starburst"],
                "starburst":{"core":false,"jitter_deg":2.5,"jitter_count":9,"seed":77})"));
    EXPECT_FALSE(one.layers.ghosts);
    EXPECT_FALSE(one.starburst.core);
    EXPECT_EQ(one.starburst.jitter_deg, 2.5);
    EXPECT_EQ(one.starburst.jitter_count, 9);
    EXPECT_EQ(one.starburst.seed, 77);
}

TEST(FlareRequestCodec, ReadsWhatIsVisible) {
    EXPECT_FALSE(Accepted(With(R"("split":"none")")).visible);
    const FlareRequest request =
        Accepted(With(R"("visible":{"noise_floor":0.002,"exposure_stops":-3})"));
    ASSERT_TRUE(request.visible);
    EXPECT_EQ(request.visible->noise_floor, 0.002);
    EXPECT_EQ(request.visible->exposure_stops, -3.0);
    EXPECT_EQ(Accepted(With(R"("visible":{"noise_floor":1})")).visible->exposure_stops, 0.0);
}

TEST(FlareRequestCodec, ReadsBokehSplitAndArtist) {
    const FlareRequest none = Accepted(With(R"("layers":["bokeh"])"));
    EXPECT_TRUE(none.layers.bokeh);
    EXPECT_FALSE(none.layers.ghosts);
    EXPECT_EQ(none.split, Split::kNone);
    EXPECT_TRUE(none.artist.empty());
    EXPECT_EQ(Accepted(With(R"("split":"light")")).split, Split::kLight);
    const FlareRequest request = Accepted(With(R"("split":"ghost","artist":{"ghosts":[
        {"sequence":[9,1],"gain":2,"tint":[1,0.5,0.2]},{"sequence":[8,4],"mute":true}]})"));
    EXPECT_EQ(request.split, Split::kGhost);
    ASSERT_EQ(request.artist.size(), 2U);
    EXPECT_EQ(request.artist[0].sequence, (std::vector<int>{9, 1}));
    EXPECT_EQ(request.artist[0].gain, 2.0);
    EXPECT_EQ(request.artist[0].tint, (std::array<double, 3>{1.0, 0.5, 0.2}));
    EXPECT_FALSE(request.artist[0].mute);
    EXPECT_EQ(request.artist[1].gain, 1.0);
    EXPECT_TRUE(request.artist[1].mute);
}

// Ghosts are those of points; the starburst alone may be that of a disc.
TEST(FlareRequestCodec, TakesADiscForTheStarburstAlone) {
    const FlareRequest request = Accepted(
        R"({"lens":"x","image":{"width":8,"height":8,"sensor_width_mm":36},
            "lights":[{"direction":[0,0,1],"angular_diameter_deg":0.53}],
            "layers":["starburst"]})");
    EXPECT_EQ(request.lights.at(0).angular_diameter_deg, 0.53);
}

TEST(FlareRequestCodec, TakesNullForTheStateTheLensFileHas) {
    const FlareRequest request = Accepted(With(R"("focus_m":null,"zoom_mm":null)"));
    EXPECT_FALSE(request.lens.focus_m.has_value());
    EXPECT_FALSE(request.lens.zoom_mm.has_value());
}

TEST(FlareRequestCodec, ReadsEveryFormOfCoatings) {
    const Coatings name = Accepted(With(R"("coatings":"mgf2-500")")).lens.coatings;
    EXPECT_FALSE(name.none);
    EXPECT_EQ(name.default_name, "mgf2-500");
    EXPECT_EQ(name.default_where, "/coatings");
    EXPECT_TRUE(name.surfaces.empty());

    const Coatings both =
        Accepted(With(R"("coatings":{"default":"bare","surfaces":{"3":"mgf2-550","10":"none"}})"))
            .lens.coatings;
    EXPECT_FALSE(both.none);
    EXPECT_EQ(both.default_name, "bare");
    EXPECT_EQ(both.default_where, "/coatings/default");
    EXPECT_EQ(both.surfaces, (std::map<int, std::string>{{3, "mgf2-550"}, {10, "none"}}));

    const Coatings single = Accepted(With(R"("coatings":{"surfaces":{"0":"bare"}})")).lens.coatings;
    EXPECT_FALSE(single.default_name.has_value());
    EXPECT_EQ(single.surfaces.size(), 1u);
    EXPECT_TRUE(Accepted(With(R"("coatings":{})")).lens.coatings.own());
}

TEST(FlareRequestCodec, TakesACoatingForEverySurfaceALensCanHave) {
    std::string surfaces;
    for (int i = 0; i < 100; ++i) surfaces += '"' + std::to_string(i) + R"(":"bare",)";
    surfaces.pop_back();
    const Coatings coatings =
        Accepted(With(R"("coatings":{"surfaces":{)" + surfaces + "}}")).lens.coatings;
    EXPECT_EQ(coatings.surfaces.size(), 100u);
}

TEST(FlareRequestCodec, ReadsOverscan) {
    const FlareRequest request = Accepted(
        R"({"lens":"x","lights":[],"image":{"width":8,"height":9,"sensor_width_mm":36,
            "overscan":[1,2,3,4]}})");
    EXPECT_EQ(request.image.overscan, (std::array<int, 4>{1, 2, 3, 4}));
}

TEST(FlareRequestCodec, TakesEveryQualityPreset) {
    EXPECT_EQ(Accepted(With(R"("quality":{"preset":"draft"})")).quality.preset, Preset::kDraft);
    EXPECT_EQ(Accepted(With(R"("quality":{"preset":"preview"})")).quality.preset, Preset::kPreview);
    EXPECT_EQ(Accepted(With(R"("quality":{"preset":"final"})")).quality.preset, Preset::kFinal);
    EXPECT_EQ(Accepted(With(R"("quality":{"preset":"reference"})")).quality.preset,
              Preset::kReference);
}

TEST(FlareRequestCodec, TakesAQualityByNumber) {
    const Quality by_error = Accepted(With(R"("quality":{"max_error":0.02})")).quality;
    EXPECT_EQ(by_error.max_error, 0.02);
    EXPECT_FALSE(by_error.tolerance || by_error.time_budget_ms);
    EXPECT_EQ(Accepted(With(R"("quality":{"tolerance":0.25})")).quality.tolerance, 0.25);
    EXPECT_EQ(Accepted(With(R"("quality":{"time_budget_ms":40})")).quality.time_budget_ms, 40.0);
}

TEST(FlareRequestCodec, TakesOneNumberAsSpectralIrradiance) {
    const FlareRequest request = Accepted(
        R"({"lens":"x","color_space":"spectral","wavelengths_nm":[587.5618,486.1327],
            "image":{"width":1,"height":1,"sensor_width_mm":36},
            "lights":[{"direction":[0,0,1],"irradiance":2.5},
                      {"direction":[0,0,1],"irradiance":[3,3,3]}]})");
    EXPECT_EQ(request.color_space, ColorSpace::kSpectral);
    EXPECT_EQ(request.wavelengths_nm, (std::vector<double>{587.5618, 486.1327}));
    EXPECT_EQ(request.lights[0].irradiance, (std::array<double, 3>{2.5, 2.5, 2.5}));
    EXPECT_EQ(request.lights[1].irradiance, (std::array<double, 3>{3, 3, 3}));
}

TEST(FlareRequestCodec, KeepsAnInlinePrescriptionWithThePlaceOfEveryValue) {
    const FlareRequest request = Accepted(
        std::string(
            R"({"prescription":{"name":"p","surface":[{"kind":"stop"},{"radius_mm":5e1}]},)") +
        kRest + "}");
    ASSERT_TRUE(request.lens.prescription.has_value());
    EXPECT_FALSE(request.lens.name.has_value());
    const auto& root = std::get<JsonTree::Object>(request.lens.prescription->value);
    EXPECT_EQ(request.lens.prescription->pointer, "/prescription");
    EXPECT_EQ(std::get<std::string>(root.at("name").value), "p");
    const auto& surfaces = std::get<JsonTree::Array>(root.at("surface").value);
    ASSERT_EQ(surfaces.size(), 2u);
    const JsonTree& radius = std::get<JsonTree::Object>(surfaces[1].value).at("radius_mm");
    EXPECT_EQ(std::get<double>(radius.value), 50.0);
    EXPECT_EQ(radius.pointer, "/prescription/surface/1/radius_mm");
}

TEST(FlareRequestCodec, TakesAsManyLightsAsTheLimitAllows) {
    std::string lights;
    for (int i = 0; i < 100'000; ++i) lights += R"({"direction":[0,0,1]},)";
    lights.pop_back();
    const FlareRequest request =
        Accepted(R"({"lens":"x","image":{"width":1,"height":1,"sensor_width_mm":36},"lights":[)" +
                 lights + "]}");
    EXPECT_EQ(request.lights.size(), 100'000u);
}

// A tile of a frame that would be too large as a whole.
TEST(FlareRequestCodec, CountsThePixelsOfTheCropAlone) {
    const FlareRequest request = Accepted(
        R"({"lens":"x","lights":[],"image":{"width":16384,"height":16384,"sensor_width_mm":36,
            "crop":[8192,8192,1024,1024]}})");
    EXPECT_EQ(request.image.crop, (std::array<int, 4>{8192, 8192, 1024, 1024}));
}

TEST(FlareRequestCodec, TakesNoLightsAndAMemberThatLooksLikeAnEscape) {
    EXPECT_TRUE(Accepted(R"({"l\u0065ns":"x","image":{"width":1,"height":1,"sensor_width_mm":36},
                             "lights":[]})")
                    .lights.empty());
}

TEST(FlareRequestCodec, ReadsWholeNumbersHoweverTheyAreWritten) {
    const FlareRequest request = Accepted(
        R"({"lens":"x","image":{"width":1.92e2,"height":108.0,"sensor_width_mm":36},"lights":[]})");
    EXPECT_EQ(request.image.width, 192);
    EXPECT_EQ(request.image.height, 108);
}

}  // namespace
}  // namespace flare::wire
