// SPDX-License-Identifier: Apache-2.0
//
// The step from the wire to the core: what a field means there, and where the errors of the core's
// readers end up in the client's words.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/optics/prescription_faults.h"
#include "protocol/codec/flare_request_codec.h"
#include "protocol/limits.h"
#include "server/translate/request_from_wire.h"

namespace flare {
namespace {

constexpr char kSeed[] = "tronnier-double-gauss-50mm-f2";

const LensLibrary& Library() {
    static const LensLibrary library = *LensLibrary::Load(FLARE_SOURCE_DIR "/lenses");
    return library;
}

wire::FlareRequest Decoded(const std::string& body) {
    const auto decoded = wire::DecodeFlareRequest(body);
    const wire::Refusal* refusal = wire::RefusalOf(decoded);
    EXPECT_EQ(refusal, nullptr) << refusal->message << " " << refusal->where;
    return refusal ? wire::FlareRequest{} : std::get<wire::FlareRequest>(decoded);
}

Result<FlareRequest> Translated(const std::string& body) {
    return RequestFromWire(Decoded(body), Library());
}

std::string Body(const std::string& members) {
    return R"({"image":{"width":192,"height":108,"sensor_width_mm":36},)"
           R"("lights":[{"direction":[0,0,1]}],)" +
           members + "}";
}
std::string SeedBody(const std::string& members) {
    return Body(std::string(R"("lens":")") + kSeed + "\"," + members);
}

TEST(RequestFromWire, CarriesEveryValueOver) {
    const Result<FlareRequest> request =
        Translated(std::string(R"({"lens":")") + kSeed + R"(","f_number":4,
            "iris":{"blades":6,"roundness":0.2,"rotation_deg":10},
            "image":{"width":1920,"height":1080,"sensor_width_mm":24,"crop":[1,2,3,4],
                     "center_offset_mm":[5,-6],"pixel_aspect":2,"projection":"lens"},
            "lights":[{"pixel":[400,300],"distance_m":2.5,"irradiance":[3,2,1]}],
            "units":"sensor_irradiance","quality":{"preset":"final"}})");
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->lens->name(), kSeed);
    EXPECT_EQ(request->f_number, 4.0);
    EXPECT_EQ(request->iris, (IrisShape{6, 0.2, 10.0}));
    EXPECT_EQ(request->image.width, 1920);
    EXPECT_EQ(request->image.height, 1080);
    EXPECT_EQ(request->image.sensor_width_mm, 24.0);
    EXPECT_EQ(request->image.crop, (std::array<int, 4>{1, 2, 3, 4}));
    EXPECT_EQ(request->image.center_offset_mm, Vec2d(5.0, -6.0));
    EXPECT_EQ(request->image.pixel_aspect, 2.0);
    EXPECT_EQ(request->image.projection, Projection::kLens);
    ASSERT_EQ(request->lights.size(), 1u);
    EXPECT_FALSE(request->lights[0].direction.has_value());
    EXPECT_EQ(request->lights[0].pixel, Vec2d(400.0, 300.0));
    EXPECT_EQ(request->lights[0].distance_m, 2.5);
    EXPECT_EQ(request->lights[0].irradiance, Vec3d(3.0, 2.0, 1.0));
    EXPECT_EQ(request->units, Units::kSensorIrradiance);
    EXPECT_EQ(request->color, ColorMode::kLinRec709);
    EXPECT_EQ(request->quality, QualityPreset::kFinal);
}

TEST(RequestFromWire, CarriesColourOver) {
    const Result<FlareRequest> request =
        Translated(std::string(R"({"lens":")") + kSeed + R"(","color_space":"aces2065-1",
            "camera":{"wavelengths_nm":[400,700],"red":[0,1],"green":[1,1],"blue":[1,0]},
            "image":{"width":1,"height":1,"sensor_width_mm":36},
            "lights":[{"direction":[0,0,1],"temperature_k":3200},
                      {"direction":[0,0,1],
                       "spectrum":{"wavelengths_nm":[500,505],"values":[1e30,5e29]}}]})");
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->color, ColorMode::kAces2065);
    ASSERT_NE(request->camera, nullptr);
    EXPECT_GT((*request->camera)[60].x, (*request->camera)[10].x);
    EXPECT_EQ(request->lights[0].temperature_k, 3200.0);
    ASSERT_NE(request->lights[1].spectrum, nullptr);
    const Spectrum& power = *request->lights[1].spectrum;
    EXPECT_DOUBLE_EQ(power[24], 2.0 * power[25]);
    EXPECT_EQ(power[23], 0.0);
}

