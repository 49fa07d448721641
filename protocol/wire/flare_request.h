// SPDX-License-Identifier: Apache-2.0
//
// The body of POST /v1/flare as plain values, with defaults filled in. Only what is built has a
// field here; the codec refuses the rest of the contract as "unsupported". Values are finite and
// inside protocol/limits.h. Units stand in the names.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "protocol/wire/lens_choice.h"

namespace flare::wire {

enum class Projection { kDefault, kRectilinear, kLens };
enum class Units { kSceneLinear, kSensorIrradiance };
enum class ColorSpace { kLinRec709, kAcesCg, kAces2065, kSpectral };
enum class Preset { kDraft, kPreview, kFinal, kReference };
enum class Compression { kZip, kNone };
enum class PixelType { kHalf, kFloat };
enum class Ringing { kAuto, kOff };
enum class Culling { kAuto, kNone, kReport };
enum class Split { kNone, kGhost, kLight };

// What physics is asked for.
struct Model {
    int reflections = 2;                      // or 4
    double four_reflection_threshold = 1e-3;  // peak irradiance for E0 = 1
    bool sensor_reflection = false;
    Ringing ringing = Ringing::kAuto;
    Culling culling = Culling::kAuto;
};

struct Layers {
    bool ghosts = true;
    bool starburst = false;
    bool bokeh = false;
};

struct Starburst {
    bool core = true;
    double jitter_deg = 0.0;
    int jitter_count = 8;
    int seed = 0;
};

enum class IrisMaskScale { kArea, kStop };

struct IrisMask {
    std::string png;  // its bytes, not looked at
    IrisMaskScale scale = IrisMaskScale::kArea;
};

struct IrisDust {
    int count = 0;
    double size_mm = 0.1, opacity = 1.0;
    int seed = 0;
};

struct IrisScratches {
    int count = 0;
    double length_mm = 3.0, width_mm = 0.03, opacity = 1.0;
    int seed = 0;
};

// What an artist makes of one ghost.
struct ArtistGhost {
    std::vector<int> sequence;
    double gain = 1.0;
    std::array<double, 3> tint{1.0, 1.0, 1.0};  // not in kSpectral
    bool mute = false;
};

struct Iris {
    int blades = 0;  // 0: round
    double roundness = 0.0;
    double rotation_deg = 0.0;
    double irregularity = 0.0;  // with blades
    int seed = 0;
    std::optional<IrisMask> mask;  // scaled by area: without blades
    // On the stop; never together with a mask.
    std::optional<IrisDust> dust;
    std::optional<IrisScratches> scratches;
};

struct Image {
    int width = 0, height = 0;
    double sensor_width_mm = 0.0;
    std::array<double, 2> center_offset_mm{0.0, 0.0};
    double pixel_aspect = 1.0;
    std::optional<std::array<int, 4>> crop;   // x, y, w, h
    std::array<int, 4> overscan{0, 0, 0, 0};  // left, top, right, bottom
    Projection projection = Projection::kDefault;
    bool desqueeze = false;  // in the proportions of the scene, not as squeezed on the sensor
};

// Relative power at ascending wavelengths.
struct SampledSpectrum {
    std::vector<double> wavelengths_nm, values;
};

// What a camera's channels see at ascending wavelengths.
struct Camera {
    std::vector<double> wavelengths_nm, red, green, blue;
};

// Exactly one of direction and pixel is there; of temperature and spectrum at most one.
struct Light {
    std::optional<std::array<double, 3>> direction;  // not zero; any length
    std::optional<std::array<double, 2>> pixel;
    std::optional<double> distance_m;  // absent: infinitely far
    std::array<double, 3> irradiance{1.0, 1.0, 1.0};
    std::optional<double> temperature_k;
    std::optional<SampledSpectrum> spectrum;
    double angular_diameter_deg = 0.0;     // of its disc or its shape's longer side; 0: a point
    std::optional<std::string> shape_png;  // bytes of an image of its shape, not looked at
};

// The reference by photons in place of meshes.
enum class PhotonEstimate { kPixel, kKernel, kNearest };
struct Photon {
    int samples = 1 << 18;
    int seed = 0;
    PhotonEstimate estimate = PhotonEstimate::kPixel;
    double kernel_px = 2.0;
    int nearest = 32;
};

// One preset; or one of the three numbers, and then the preset means nothing.
struct Quality {
    Preset preset = Preset::kPreview;
    std::optional<double> tolerance, max_error, time_budget_ms;
    std::optional<Photon> photon;  // with kReference alone
};

// Nothing fainter than noise_floor / 2^exposure_stops is to be seen.
struct Visible {
    double exposure_stops = 0.0;
    double noise_floor = 0.0;
};

struct Output {
    Compression compression = Compression::kZip;
    PixelType pixel = PixelType::kHalf;
};

// A live lens encoder in place of numbers.
struct EncoderChoice {
    std::string name;
    std::optional<double> time_s;      // Unix time; absent: now
    std::optional<double> max_age_ms;  // absent: any
};

struct FlareRequest {
    LensChoice lens;
    std::optional<EncoderChoice> encoder;
    Iris iris;
    Image image;
    std::vector<Light> lights;
    Units units = Units::kSceneLinear;
    ColorSpace color_space = ColorSpace::kLinRec709;
    std::vector<double> wavelengths_nm;  // for kSpectral: at least one, all different
    std::optional<Camera> camera;
    Quality quality;
    Layers layers;
    Starburst starburst;
    Split split = Split::kNone;
    std::vector<ArtistGhost> artist;
    Model model;
    std::optional<Visible> visible;
    Output output;
};

}  // namespace flare::wire
