// SPDX-License-Identifier: Apache-2.0
//
// What to render: the request of POST /v1/flare in the core's own words, with the lens already
// loaded. Plain values; CheckRequest says what is wrong with them, with the JSON pointer of the
// field.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/vec.h"
#include "core/optics/iris.h"
#include "core/optics/lens.h"
#include "core/optics/lens_state.h"

namespace flare {

enum class Projection { kAuto, kRectilinear, kLens };
enum class Units { kSceneLinear, kSensorIrradiance };
enum class ColorMode { kLinRec709, kSpectral };
enum class QualityPreset { kDraft, kPreview, kFinal, kReference };

struct ImageSpec {
    int width = 0, height = 0;  // of the full frame, pixels
    double sensor_width_mm = 36.0;
    Vec2d center_offset_mm{0.0,
                           0.0};  // where the optical axis meets the image, right and up of centre
    double pixel_aspect = 1.0;    // width of a pixel over its height, on the sensor
    std::optional<std::array<int, 4>> crop;   // x, y, w, h inside the full frame
    std::array<int, 4> overscan{0, 0, 0, 0};  // left, top, right, bottom, pixels
    Projection projection = Projection::kAuto;
    // An anamorphic lens's picture in the proportions of the scene, not squeezed as on the sensor:
    // pixels are then narrower on the sensor by the lens's squeeze.
    bool desqueeze = false;
};

// Which ghosts of two reflections are left out (ghost_culling.h): by the light lost, none, or by
// the rules of older renderers, for comparison.
enum class CullingRule { kAuto, kNone, kReport };

// What physics is asked for.
struct ModelSpec {
    int reflections = 2;  // 2, or 4: the four-reflection ghosts above the threshold as well
    // Smallest peak irradiance, per unit E0, of a four-reflection ghost that is rendered.
    double four_reflection_threshold = 1e-3;
    bool sensor_reflection = false;  // ghosts that the sensor reflects; the lens must have one
    CullingRule culling = CullingRule::kAuto;
};

// What the picture is made of; one at least.
struct LayerChoice {
    bool ghosts = true;
    bool starburst = false;
};

// How the starburst is drawn.
struct StarburstSpec {
    // With the direct image: the pattern inside its first dark ring.
    bool core = true;
    // A blade iris that is not steady: the mean over this many turns within +-jitter_deg.
    double jitter_deg = 0.0;
    int jitter_count = 8;
    std::uint64_t seed = 0;
};

struct LightSpec {
    std::optional<Vec3d>
        direction;               // camera axes (x right, y up, z into the scene), towards the light
    std::optional<Vec2d> pixel;  // or the place in the full frame, from its top left corner
    std::optional<double> distance_m;   // from the centre of the entrance pupil; absent: infinity
    Vec3d irradiance{1.0, 1.0, 1.0};    // E0 on a plane perpendicular to the direction, RGB
    double angular_diameter_deg = 0.0;  // of its disc; 0: a point
};

struct FlareRequest {
    std::shared_ptr<const Lens> lens;       // zoomed and focused
    LensState state;                        // that it is in, for the record
    std::vector<StateClamp> state_clamped;  // what was asked outside the lens's range
    ModelSpec model;
    LayerChoice layers;
    StarburstSpec starburst;
    std::optional<double> f_number;  // absent: the lens's own
    IrisShape iris;
    ImageSpec image;
    std::vector<LightSpec> lights;
    Units units = Units::kSceneLinear;
    ColorMode color = ColorMode::kLinRec709;
    std::vector<double> wavelengths_nm;  // for kSpectral
    QualityPreset quality = QualityPreset::kPreview;
};

// Limits of a request; the wire has its own copy in protocol/limits.h and the two are tested equal.
inline constexpr int kMaxLights = 100'000;
inline constexpr int kMaxImageSide = 16'384;
inline constexpr long long kMaxImagePixels = 1LL << 26;
inline constexpr int kMaxWavelengths = 1'000;
inline constexpr double kMaxFourReflectionThreshold = 1e6;
inline constexpr double kMaxAngularDiameter_deg = 20.0;
inline constexpr double kMaxJitter_deg = 180.0;
inline constexpr int kMaxJitterCount = 32;

}  // namespace flare