TEST(RequestFromWire, RefusesACameraThatSeesNothing) {
    // Light at 380.5 nm alone lies beside every sample.
    const Result<FlareRequest> request = Translated(
        SeedBody(R"("camera":{"wavelengths_nm":[381],"red":[1],"green":[1],"blue":[1]})"));
    ASSERT_FALSE(request);
    EXPECT_EQ(request.error().where, "/camera");
}

TEST(RequestFromWire, TakesTheCoatingsOffWhenAsked) {
    const Result<FlareRequest> bare = Translated(SeedBody(R"("coatings":"none")"));
    ASSERT_TRUE(bare);
    for (const LensSurface& surface : bare->lens->surfaces()) {
        EXPECT_TRUE(surface.coating.bare());
    }
    const Result<FlareRequest> coated = Translated(SeedBody(R"("layers":["ghosts"])"));
    ASSERT_TRUE(coated);
    EXPECT_FALSE(coated->lens->surfaces()[0].coating.bare());
}

// The square of these lengths is 0 or infinite in a double.
TEST(RequestFromWire, TakesDirectionsOfAnyLength) {
    for (const char* direction :
         {"[3e-320,0,4e-320]", "[3e-200,0,4e-200]", "[3e300,0,4e300]", "[3,0,4]"}) {
        const Result<FlareRequest> request = Translated(
            std::string(R"({"lens":")") + kSeed +
            R"(","image":{"width":1,"height":1,"sensor_width_mm":36},"lights":[{"direction":)" +
            direction + "}]}");
        ASSERT_TRUE(request);
        const Vec3d unit = request->lights[0].direction->normalized();
        // 3e-320 has 13 bits only.
        const double tolerance =
            std::string(direction).find("e-320") == std::string::npos ? 1e-15 : 1e-3;
        EXPECT_NEAR(unit.x, 0.6, tolerance) << direction;
        EXPECT_NEAR(unit.z, 0.8, tolerance) << direction;
    }
}

TEST(RequestFromWire, CarriesStateAndModelOver) {
    const Result<FlareRequest> request = Translated(SeedBody(
        R"("focus_m":1.5,"model":{"reflections":4,"four_reflection_threshold":0.02,
           "sensor_reflection":true})"));
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->state, (LensState{1.5, std::nullopt}));
    EXPECT_TRUE(request->state_clamped.empty());
    EXPECT_EQ(request->model.reflections, 4);
    EXPECT_EQ(request->model.four_reflection_threshold, 0.02);
    EXPECT_TRUE(request->model.sensor_reflection);
    EXPECT_FALSE(request->image.desqueeze);
    const Result<FlareRequest> wide = Translated(
        std::string(R"({"lens":")") + kSeed +
        R"(","image":{"width":8,"height":8,"sensor_width_mm":36,"desqueeze":true},"lights":[]})");
    ASSERT_TRUE(wide);
    EXPECT_TRUE(wide->image.desqueeze);
}

TEST(RequestFromWire, NamesTheFieldOfAnUnknownLens) {
    const Result<FlareRequest> request = Translated(Body(R"("lens":"tronnier-double-gaus")"));
    ASSERT_FALSE(request);
    EXPECT_EQ(request.error().code, "unknown_lens");
    EXPECT_EQ(request.error().where, "/lens");
    EXPECT_NE(request.error().message.find(kSeed), std::string::npos) << request.error().message;
}

