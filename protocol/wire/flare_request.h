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
enum class ColorSpace { kLinRec709, kSpectral };
enum class Preset { kDraft, kPreview, kFinal, kReference };
enum class Compression { kZip, kNone };
enum class PixelType { kHalf, kFloat };
enum class Ringing { kAuto, kOff };
enum class Culling { kAuto, kNone, kReport };

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
};

struct Starburst {
    bool core = true;
    double jitter_deg = 0.0;
    int jitter_count = 8;
    int seed = 0;
};

struct Iris {
    int blades = 0;  // 0: round
    double roundness = 0.0;
    double rotation_deg = 0.0;
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

// Exactly one of direction and pixel is there.
struct Light {
    std::optional<std::array<double, 3>> direction;  // not zero; any length
    std::optional<std::array<double, 2>> pixel;
    std::optional<double> distance_m;  // absent: infinitely far
    std::array<double, 3> irradiance{1.0, 1.0, 1.0};
    double angular_diameter_deg = 0.0;  // of its disc; 0: a point
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
    Preset preset = Preset::kPreview;
    Layers layers;
    Starburst starburst;
    Model model;
    Output output;
};

}  // namespace flare::wire
