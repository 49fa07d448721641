// SPDX-License-Identifier: Apache-2.0
//
// What to render: the request of POST /v1/flare in the core's own words, with the lens already
// loaded. Plain values; CheckRequest says what is wrong with them, with the JSON pointer of the
// field.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/vec.h"
#include "core/optics/iris.h"
#include "core/optics/lens.h"
#include "core/optics/lens_state.h"
#include "core/spectrum/color_response.h"

namespace flare {

struct QualitySettings;
class SourcePicture;

enum class Projection { kAuto, kRectilinear, kLens };
enum class Units { kSceneLinear, kSensorIrradiance };
enum class ColorMode { kLinRec709, kAcesCg, kAces2065, kSpectral };
enum class QualityPreset { kDraft, kPreview, kFinal, kReference };

// How good the picture is to be: a preset, or one of the three others, which take its place.
struct Quality {
    QualityPreset preset = QualityPreset::kPreview;
    // A point between the presets (quality.h): about the rel_l1 that it leaves.
    std::optional<double> tolerance;
    // The coarsest tolerance whose estimated rel_l1 is no larger (quality_search.h).
    std::optional<double> max_error;
    // The finest tolerance that is expected to be done in time.
    std::optional<double> time_budget_ms;

    Quality() = default;
    Quality(QualityPreset one_of_four) : preset(one_of_four) {}  // NOLINT: every preset is one
    static Quality Tolerance(double tolerance) {
        Quality quality;
        quality.tolerance = tolerance;
        return quality;
    }
    // Is it known what to draw, or must that be looked for?
    bool IsPlan() const { return !max_error && !time_budget_ms; }

