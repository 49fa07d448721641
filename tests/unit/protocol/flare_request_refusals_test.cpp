// SPDX-License-Identifier: Apache-2.0
//
// The table of bad requests: each is refused with the right code at the right place, and none is
// ever repaired, cut down or ignored.
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "protocol/codec/flare_request_codec.h"
#include "protocol/limits.h"

namespace flare::wire {
namespace {

struct BadRequest {
    const char* name;
    std::string body;
    const char* code;
    const char* where;
};

void PrintTo(const BadRequest& bad, std::ostream* out) {
    *out << bad.name;
}

constexpr char kImage[] = R"("image":{"width":192,"height":108,"sensor_width_mm":36})";
constexpr char kLights[] = R"("lights":[{"direction":[0,0,1]}])";

// A sound request with further members.
std::string With(const std::string& members) {
    return std::string(R"({"lens":"x",)") + kImage + "," + kLights + "," + members + "}";
}
std::string WithImage(const std::string& image) {
    return std::string(R"({"lens":"x","image":)") + image + "," + kLights + "}";
}
std::string WithLights(const std::string& lights) {
    return std::string(R"({"lens":"x",)") + kImage + R"(,"lights":)" + lights + "}";
}
// A second light after a sound one.
std::string WithLight(const std::string& light) {
    return WithLights(R"([{"direction":[0,0,1]},)" + light + "]");
}
std::string Repeated(const std::string& text, int count) {
    std::string all;
    for (int i = 0; i < count; ++i) all += text;
    return all;
}
std::string ManyLights(int count) {
    return WithLights("[" + Repeated(R"({"direction":[0,0,1]},)", count - 1) +
                      R"({"direction":[0,0,1]}])");
}
std::string Surfaces(int count) {
    return std::string(R"({"prescription":{"name":"p","surface":[)") +
           Repeated(R"({"kind":"plane"},)", count - 1) + R"({"kind":"plane"}]},)" + kImage + "," +
           kLights + "}";
}

class BadRequests : public testing::TestWithParam<BadRequest> {};

TEST_P(BadRequests, AreRefusedWithCodeAndPlace) {
    const BadRequest& bad = GetParam();
    const Decoded<FlareRequest> decoded = DecodeFlareRequest(bad.body);
    const Refusal* refusal = RefusalOf(decoded);
    ASSERT_NE(refusal, nullptr) << "accepted: " << bad.body.substr(0, 200);
    EXPECT_EQ(refusal->code, bad.code) << refusal->message;
    EXPECT_EQ(refusal->where, bad.where) << refusal->message;
    EXPECT_FALSE(refusal->message.empty());
    EXPECT_LT(refusal->message.size(), 400u);
}

const BadRequest kSyntax[] = {
    {"empty", "", "bad_json", "byte 1"},
    {"blank", "  \n ", "bad_json", "byte 5"},
    {"truncated", R"({"lens":"x","image":{"width":19)", "bad_json", "byte 32"},
    {"truncated_string", R"({"lens":"x)", "bad_json", "byte 11"},
    {"two_bodies", R"({"lens":"x"}{"lens":"x"})", "bad_json", "byte 13"},
    {"trailing_garbage", R"({"lens":"x"} x)", "bad_json", "byte 14"},
    {"trailing_comma", R"({"lens":"x",})", "bad_json", "byte 13"},
    {"single_quotes", R"({'lens':'x'})", "bad_json", "byte 2"},
    {"comment", R"({"lens":"x" /* c */})", "bad_json", "byte 13"},
    {"nan", R"({"f_number":NaN})", "bad_json", "byte 13"},
    {"infinity", R"({"f_number":Infinity})", "bad_json", "byte 13"},
    {"minus_infinity", R"({"f_number":-Infinity})", "bad_json", "byte 14"},
    {"leading_zero", R"({"f_number":04})", "bad_json", "byte 14"},
    {"bare_point", R"({"f_number":.5})", "bad_json", "byte 13"},
    {"hexadecimal", R"({"f_number":0x10})", "bad_json", "byte 14"},
    {"raw_newline_in_string", "{\"lens\":\"a\nb\"}", "bad_json", "byte 11"},
    {"invalid_utf8", "{\"lens\":\"a\xff\"}", "bad_json", "byte 11"},
    {"overlong_utf8", "{\"lens\":\"\xc0\xaf\"}", "bad_json", "byte 10"},
    {"lone_surrogate", R"({"lens":"\ud800"})", "bad_json", "byte 16"},
    {"not_json", "lens = 'x'", "bad_json", "byte 1"},
    {"binary", std::string("\0\1\2", 3), "bad_json", "byte 1"},
    {"number_overflow", R"({"lens":"x","f_number":1e999})", "bad_value", "/f_number"},
    {"number_overflow_in_array", WithLight(R"({"direction":[0,-1e400,1]})"), "bad_value",
     "/lights/1/direction/1"},
    {"duplicate_member", R"({"lens":"x","f_number":2,"lens":"y"})", "duplicate_key", "/lens"},
    {"duplicate_member_inside", WithImage(R"({"width":1,"height":1,"width":2})"), "duplicate_key",
     "/image/width"},
    {"duplicate_by_escape", R"({"lens":"x","l\u0065ns":"y"})", "duplicate_key", "/lens"},
    {"deep_arrays", Repeated("[", 100'000), "limit", "/0/0/0/0/0/0/0/0/0/0/0/0/0/0/0/0"},
    {"deep_objects", With(R"("model":)" + Repeated(R"({"a":)", 40)), "limit",
     "/model/a/a/a/a/a/a/a/a/a/a/a/a/a/a/a"},
    {"body_is_array", "[]", "bad_type", ""},
    {"body_is_null", "null", "bad_type", ""},
    {"body_is_number", "1", "bad_type", ""},
    {"too_many_members",
     "{" +
         [] {
             std::string members;
             for (int i = 0; i < 200; ++i) members += "\"a" + std::to_string(i) + "\":1,";
             return members;
         }() +
         R"("z":1})",
     "limit", ""},
    {"long_key", "{\"" + std::string(1'000, 'k') + "\":1}", "limit", ""},
    {"long_string", R"({"lens":")" + std::string(100'000, 'x') + "\"}", "limit", "/lens"},
    {"too_many_values", "[" + Repeated("0,", 2'000'000) + "0]", "limit", ""},
    {"too_large", std::string(limits::kBodyBytes + 1, ' '), "too_large", ""},
};

const BadRequest kFields[] = {
    {"empty_object", "{}", "missing_field", "/lens"},
    {"no_image", std::string(R"({"lens":"x",)") + kLights + "}", "missing_field", "/image"},
    {"no_lights", std::string(R"({"lens":"x",)") + kImage + "}", "missing_field", "/lights"},
    {"unknown_field", With(R"("colour":1)"), "unknown_field", "/colour"},
    {"unknown_field_with_slash", With(R"("a/b~c":1)"), "unknown_field", "/a~1b~0c"},
    {"field_in_capitals", With(R"("F_number":2)"), "unknown_field", "/F_number"},
    {"lens_is_number", R"({"lens":5})", "bad_type", "/lens"},
    {"lens_is_null", R"({"lens":null})", "bad_type", "/lens"},
    {"lens_is_empty", R"({"lens":""})", "bad_value", "/lens"},
    {"lens_name_is_long", R"({"lens":")" + std::string(201, 'x') + "\"}", "limit", "/lens"},
    {"lens_and_prescription", With(R"("prescription":{"name":"p","surface":[]})"), "bad_value",
     "/prescription"},
    {"prescription_is_text", R"({"prescription":"x"})", "bad_type", "/prescription"},
    {"prescription_too_long", Surfaces(101), "limit", "/prescription/surface"},
    {"prescription_too_rich", R"({"prescription":{"name":[)" + Repeated("0,", 5'000) + "0]}}",
     "limit", "/prescription"},
    {"f_number_zero", With(R"("f_number":0)"), "bad_value", "/f_number"},
    {"f_number_negative", With(R"("f_number":-4)"), "bad_value", "/f_number"},
    {"f_number_text", With(R"("f_number":"4")"), "bad_type", "/f_number"},
    {"f_number_null", With(R"("f_number":null)"), "bad_type", "/f_number"},
    {"f_number_huge", With(R"("f_number":1e300)"), "limit", "/f_number"},
    {"coatings_empty_name", With(R"("coatings":"")"), "bad_value", "/coatings"},
    {"coatings_long_name", With(R"("coatings":")" + std::string(201, 'x') + "\""), "limit",
     "/coatings"},
    {"coatings_null", With(R"("coatings":null)"), "bad_type", "/coatings"},
    {"coatings_number", With(R"("coatings":3)"), "bad_type", "/coatings"},
    {"coatings_list", With(R"("coatings":["bare"])"), "bad_type", "/coatings"},
    {"coatings_unknown_field", With(R"("coatings":{"defualt":"bare"})"), "unknown_field",
     "/coatings/defualt"},
    {"coatings_default_number", With(R"("coatings":{"default":1})"), "bad_type",
     "/coatings/default"},
    {"coatings_surfaces_list", With(R"("coatings":{"surfaces":["bare"]})"), "bad_type",
     "/coatings/surfaces"},
    {"coating_of_no_number", With(R"("coatings":{"surfaces":{"front":"bare"}})"), "bad_value",
     "/coatings/surfaces/front"},
    {"coating_of_no_name", With(R"("coatings":{"surfaces":{"":"bare"}})"), "bad_value",
     "/coatings/surfaces/"},
    {"coating_of_negative_surface", With(R"("coatings":{"surfaces":{"-1":"bare"}})"), "bad_value",
     "/coatings/surfaces/-1"},
    {"coating_of_fraction", With(R"("coatings":{"surfaces":{"1.0":"bare"}})"), "bad_value",
     "/coatings/surfaces/1.0"},
    {"coating_of_padded_number", With(R"("coatings":{"surfaces":{"03":"bare"}})"), "bad_value",
     "/coatings/surfaces/03"},
    {"coating_of_surface_100", With(R"("coatings":{"surfaces":{"100":"bare"}})"), "bad_value",
     "/coatings/surfaces/100"},
    {"coating_of_huge_number", With(R"("coatings":{"surfaces":{"99999999999":"bare"}})"),
     "bad_value", "/coatings/surfaces/99999999999"},
    {"coating_number", With(R"("coatings":{"surfaces":{"3":550}})"), "bad_type",
     "/coatings/surfaces/3"},
    {"coating_twice", With(R"("coatings":{"surfaces":{"3":"bare","3":"bare"}})"), "duplicate_key",
     "/coatings/surfaces/3"},
    {"focus_zero", With(R"("focus_m":0)"), "bad_value", "/focus_m"},
    {"focus_negative", With(R"("focus_m":-2)"), "bad_value", "/focus_m"},
    {"focus_text", With(R"("focus_m":"inf")"), "bad_type", "/focus_m"},
    {"focus_nan", R"({"focus_m":NaN})", "bad_json", "byte 12"},
    {"focus_huge", With(R"("focus_m":1e21)"), "limit", "/focus_m"},
    {"zoom_zero", With(R"("zoom_mm":0)"), "bad_value", "/zoom_mm"},
    {"zoom_negative", With(R"("zoom_mm":-35)"), "bad_value", "/zoom_mm"},
    {"zoom_list", With(R"("zoom_mm":[70,200])"), "bad_type", "/zoom_mm"},
    {"zoom_huge", With(R"("zoom_mm":1e9)"), "limit", "/zoom_mm"},
    {"reflections_text", With(R"("model":{"reflections":"4"})"), "bad_type", "/model/reflections"},
    {"threshold_zero", With(R"("model":{"four_reflection_threshold":0})"), "bad_value",
     "/model/four_reflection_threshold"},
    {"threshold_negative", With(R"("model":{"four_reflection_threshold":-1})"), "bad_value",
     "/model/four_reflection_threshold"},
    {"threshold_huge", With(R"("model":{"four_reflection_threshold":1e7})"), "limit",
     "/model/four_reflection_threshold"},
    {"sensor_reflection_number", With(R"("model":{"sensor_reflection":1})"), "bad_type",
     "/model/sensor_reflection"},
    {"model_unknown_field", With(R"("model":{"bounces":4})"), "unknown_field", "/model/bounces"},
    {"desqueeze_number", WithImage(R"({"width":8,"height":8,"sensor_width_mm":36,"desqueeze":1})"),
     "bad_type", "/image/desqueeze"},
    {"units_unknown", With(R"("units":"lux")"), "bad_value", "/units"},
    {"color_space_unknown", With(R"("color_space":"srgb")"), "bad_value", "/color_space"},
    {"quality_empty", With(R"("quality":{})"), "missing_field", "/quality/preset"},
    {"quality_twice", With(R"("quality":{"preset":"final","max_error":0.02})"), "bad_value",
     "/quality/preset"},
    {"max_error_zero", With(R"("quality":{"max_error":0})"), "bad_value", "/quality/max_error"},
    {"max_error_large", With(R"("quality":{"max_error":1})"), "bad_value", "/quality/max_error"},
    {"max_error_text", With(R"("quality":{"max_error":"low"})"), "bad_type", "/quality/max_error"},
    {"tolerance_small", With(R"("quality":{"tolerance":1e-4})"), "bad_value", "/quality/tolerance"},
    {"time_budget_zero", With(R"("quality":{"time_budget_ms":0})"), "bad_value",
     "/quality/time_budget_ms"},
    {"time_budget_long", With(R"("quality":{"time_budget_ms":1e6})"), "limit",
     "/quality/time_budget_ms"},
    {"quality_unknown", With(R"("quality":{"preset":"best"})"), "bad_value", "/quality/preset"},
    {"quality_is_text", With(R"("quality":"final")"), "bad_type", "/quality"},
    {"layers_empty", With(R"("layers":[])"), "bad_value", "/layers"},
    {"layers_twice", With(R"("layers":["ghosts","ghosts"])"), "bad_value", "/layers"},
    {"layer_unknown", With(R"("layers":["ghosts","sparkle"])"), "bad_value", "/layers/1"},
    {"starburst_twice", With(R"("layers":["starburst","starburst"])"), "bad_value", "/layers"},
    {"starburst_core", With(R"("starburst":{"core":1})"), "bad_type", "/starburst/core"},
    {"starburst_word", With(R"("starburst":{"spikes":6})"), "unknown_field", "/starburst/spikes"},
    {"jitter", With(R"("starburst":{"jitter_deg":-1})"), "bad_value", "/starburst/jitter_deg"},
    {"jitter_too_far", With(R"("starburst":{"jitter_deg":181})"), "limit", "/starburst/jitter_deg"},
    {"jitter_none", With(R"("starburst":{"jitter_count":0})"), "bad_value",
     "/starburst/jitter_count"},
    {"jitter_many", With(R"("starburst":{"jitter_count":33})"), "limit", "/starburst/jitter_count"},
    {"jitter_part", With(R"("starburst":{"jitter_count":2.5})"), "bad_type",
     "/starburst/jitter_count"},
    {"seed", With(R"("starburst":{"seed":-1})"), "bad_value", "/starburst/seed"},
    {"bokeh_twice", With(R"("layers":["bokeh","bokeh"])"), "bad_value", "/layers"},
    {"split_unknown", With(R"("split":"ghosts")"), "bad_value", "/split"},
    {"split_boolean", With(R"("split":true)"), "bad_type", "/split"},
    {"split_without_ghosts", With(R"("layers":["bokeh"],"split":"ghost")"), "bad_value", "/split"},
    {"visible_empty", With(R"("visible":{})"), "missing_field", "/visible/noise_floor"},
    {"visible_floor", With(R"("visible":{"noise_floor":0})"), "bad_value", "/visible/noise_floor"},
    {"visible_stops", With(R"("visible":{"noise_floor":1,"exposure_stops":61})"), "limit",
     "/visible/exposure_stops"},
    {"artist_list", With(R"("artist":[])"), "bad_type", "/artist"},
    {"artist_empty", With(R"("artist":{})"), "missing_field", "/artist/ghosts"},
    {"artist_word", With(R"("artist":{"ghosts":[],"lights":[]})"), "unknown_field",
     "/artist/lights"},
    {"artist_no_sequence", With(R"("artist":{"ghosts":[{"gain":2}]})"), "missing_field",
     "/artist/ghosts/0/sequence"},
    {"artist_sequence", With(R"("artist":{"ghosts":[{"sequence":[9,-1]}]})"), "bad_value",
     "/artist/ghosts/0/sequence/1"},
    {"artist_gain", With(R"("artist":{"ghosts":[{"sequence":[9,1],"gain":-1}]})"), "bad_value",
     "/artist/ghosts/0/gain"},
    {"artist_gain_high", With(R"("artist":{"ghosts":[{"sequence":[9,1],"gain":2e6}]})"), "limit",
     "/artist/ghosts/0/gain"},
    {"artist_tint", With(R"("artist":{"ghosts":[{"sequence":[9,1],"tint":[1,2]}]})"), "bad_value",
     "/artist/ghosts/0/tint"},
    {"artist_mute", With(R"("artist":{"ghosts":[{"sequence":[9,1],"mute":1}]})"), "bad_type",
     "/artist/ghosts/0/mute"},
    {"artist_twice", With(R"("artist":{"ghosts":[{"sequence":[9,1]},{"sequence":[9,1]}]})"),
     "bad_value", "/artist/ghosts/1/sequence"},
    {"artist_without_ghosts",
     With(R"("layers":["bokeh"],"artist":{"ghosts":[{"sequence":[9,1]}]})"), "bad_value",
     "/artist"},
    {"artist_spectral_tint", With(R"("color_space":"spectral","wavelengths_nm":[550],
          "artist":{"ghosts":[{"sequence":[9,1],"tint":[1,1,1]}]})"),
     "bad_value", "/artist/ghosts/0/tint"},
    {"layer_number", With(R"("layers":[1])"), "bad_type", "/layers/0"},
    {"reflections_odd", With(R"("model":{"reflections":3})"), "bad_value", "/model/reflections"},
    {"culling_unknown", With(R"("model":{"culling":"most"})"), "bad_value", "/model/culling"},
    {"culling_boolean", With(R"("model":{"culling":true})"), "bad_type", "/model/culling"},
    {"sensor_reflection_text", With(R"("model":{"sensor_reflection":"no"})"), "bad_type",
     "/model/sensor_reflection"},
    {"compression_unknown", With(R"("output":{"compression":"gzip"})"), "bad_value",
     "/output/compression"},
    {"pixel_unknown", With(R"("output":{"pixel":"uint8"})"), "bad_value", "/output/pixel"},
    {"output_unknown_field", With(R"("output":{"level":9})"), "unknown_field", "/output/level"},
};

const BadRequest kFrame[] = {
    {"image_is_array", WithImage("[192,108]"), "bad_type", "/image"},
    {"width_missing", WithImage(R"({"height":108,"sensor_width_mm":36})"), "missing_field",
     "/image/width"},
    {"sensor_width_missing", WithImage(R"({"width":1,"height":1})"), "missing_field",
     "/image/sensor_width_mm"},
    {"width_negative", WithImage(R"({"width":-1,"height":1,"sensor_width_mm":36})"), "bad_value",
     "/image/width"},
    {"width_zero", WithImage(R"({"width":0,"height":1,"sensor_width_mm":36})"), "bad_value",
     "/image/width"},
    {"width_huge", WithImage(R"({"width":1000000000,"height":1,"sensor_width_mm":36})"), "limit",
     "/image/width"},
    {"width_beyond_64_bits",
     WithImage(R"({"width":99999999999999999999999,"height":1,"sensor_width_mm":36})"), "limit",
     "/image/width"},
    {"width_fraction", WithImage(R"({"width":1.5,"height":1,"sensor_width_mm":36})"), "bad_type",
     "/image/width"},
    {"height_text", WithImage(R"({"width":1,"height":"1","sensor_width_mm":36})"), "bad_type",
     "/image/height"},
    {"too_many_pixels", WithImage(R"({"width":16384,"height":16384,"sensor_width_mm":36})"),
     "limit", "/image"},
    {"sensor_width_negative", WithImage(R"({"width":1,"height":1,"sensor_width_mm":-36})"),
     "bad_value", "/image/sensor_width_mm"},
    {"sensor_width_zero", WithImage(R"({"width":1,"height":1,"sensor_width_mm":0})"), "bad_value",
     "/image/sensor_width_mm"},
    {"pixel_aspect_zero",
     WithImage(R"({"width":1,"height":1,"sensor_width_mm":36,"pixel_aspect":0})"), "bad_value",
     "/image/pixel_aspect"},
    {"crop_leaves_frame",
     WithImage(R"({"width":8,"height":8,"sensor_width_mm":36,"crop":[4,4,5,4]})"), "bad_value",
     "/image/crop"},
    {"crop_empty", WithImage(R"({"width":8,"height":8,"sensor_width_mm":36,"crop":[4,4,0,4]})"),
     "bad_value", "/image/crop"},
    {"crop_negative", WithImage(R"({"width":8,"height":8,"sensor_width_mm":36,"crop":[-1,0,4,4]})"),
     "bad_value", "/image/crop/0"},
    {"crop_short", WithImage(R"({"width":8,"height":8,"sensor_width_mm":36,"crop":[0,0,4]})"),
     "bad_value", "/image/crop"},
    {"overscan_negative",
     WithImage(R"({"width":8,"height":8,"sensor_width_mm":36,"overscan":[0,0,-1,0]})"), "bad_value",
     "/image/overscan/2"},
    {"overscan_too_wide",
     WithImage(R"({"width":16384,"height":8,"sensor_width_mm":36,"overscan":[1,0,0,0]})"), "limit",
     "/image/overscan"},
    {"crop_and_overscan",
     WithImage(
         R"({"width":8,"height":8,"sensor_width_mm":36,"crop":[0,0,4,4],"overscan":[1,1,1,1]})"),
     "bad_value", "/image/overscan"},
    {"crop_too_large",
     WithImage(R"({"width":16384,"height":16384,"sensor_width_mm":36,"crop":[0,0,16384,4097]})"),
     "limit", "/image"},
    {"too_many_pixels_and_channels",
     R"({"lens":"x","image":{"width":8192,"height":8192,"sensor_width_mm":36},"lights":[],
         "color_space":"spectral","wavelengths_nm":[400,450,500,550,600,650]})",
     "limit", "/image"},
    {"projection_unknown",
     WithImage(R"({"width":8,"height":8,"sensor_width_mm":36,"projection":"fisheye"})"),
     "bad_value", "/image/projection"},
    {"center_offset_scalar",
     WithImage(R"({"width":8,"height":8,"sensor_width_mm":36,"center_offset_mm":3})"), "bad_type",
     "/image/center_offset_mm"},
    {"iris_two_blades", With(R"("iris":{"blades":2})"), "bad_value", "/iris/blades"},
    {"iris_negative_blades", With(R"("iris":{"blades":-6})"), "bad_value", "/iris/blades"},
    {"iris_many_blades", With(R"("iris":{"blades":33})"), "limit", "/iris/blades"},
    {"iris_too_round", With(R"("iris":{"blades":6,"roundness":1.01})"), "bad_value",
     "/iris/roundness"},
    {"iris_unknown_field", With(R"("iris":{"leaves":6})"), "unknown_field", "/iris/leaves"},
};

const BadRequest kLightsTable[] = {
    {"lights_object", WithLights("{}"), "bad_type", "/lights"},
    {"million_lights", ManyLights(1'000'000), "too_large", ""},
    {"million_empty_lights", WithLights("[" + Repeated("{},", 999'999) + "{}]"), "limit",
     "/lights"},
    {"too_many_lights", ManyLights(100'001), "limit", "/lights"},
    {"light_empty", WithLight("{}"), "missing_field", "/lights/1"},
    {"light_number", WithLight("7"), "bad_type", "/lights/1"},
    {"direction_and_pixel", WithLight(R"({"direction":[0,0,1],"pixel":[1,1]})"), "bad_value",
     "/lights/1"},
    {"direction_zero", WithLight(R"({"direction":[0,0,0]})"), "bad_value", "/lights/1/direction"},
    {"direction_minus_zero", WithLight(R"({"direction":[-0.0,0,0e5]})"), "bad_value",
     "/lights/1/direction"},
    {"direction_short", WithLight(R"({"direction":[0,1]})"), "bad_value", "/lights/1/direction"},
    {"direction_text", WithLight(R"({"direction":[0,"0",1]})"), "bad_type",
     "/lights/1/direction/1"},
    {"direction_null", WithLight(R"({"direction":[0,0,null]})"), "bad_type",
     "/lights/1/direction/2"},
    {"pixel_far_away", WithLight(R"({"pixel":[1e9,0]})"), "limit", "/lights/1/pixel/0"},
    {"distance_zero", WithLight(R"({"direction":[0,0,1],"distance_m":0})"), "bad_value",
     "/lights/1/distance_m"},
    {"distance_negative", WithLight(R"({"direction":[0,0,1],"distance_m":-2})"), "bad_value",
     "/lights/1/distance_m"},
    {"irradiance_negative", WithLight(R"({"direction":[0,0,1],"irradiance":[1,-1,1]})"),
     "bad_value", "/lights/1/irradiance/1"},
    {"irradiance_number", WithLight(R"({"direction":[0,0,1],"irradiance":1})"), "bad_type",
     "/lights/1/irradiance"},
    {"irradiance_huge", WithLight(R"({"direction":[0,0,1],"irradiance":[1,1,1e200]})"), "limit",
     "/lights/1/irradiance/2"},
    {"angular_diameter_negative", WithLight(R"({"direction":[0,0,1],"angular_diameter_deg":-1})"),
     "bad_value", "/lights/1/angular_diameter_deg"},
    {"shape_as_a_file", WithLight(R"({"direction":[0,0,1],"shape":"a.png"})"), "bad_value",
     "/lights/1/shape"},
    {"shape_that_is_not_base64",
     WithLight(R"({"direction":[0,0,1],"angular_diameter_deg":1,"shape":{"png_base64":"A*=="}})"),
     "bad_value", "/lights/1/shape/png_base64"},
    {"shape_without_width", WithLight(R"({"direction":[0,0,1],"shape":{"png_base64":"AAAA"}})"),
     "bad_value", "/lights/1/shape"},
    {"temperature_low", WithLight(R"({"direction":[0,0,1],"temperature_k":499})"), "bad_value",
     "/lights/1/temperature_k"},
    {"temperature_high", WithLight(R"({"direction":[0,0,1],"temperature_k":1e7})"), "limit",
     "/lights/1/temperature_k"},
    {"temperature_and_spectrum", WithLight(R"({"direction":[0,0,1],"temperature_k":3200,
                   "spectrum":{"wavelengths_nm":[500],"values":[1]}})"),
     "bad_value", "/lights/1/spectrum"},
    {"spectrum_without_values",
     WithLight(R"({"direction":[0,0,1],"spectrum":{"wavelengths_nm":[500]}})"), "missing_field",
     "/lights/1/spectrum/values"},
    {"spectrum_empty",
     WithLight(R"({"direction":[0,0,1],"spectrum":{"wavelengths_nm":[],"values":[]}})"),
     "bad_value", "/lights/1/spectrum/wavelengths_nm"},
    {"spectrum_of_two_lengths",
     WithLight(R"({"direction":[0,0,1],"spectrum":{"wavelengths_nm":[500,600],"values":[1]}})"),
     "bad_value", "/lights/1/spectrum/values"},
    {"spectrum_descending",
     WithLight(R"({"direction":[0,0,1],"spectrum":{"wavelengths_nm":[500,500],"values":[1,1]}})"),
     "bad_value", "/lights/1/spectrum/wavelengths_nm/1"},
    {"spectrum_negative",
     WithLight(R"({"direction":[0,0,1],"spectrum":{"wavelengths_nm":[500,600],"values":[1,-1]}})"),
     "bad_value", "/lights/1/spectrum/values/1"},
    {"spectrum_invisible",
     WithLight(R"({"direction":[0,0,1],"spectrum":{"wavelengths_nm":[900,950],"values":[1,1]}})"),
     "bad_value", "/lights/1/spectrum/values"},
    {"spectrum_too_long",
     WithLight(R"({"direction":[0,0,1],"spectrum":{"values":[1],"wavelengths_nm":[)" +
               Repeated("500,", 4'000) + "500]}}"),
     "limit", "/lights/1/spectrum/wavelengths_nm"},
    {"spectral_temperature",
     std::string(R"({"lens":"x","color_space":"spectral","wavelengths_nm":[550],)") + kImage +
         R"(,"lights":[{"direction":[0,0,1],"temperature_k":3200}]})",
     "bad_value", "/lights/0/temperature_k"},
    {"camera_without_blue", With(R"("camera":{"wavelengths_nm":[500],"red":[1],"green":[1]})"),
     "missing_field", "/camera/blue"},
    {"camera_of_a_spectral_picture", With(R"("color_space":"spectral","wavelengths_nm":[550],
             "camera":{"wavelengths_nm":[500],"red":[1],"green":[1],"blue":[1]})"),
     "bad_value", "/camera"},
    {"photon_of_another_preset", With(R"("quality":{"preset":"final","method":"photon"})"),
     "bad_value", "/quality/method"},
    {"method_unknown", With(R"("quality":{"preset":"reference","method":"rays"})"), "bad_value",
     "/quality/method"},
    {"samples_without_photons", With(R"("quality":{"preset":"reference","samples":1000})"),
     "bad_value", "/quality/samples"},
    {"samples_too_many",
     With(R"("quality":{"preset":"reference","method":"photon","samples":100000001})"), "limit",
     "/quality/samples"},
    {"nearest_one", With(R"("quality":{"preset":"reference","method":"photon","nearest":1})"),
     "bad_value", "/quality/nearest"},
    {"light_unknown_field", WithLight(R"({"direction":[0,0,1],"name":"sun"})"), "unknown_field",
     "/lights/1/name"},
    {"spectral_without_wavelengths", With(R"("color_space":"spectral")"), "missing_field",
     "/wavelengths_nm"},
    {"wavelengths_without_spectral", With(R"("wavelengths_nm":[550])"), "bad_value",
     "/wavelengths_nm"},
    {"wavelengths_empty", With(R"("color_space":"spectral","wavelengths_nm":[])"), "bad_value",
     "/wavelengths_nm"},
    {"wavelength_zero", With(R"("color_space":"spectral","wavelengths_nm":[0])"), "bad_value",
     "/wavelengths_nm/0"},
    {"wavelength_infrared", With(R"("color_space":"spectral","wavelengths_nm":[550,1500])"),
     "limit", "/wavelengths_nm/1"},
    {"wavelength_twice", With(R"("color_space":"spectral","wavelengths_nm":[550,500,550])"),
     "bad_value", "/wavelengths_nm/2"},
    {"too_many_wavelengths",
     With(R"("color_space":"spectral","wavelengths_nm":[)" + Repeated("500,", 1'000) + "500]"),
     "limit", "/wavelengths_nm"},
    {"spectral_rgb_irradiance",
     std::string(R"({"lens":"x","color_space":"spectral","wavelengths_nm":[550],)") + kImage +
         R"(,"lights":[{"direction":[0,0,1],"irradiance":[1,2,3]}]})",
     "bad_value", "/lights/0/irradiance"},
};

const BadRequest kNotBuilt[] = {
    {"encoder_of_a_wrong_type", With(R"("encoder":1)"), "bad_type", "/encoder"},
    {"encoder_without_a_name", With(R"("encoder":"")"), "bad_value", "/encoder"},
    {"encoder_time_alone", With(R"("encoder_time":1)"), "bad_value", "/encoder_time"},
    {"encoder_max_age_ms_alone", With(R"("encoder_max_age_ms":1)"), "bad_value",
     "/encoder_max_age_ms"},
    {"encoder_max_age_ms_below_0", With(R"("encoder":"a","encoder_max_age_ms":-1)"), "bad_value",
     "/encoder_max_age_ms"},
    {"encoder_time_too_late", With(R"("encoder":"a","encoder_time":1e12)"), "limit",
     "/encoder_time"},
    {"iris_dust_without_count", With(R"("iris":{"dust":{}})"), "missing_field", "/iris/dust/count"},
    {"iris_dust_of_no_size", With(R"("iris":{"dust":{"count":1,"size_mm":0}})"), "bad_value",
     "/iris/dust/size_mm"},
    {"iris_scratches_many", With(R"("iris":{"scratches":{"count":1001}})"), "limit",
     "/iris/scratches/count"},
    {"iris_dust_on_a_mask", With(R"("iris":{"mask":{"png_base64":"AAAA"},"dust":{"count":1}})"),
     "unsupported", "/iris/dust"},
    {"iris_mask_as_a_file", With(R"("iris":{"mask":"a.png"})"), "bad_value", "/iris/mask"},
    {"iris_mask_that_is_not_base64", With(R"("iris":{"mask":{"png_base64":"A*=="}})"), "bad_value",
     "/iris/mask/png_base64"},
    {"iris_mask_empty", With(R"("iris":{"mask":{}})"), "missing_field", "/iris/mask/png_base64"},
    {"iris_mask_scale", With(R"("iris":{"mask":{"png_base64":"AAAA","scale":"x"}})"), "bad_value",
     "/iris/mask/scale"},
    {"iris_mask_with_blades", With(R"("iris":{"blades":5,"mask":{"png_base64":"AAAA"}})"),
     "bad_value", "/iris/blades"},
    {"irregular_round_iris", With(R"("iris":{"irregularity":0.5})"), "bad_value",
     "/iris/irregularity"},
    {"irregularity_above_1", With(R"("iris":{"blades":5,"irregularity":1.5})"), "bad_value",
     "/iris/irregularity"},
    {"dwaa", With(R"("output":{"compression":"dwaa"})"), "unsupported", "/output/compression"},
};

std::string NameOf(const testing::TestParamInfo<BadRequest>& info) {
    return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(Syntax, BadRequests, testing::ValuesIn(kSyntax), NameOf);
INSTANTIATE_TEST_SUITE_P(Fields, BadRequests, testing::ValuesIn(kFields), NameOf);
INSTANTIATE_TEST_SUITE_P(Frame, BadRequests, testing::ValuesIn(kFrame), NameOf);
INSTANTIATE_TEST_SUITE_P(Lights, BadRequests, testing::ValuesIn(kLightsTable), NameOf);
INSTANTIATE_TEST_SUITE_P(NotBuilt, BadRequests, testing::ValuesIn(kNotBuilt), NameOf);

// Every prefix of a sound body is refused: a message cut off on the way is never taken for a whole.
TEST(TruncatedBody, IsRefusedWhereverItIsCut) {
    const std::string body = With(R"("iris":{"blades":6},"quality":{"preset":"final"})");
    ASSERT_EQ(RefusalOf(DecodeFlareRequest(body)), nullptr);
    for (std::size_t size = 0; size < body.size(); ++size) {
        const auto decoded = DecodeFlareRequest(body.substr(0, size));
        const Refusal* refusal = RefusalOf(decoded);
        ASSERT_NE(refusal, nullptr) << "cut at " << size;
        EXPECT_EQ(refusal->code, "bad_json");
        EXPECT_EQ(refusal->where.rfind("byte ", 0), 0u) << refusal->where;
    }
}

// Whatever bytes come in, the answer is a request or a refusal that names a code and a place.
TEST(DamagedBodies, AreAnsweredInOrder) {
    const std::string sound = With(
        R"("prescription":{"name":"p","surface":[{"kind":"stop"}]},"iris":{"blades":6},)"
        R"("color_space":"spectral","wavelengths_nm":[4e2,587.5618],"output":{"pixel":"half"})");
    const std::string alphabet = "{}[]\",:0123456789eE+-.\\u/ntrfalse \xff\xc3\x80\x01";
    std::mt19937 random(20'240'229);
    const auto pick = [&](std::size_t count) { return random() % count; };
    for (int round = 0; round < 20'000; ++round) {
        std::string body = sound;
        for (std::size_t change = 0; change <= pick(4); ++change) {
            const std::size_t at = pick(body.size());
            switch (pick(4)) {
                case 0:
                    body[at] = alphabet[pick(alphabet.size())];
                    break;
                case 1:
                    body.erase(at, 1 + pick(8));
                    break;
                case 2:
                    body.insert(at, 1 + pick(3), alphabet[pick(alphabet.size())]);
                    break;
                default:
                    body.insert(at, body.substr(pick(body.size()), pick(30)));
                    break;
            }
        }
        const auto decoded = DecodeFlareRequest(body);
        const Refusal* refusal = RefusalOf(decoded);
        if (!refusal) continue;
        EXPECT_FALSE(refusal->code.empty()) << body;
        EXPECT_FALSE(refusal->message.empty()) << body;
        const std::string& where = refusal->where;
        EXPECT_TRUE(where.empty() || where[0] == '/' || where.rfind("byte ", 0) == 0) << where;
    }
}

}  // namespace
}  // namespace flare::wire
