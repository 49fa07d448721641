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
    EXPECT_EQ(request.lens, "x");
    EXPECT_FALSE(request.prescription.has_value());
    EXPECT_FALSE(request.bare_glass);
    EXPECT_FALSE(request.f_number.has_value());
    EXPECT_EQ(request.iris.blades, 0);
    EXPECT_EQ(request.units, Units::kSceneLinear);
    EXPECT_EQ(request.color_space, ColorSpace::kLinRec709);
    EXPECT_EQ(request.preset, Preset::kPreview);
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
        "lens": "tele", "f_number": 4.5, "focus_m": null, "zoom_mm": null, "coatings": "none",
        "iris": {"blades": 6, "roundness": 0.25, "rotation_deg": -10},
        "image": {"width": 1920, "height": 1080, "sensor_width_mm": 24.5, "crop": [10, 20, 30, 40],
                  "center_offset_mm": [1.5, -2.5], "pixel_aspect": 2,
                  "projection": "lens"},
        "lights": [{"direction": [0.1, -0.2, -3], "distance_m": 2.5, "irradiance": [3, 2, 1],
                    "angular_diameter_deg": 0},
                   {"pixel": [-400.5, 300]}],
        "layers": ["ghosts"], "units": "sensor_irradiance", "color_space": "lin_rec709",
        "quality": {"preset": "reference"},
        "model": {"reflections": 2, "ringing": "off", "sensor_reflection": false},
        "output": {"compression": "none", "pixel": "float"} })");
    EXPECT_EQ(request.lens, "tele");
    EXPECT_EQ(request.f_number, 4.5);
    EXPECT_TRUE(request.bare_glass);
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
    ASSERT_EQ(request.lights.size(), 2u);
    EXPECT_EQ(request.lights[0].direction, (std::array<double, 3>{0.1, -0.2, -3.0}));
    EXPECT_FALSE(request.lights[0].pixel.has_value());
    EXPECT_EQ(request.lights[0].distance_m, 2.5);
    EXPECT_EQ(request.lights[0].irradiance, (std::array<double, 3>{3, 2, 1}));
    EXPECT_EQ(request.lights[1].pixel, (std::array<double, 2>{-400.5, 300}));
    EXPECT_FALSE(request.lights[1].direction.has_value());
    EXPECT_EQ(request.units, Units::kSensorIrradiance);
    EXPECT_EQ(request.preset, Preset::kReference);
    EXPECT_EQ(request.ringing, Ringing::kOff);
    EXPECT_EQ(request.output.compression, Compression::kNone);
    EXPECT_EQ(request.output.pixel, PixelType::kFloat);
}

TEST(FlareRequestCodec, ReadsOverscan) {
    const FlareRequest request = Accepted(
        R"({"lens":"x","lights":[],"image":{"width":8,"height":9,"sensor_width_mm":36,
            "overscan":[1,2,3,4]}})");
    EXPECT_EQ(request.image.overscan, (std::array<int, 4>{1, 2, 3, 4}));
}

TEST(FlareRequestCodec, TakesEveryQualityPreset) {
    EXPECT_EQ(Accepted(With(R"("quality":{"preset":"draft"})")).preset, Preset::kDraft);
    EXPECT_EQ(Accepted(With(R"("quality":{"preset":"preview"})")).preset, Preset::kPreview);
    EXPECT_EQ(Accepted(With(R"("quality":{"preset":"final"})")).preset, Preset::kFinal);
    EXPECT_EQ(Accepted(With(R"("quality":{"preset":"reference"})")).preset, Preset::kReference);
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
    ASSERT_TRUE(request.prescription.has_value());
    EXPECT_FALSE(request.lens.has_value());
    const auto& root = std::get<JsonTree::Object>(request.prescription->value);
    EXPECT_EQ(request.prescription->pointer, "/prescription");
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