// The library of a service must not open the files that its clients name.
TEST(RequestFromWire, DoesNotTakeAPathForALens) {
    for (const char* name : {FLARE_SOURCE_DIR "/lenses/tronnier-double-gauss-50mm-f2.toml",
                             "../lenses/tronnier-double-gauss-50mm-f2", "/etc/passwd"}) {
        const Result<FlareRequest> request =
            Translated(Body(std::string(R"("lens":")") + name + "\""));
        ASSERT_FALSE(request) << name;
        EXPECT_EQ(request.error().code, "unknown_lens");
    }
}

constexpr char kSinglet[] = R"({"name":"singlet","surface":[
    {"kind":"sphere","radius_mm":50,"gap_mm":5,"nd":1.5168,"vd":64.2,"semi_diameter_mm":10},
    {"kind":"sphere","radius_mm":-50,"gap_mm":1,"semi_diameter_mm":10},
    {"kind":"stop","semi_diameter_mm":6}]})";

TEST(RequestFromWire, BuildsAnInlinePrescription) {
    const Result<FlareRequest> request =
        Translated(Body(std::string(R"("prescription":)") + kSinglet));
    ASSERT_TRUE(request) << request.error().message << request.error().where;
    EXPECT_EQ(request->lens->name(), "singlet");
    // The lensmaker's formula for a thick lens: 1/f = (n-1) (1/R1 - 1/R2 + (n-1) d / (n R1 R2)).
    const double n = 1.5168;
    const double power = (n - 1) * (2.0 / 50.0 - (n - 1) * 5.0 / (n * 2500.0));
    EXPECT_NEAR(request->lens->first_order().efl_mm, 1.0 / power, 1e-9);
}

TEST(RequestFromWire, NamesThePlaceInABadInlinePrescription) {
    const struct {
        const char* name;
        const char* prescription;
        const char* code;
        const char* where;
    } table[] = {
        {"no name", R"({"surface":[]})", "bad_lens", "/prescription"},
        {"no surfaces", R"({"name":"p"})", "bad_lens", "/prescription"},
        {"unknown key", R"({"name":"p","colour":1,"surface":[]})", "bad_lens",
         "/prescription/colour"},
        {"radius is text",
         R"({"name":"p","surface":[{"kind":"sphere","radius_mm":"50","semi_diameter_mm":5}]})",
         "bad_lens", "/prescription/surface/0/radius_mm"},
        {"kind that is none",
         R"({"name":"p","surface":[{"kind":"mirror","radius_mm":50,"semi_diameter_mm":5}]})",
         "bad_lens", "/prescription/surface/0/kind"},
        {"semi-diameter above the radius",
         R"({"name":"p","surface":[
             {"kind":"sphere","radius_mm":5,"gap_mm":2,"nd":1.5,"semi_diameter_mm":6},
             {"kind":"plane","gap_mm":1,"semi_diameter_mm":6},
             {"kind":"stop","semi_diameter_mm":3}]})",
         "bad_lens", "/prescription/surface/0"},
    };
    for (const auto& row : table) {
        const Result<FlareRequest> request =
            Translated(Body(std::string(R"("prescription":)") + row.prescription));
        ASSERT_FALSE(request) << row.name;
        EXPECT_EQ(request.error().code, row.code) << row.name << ": " << request.error().message;
        EXPECT_EQ(request.error().where, row.where) << row.name << ": " << request.error().message;
    }
}

std::string HashOf(const std::string& body) {
    const wire::FlareRequest request = Decoded(body);
    const Result<FlareRequest> translated = RequestFromWire(request, Library());
    EXPECT_TRUE(translated);
    return RequestHash(request, *translated).hex();
}

