// SPDX-License-Identifier: Apache-2.0
//
// Every limit on data from outside. A request that goes past one is refused with code "limit" (or
// "too_large" for the body) and the place of the value; it is never cut down silently. Lengths are
// mm, wavelengths nm, the rest as named.
#pragma once

#include <cstddef>
#include <cstdint>

namespace flare::limits {

// The body as text.
inline constexpr std::size_t kBodyBytes = std::size_t{16} << 20;
inline constexpr int kJsonDepth = 16;                  // objects and arrays inside each other
inline constexpr std::size_t kJsonValues = 2'000'000;  // values in one body, containers included
inline constexpr std::size_t kJsonMembers = 128;       // members of one object
inline constexpr std::size_t kJsonKeyBytes = 128;      // of a member's name
inline constexpr std::size_t kStringBytes = 16'384;    // of any string
inline constexpr std::size_t kMaskTextBytes = std::size_t{8} << 20;  // of a mask as base64
inline constexpr int kMaskSide = 2'048;                              // pixels of a mask
inline constexpr std::size_t kNameBytes = 200;  // of the name of a lens or a coating

// The HTTP message around it.
inline constexpr std::size_t kHeaderBytes = 16'384;
inline constexpr std::size_t kTargetBytes = 2'048;

// The picture.
inline constexpr int kImageSide = 16'384;  // pixels of the frame with its overscan
// Of the picture: the crop, or the frame with its overscan; counted once for each three channels.
inline constexpr std::int64_t kImagePixels = std::int64_t{1} << 26;
inline constexpr double kMinSensorWidth_mm = 0.01;
inline constexpr double kMaxSensorWidth_mm = 10'000.0;
inline constexpr double kMaxCenterOffset_mm = 10'000.0;
inline constexpr double kMinPixelAspect = 0.01;
inline constexpr double kMaxPixelAspect = 100.0;
inline constexpr std::size_t kWavelengths = 1'000;
// Points of a light's spectrum or a camera's sensitivity. Lamps are measured beyond the visible.
inline constexpr std::size_t kCurvePoints = 4'000;
inline constexpr double kMaxCurve_nm = 100'000.0;
inline constexpr double kMaxCurveValue = 1e30;
inline constexpr double kMinTemperature_k = 500.0;
inline constexpr double kMaxTemperature_k = 1e6;
inline constexpr double kMinWavelength_nm = 300.0;
inline constexpr double kMaxWavelength_nm = 1'100.0;

// The light.
inline constexpr std::size_t kLights = 100'000;
inline constexpr double kMaxIrradiance = 1e30;  // in the request's own unit
inline constexpr double kMinDistance_m = 1e-3;
inline constexpr double kMaxDistance_m = 1e20;  // of the focus, too
inline constexpr double kMaxPixelCoordinate = 1e6;
inline constexpr double kMaxAngularDiameter_deg = 20.0;
inline constexpr std::size_t kShapes = 64;  // lights of a request that have a shape
inline constexpr int kShapeSide = 1'024;    // pixels of its image

// The starburst.
inline constexpr double kMaxJitter_deg = 180.0;
inline constexpr int kMaxJitterCount = 32;
inline constexpr double kMinTolerance = 0.001, kMaxTolerance = 0.25;
inline constexpr double kMaxTimeBudget_ms = 600'000.0;
inline constexpr int kMaxSeed = 2'147'483'647;

// What can be seen.
inline constexpr double kMaxExposure_stops = 60.0;
inline constexpr double kMaxNoiseFloor = 1e30;

// Layers beside the sums, and an artist's hand on ghosts.
inline constexpr std::size_t kSplitLayers = 256;
// Of all split layers together, counted once for each three channels.
inline constexpr std::size_t kSplitPixels = std::size_t{1} << 27;
inline constexpr std::size_t kArtistGhosts = 1'024;
inline constexpr double kMaxArtistGain = 1e6;  // and of a tint's channels

// The lens.
inline constexpr double kMinFNumber = 1e-3;
inline constexpr double kMaxFNumber = 10'000.0;
inline constexpr double kMaxZoom_mm = 1e6;
inline constexpr int kMinBlades = 3;
inline constexpr int kMaxBlades = 32;
inline constexpr int kMaxMarks = 1'000;  // specks, and scratches
inline constexpr double kMinMark_mm = 0.001, kMaxMark_mm = 100.0;
inline constexpr double kMaxRotation_deg = 36'000.0;
inline constexpr std::size_t kSurfaces = 100;              // of a lens
inline constexpr std::size_t kPrescriptionValues = 4'000;  // JSON values of one

// The reference by photons.
inline constexpr int kMinPhotonSamples = 64;  // a ghost, light and wavelength
inline constexpr int kMaxPhotonSamples = 100'000'000;
inline constexpr double kMinPhotonKernel_px = 0.5;
inline constexpr double kMaxPhotonKernel_px = 64.0;
inline constexpr int kMinPhotonNearest = 2;
inline constexpr int kMaxPhotonNearest = 10'000;

// The model.
inline constexpr double kMaxFourReflectionThreshold = 1e6;  // peak irradiance for E0 = 1

// Warming.
inline constexpr std::size_t kWarmLights = 4'096;  // of one request
inline constexpr std::size_t kWarmJobs = 16;       // that are not done
inline constexpr std::size_t kWarmJobsKept = 256;  // that can still be asked about

// Lens encoders.
inline constexpr std::size_t kEncoders = 64;               // of one program
inline constexpr std::size_t kEncoderMarks = 1'000;        // of one calibration table
inline constexpr std::size_t kEncoderHistory = 4'096;      // readings kept of one encoder
inline constexpr std::size_t kScriptSamples = 1'000'000;   // of a file to be replayed
inline constexpr std::size_t kOpenTrackIoBytes = 262'144;  // of a sample in segments
inline constexpr double kMaxEncoderTime_s = 1e11;          // Unix time
inline constexpr double kMaxEncoderAge_ms = 1e12;

// The ray tracer's input.
inline constexpr std::size_t kTraceRays = 200'000;
inline constexpr std::size_t kBounces = 8;

// The report: rows of ghosts in the whole, and its size in a header.
inline constexpr std::size_t kReportGhosts = 4'096;
inline constexpr std::size_t kReportSummaryBytes = 4'096;

}  // namespace flare::limits