    friend bool operator==(const Quality&, const Quality&) = default;
};

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
// the rules of older renderers, for comparison: both of them, or one alone.
enum class CullingRule { kAuto, kNone, kReport, kReportSize, kReportCrossings };

// What can be seen of the picture (visible.h): nothing fainter than the floor.
struct VisibleSpec {
    double exposure_stops = 0.0;  // that the picture will be shown brighter by
    double noise_floor = 0.0;     // of the picture as shown
    double Floor() const { return noise_floor * std::exp2(-exposure_stops); }  // as rendered
};

// What physics is asked for.
struct ModelSpec {
    int reflections = 2;  // 2, or 4: the four-reflection ghosts above the threshold as well
    // Smallest peak irradiance, per unit E0, of a four-reflection ghost that is rendered.
    double four_reflection_threshold = 1e-3;
    bool sensor_reflection = false;  // ghosts that the sensor reflects; the lens must have one
    CullingRule culling = CullingRule::kAuto;
    // Diffraction fringes where they can be seen (fringe_plan.h); on the wire the default.
    bool ringing = false;
};

// What the picture is made of; one at least.
struct LayerChoice {
    bool ghosts = true;
    bool starburst = false;
    bool bokeh = false;
};

// Layers beside the sums: one for each ghost, or one for each light with all that it adds.
enum class SplitBy { kNone, kGhost, kLight };

// What an artist makes of one ghost. The picture is then no longer what the lens does.
struct ArtistGhost {
    std::vector<int> sequence;
    double gain = 1.0;
    Vec3d tint{1.0, 1.0, 1.0};  // colour only
    bool mute = false;
};

// How the starburst is drawn.
struct StarburstSpec {
    // With the direct image: the pattern inside its first dark ring. Never beside a bokeh layer,
    // which holds that image.
    bool core = true;
    // A blade iris that is not steady: the mean over this many turns within +-jitter_deg.
    double jitter_deg = 0.0;
    int jitter_count = 8;
    std::uint64_t seed = 0;
};

// How photons on the sensor become light a pixel (photon_map.h).
enum class PhotonEstimate { kPixel, kKernel, kNearest };

// The reference by random samples in place of meshes.
struct PhotonSpec {
    std::int64_t samples = 1 << 18;  // for each ghost of each light, in the mean over the ghosts
    std::uint64_t seed = 0;
    PhotonEstimate estimate = PhotonEstimate::kPixel;
    double kernel_px = 2.0;  // radius of the fixed kernel
    int nearest = 32;        // k of the k nearest
};

struct LightSpec {
    std::optional<Vec3d>
        direction;               // camera axes (x right, y up, z into the scene), towards the light
    std::optional<Vec2d> pixel;  // or the place in the full frame, from its top left corner
    std::optional<double> distance_m;  // from the centre of the entrance pupil; absent: infinity
    // E0 on a plane perpendicular to the direction: RGB of the request's space, or one number.
    Vec3d irradiance{1.0, 1.0, 1.0};
    // In colour: the irradiance multiplies, channel by channel, the colour of a blackbody of this
    // temperature, or of this spectrum; each scaled to luminance 1. Not both.
    std::optional<double> temperature_k;
    std::shared_ptr<const Spectrum> spectrum;
    double angular_diameter_deg = 0.0;  // of its disc; 0: a point
    // In place of a disc, its longer side as wide as that; null: a disc.
    std::shared_ptr<const SourcePicture> shape;
};

struct FlareRequest {
    std::shared_ptr<const Lens> lens;       // zoomed and focused
    LensState state;                        // that it is in, for the record
    std::vector<StateClamp> state_clamped;  // what was asked outside the lens's range
    ModelSpec model;
    LayerChoice layers;
    StarburstSpec starburst;
    SplitBy split = SplitBy::kNone;
    std::vector<ArtistGhost> artist;  // different sequences
    std::optional<double> f_number;   // absent: the lens's own
    IrisShape iris;
    ImageSpec image;
    std::vector<LightSpec> lights;
    Units units = Units::kSceneLinear;
    ColorMode color = ColorMode::kLinRec709;
    // In colour: what the channels see, in place of the observer of the space.
    std::shared_ptr<const ColorResponse> camera;
    std::vector<double> wavelengths_nm;  // for kSpectral
    Quality quality;
    std::optional<PhotonSpec> photon;  // of kReference alone
    std::optional<VisibleSpec> visible;
    // To measure single settings: in place of the quality's, which must then be a plan. Not on the
    // wire.
    std::shared_ptr<const QualitySettings> settings;
};

// The space of a colour request's numbers.
constexpr ColorSpace SpaceOf(ColorMode color) {
    return color == ColorMode::kAcesCg     ? ColorSpace::kAcesCg
           : color == ColorMode::kAces2065 ? ColorSpace::kAces2065
                                           : ColorSpace::kLinRec709;
}

// What the channels of a colour request see.
inline const ColorResponse& ResponseOf(const FlareRequest& request) {
    return request.camera ? *request.camera : ResponseOf(SpaceOf(request.color));
}

// Limits of a request; the wire has its own copy in protocol/limits.h and the two are tested equal.
inline constexpr int kMaxLights = 100'000;
inline constexpr int kMaxImageSide = 16'384;
inline constexpr long long kMaxImagePixels = 1LL << 26;
inline constexpr int kMaxWavelengths = 1'000;
inline constexpr double kMaxFourReflectionThreshold = 1e6;
inline constexpr double kMaxAngularDiameter_deg = 20.0;
inline constexpr double kMinTemperature_k = 500.0, kMaxTemperature_k = 1e6;
inline constexpr std::int64_t kMinPhotonSamples = 64, kMaxPhotonSamples = 100'000'000;
inline constexpr double kMaxPhotonPaths = 1 << 16;   // ghosts times lights
inline constexpr double kMaxPhotonRays = 2e10;       // of all ghosts, lights and wavelengths
inline constexpr double kMaxPhotonValues = 1 << 24;  // pixels times channels
inline constexpr double kMinPhotonKernel_px = 0.5, kMaxPhotonKernel_px = 64.0;
inline constexpr int kMinPhotonNearest = 2, kMaxPhotonNearest = 10'000;
inline constexpr double kMaxJitter_deg = 180.0;
inline constexpr int kMaxJitterCount = 32;
inline constexpr double kMinTolerance = 0.001, kMaxTolerance = 0.25;
inline constexpr double kMaxTimeBudget_ms = 600'000.0;
inline constexpr std::size_t kMaxSplitLayers = 256;
// Of all split layers together, counted once for each three channels.
inline constexpr std::size_t kMaxSplitPixels = std::size_t{1} << 27;
inline constexpr std::size_t kMaxArtistGhosts = 1'024;
inline constexpr double kMaxArtistGain = 1e6;
inline constexpr double kMaxExposure_stops = 60.0, kMaxNoiseFloor = 1e30;

// What is asked of a ghost; null: nothing.
inline const ArtistGhost* ArtistOf(const FlareRequest& request, const std::vector<int>& sequence) {
    for (const ArtistGhost& ghost : request.artist) {
        if (ghost.sequence == sequence) return &ghost;
    }
    return nullptr;
}

}  // namespace flare