TEST(RequestHash, IsTheSameForBodiesThatMeanTheSame) {
    const std::string plain = HashOf(SeedBody(R"("units":"scene_linear")"));
    EXPECT_EQ(plain, HashOf(SeedBody(R"( "quality" : {"preset": "preview"} , "focus_m":null)")));
    EXPECT_EQ(plain, HashOf(SeedBody(R"("coatings":{},"model":{"reflections":2})")));
    EXPECT_EQ(HashOf(SeedBody(R"("coatings":"mgf2-500")")),
              HashOf(SeedBody(R"("coatings":{"default":"mgf2-500","surfaces":{}})")));
    EXPECT_EQ(plain, HashOf(std::string(R"({"lights":[{"irradiance":[1.0,1e0,10e-1],
                 "direction":[0,-0.0,1]}],"lens":")") +
                            kSeed + R"(",
                 "image":{"sensor_width_mm":36.0,"height":108,"width":192}})"));
}

TEST(RequestHash, ChangesWithEveryField) {
    const std::string plain = HashOf(SeedBody(R"("units":"scene_linear")"));
    std::vector<std::string> hashes{plain};
    for (const char* members : {R"("units":"sensor_irradiance")",
                                R"("f_number":4)",
                                R"("f_number":4.0000000000000009)",
                                R"("coatings":"none")",
                                R"("iris":{"blades":5})",
                                R"("iris":{"roundness":0.5})",
                                R"("iris":{"rotation_deg":1})",
                                R"("quality":{"preset":"draft"})",
                                R"("quality":{"preset":"reference"})",
                                R"("quality":{"preset":"reference","method":"photon"})",
                                R"("quality":{"preset":"reference","method":"photon","seed":1})",
                                R"("output":{"pixel":"float"})",
                                R"("output":{"compression":"none"})",
                                R"("color_space":"spectral","wavelengths_nm":[550])",
                                R"("color_space":"spectral","wavelengths_nm":[550,551])",
                                R"("color_space":"acescg")",
                                R"("color_space":"aces2065-1")",
                                R"("camera":{"wavelengths_nm":[500,600],"red":[1,1],"green":[1,1],
                                             "blue":[1,1]})",
                                R"("camera":{"wavelengths_nm":[500,600],"red":[1,1],"green":[1,1],
                                             "blue":[1,2]})",
                                R"("focus_m":2)",
                                R"("focus_m":0.01)",
                                R"("focus_m":0.02)",
                                R"("zoom_mm":70)",
                                R"("coatings":"mgf2-500")",
                                R"("coatings":"bare")",
                                R"("coatings":{"surfaces":{"3":"mgf2-500"}})",
                                R"("coatings":{"surfaces":{"4":"mgf2-500"}})",
                                R"("coatings":{"default":"bare","surfaces":{"4":"mgf2-500"}})",
                                R"("model":{"reflections":4})",
                                R"("model":{"four_reflection_threshold":0.01})",
                                R"("model":{"sensor_reflection":true})",
                                R"("model":{"culling":"none"})",
                                R"("model":{"culling":"report"})",
                                R"("layers":["starburst"])",
                                R"("layers":["starburst","ghosts"])",
                                R"("layers":["starburst"],"starburst":{"core":false})",
                                R"("layers":["starburst"],"starburst":{"jitter_deg":1})",
                                R"("layers":["starburst"],"starburst":{"jitter_count":4})",
                                R"("layers":["starburst"],"starburst":{"seed":4})",
                                R"("layers":["bokeh"])",
                                R"("layers":["ghosts","bokeh"])",
                                R"("split":"ghost")",
                                R"("split":"light")",
                                R"("artist":{"ghosts":[{"sequence":[9,1]}]})",
                                R"("artist":{"ghosts":[{"sequence":[8,1]}]})",
                                R"("artist":{"ghosts":[{"sequence":[9,1],"gain":2}]})",
                                R"("artist":{"ghosts":[{"sequence":[9,1],"tint":[1,2,1]}]})",
                                R"("artist":{"ghosts":[{"sequence":[9,1],"mute":true}]})",
                                R"("model":{"ringing":"off"})"}) {
        hashes.push_back(HashOf(SeedBody(members)));
    }
    const std::string lens = std::string(R"({"lens":")") + kSeed + R"(",)";
    const std::string image = R"("image":{"width":192,"height":108,"sensor_width_mm":36)";
    const std::string light = R"("lights":[{"direction":[0,0,1])";
    for (const char* more :
         {R"(,"crop":[0,0,192,108])", R"(,"overscan":[1,0,0,0])", R"(,"overscan":[0,1,0,0])",
          R"(,"center_offset_mm":[1,0])", R"(,"center_offset_mm":[0,1])", R"(,"pixel_aspect":2)",
          R"(,"projection":"lens")", R"(,"projection":"rectilinear")", R"(,"desqueeze":true)"}) {
        hashes.push_back(HashOf(lens + image + more + "}," + light + "}]}"));
    }
    for (const char* lights : {"[]", R"([{"direction":[0,0,2]}])", R"([{"pixel":[96,54]}])",
                               R"([{"direction":[0,0,1],"distance_m":2}])",
                               R"([{"direction":[0,0,1],"irradiance":[1,1,2]}])",
                               R"([{"direction":[0,0,1],"temperature_k":3200}])",
                               R"([{"direction":[0,0,1],"spectrum":{"wavelengths_nm":[500],
                                    "values":[1]}}])",
                               R"([{"direction":[0,0,1]},{"direction":[0,0,1]}])"}) {
        hashes.push_back(HashOf(lens + image + R"(},"lights":)" + lights + "}"));
    }
    const std::size_t count = hashes.size();
    std::sort(hashes.begin(), hashes.end());
    hashes.erase(std::unique(hashes.begin(), hashes.end()), hashes.end());
    EXPECT_EQ(hashes.size(), count);
}

TEST(Limits, OfTheWireAreThoseOfTheCore) {
    EXPECT_EQ(static_cast<int>(limits::kLights), kMaxLights);
    EXPECT_EQ(limits::kImageSide, kMaxImageSide);
    EXPECT_EQ(limits::kImagePixels, kMaxImagePixels);
    EXPECT_EQ(static_cast<int>(limits::kWavelengths), kMaxWavelengths);
    EXPECT_EQ(limits::kMaxFourReflectionThreshold, kMaxFourReflectionThreshold);
    EXPECT_EQ(limits::kMaxAngularDiameter_deg, kMaxAngularDiameter_deg);
    EXPECT_EQ(limits::kMinPhotonSamples, kMinPhotonSamples);
    EXPECT_EQ(limits::kMaxPhotonSamples, kMaxPhotonSamples);
    EXPECT_EQ(limits::kMinPhotonKernel_px, kMinPhotonKernel_px);
    EXPECT_EQ(limits::kMaxPhotonKernel_px, kMaxPhotonKernel_px);
    EXPECT_EQ(limits::kMinPhotonNearest, kMinPhotonNearest);
    EXPECT_EQ(limits::kMaxPhotonNearest, kMaxPhotonNearest);
    EXPECT_EQ(limits::kMinTemperature_k, kMinTemperature_k);
    EXPECT_EQ(limits::kMaxTemperature_k, kMaxTemperature_k);
    EXPECT_EQ(limits::kSplitLayers, kMaxSplitLayers);
    EXPECT_EQ(limits::kSplitPixels, kMaxSplitPixels);
    EXPECT_EQ(limits::kArtistGhosts, kMaxArtistGhosts);
    EXPECT_EQ(limits::kMaxArtistGain, kMaxArtistGain);
    EXPECT_EQ(limits::kMaxExposure_stops, kMaxExposure_stops);
    EXPECT_EQ(limits::kMaxNoiseFloor, kMaxNoiseFloor);
    EXPECT_EQ(limits::kMaxJitter_deg, kMaxJitter_deg);
    EXPECT_EQ(limits::kMaxJitterCount, kMaxJitterCount);
    EXPECT_EQ(limits::kMinTolerance, kMinTolerance);
    EXPECT_EQ(limits::kMaxTolerance, kMaxTolerance);
    EXPECT_EQ(limits::kMaxTimeBudget_ms, kMaxTimeBudget_ms);
    EXPECT_EQ(static_cast<int>(limits::kSurfaces), kMaxSurfaces);
}

}  // namespace
}  // namespace flare
