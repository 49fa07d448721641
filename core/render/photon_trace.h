// SPDX-License-Identifier: Apache-2.0
//
// Photons of one lamp through one bounce sequence: stratified random places on the front surface
// (and on the lamp's disc), random wavelengths, each traced exactly and landed on the sensor with
// its light. Every sample is a pure function of seed and number (philox.h).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/image/flare_image.h"
#include "core/optics/iris.h"
#include "core/render/photon_region.h"
#include "core/spectrum/color_response.h"

namespace flare {

// Where photons get their wavelengths from.
struct PhotonColors {
    std::vector<double> wavelengths_nm;
    std::vector<double> cumulative;  // probability up to and including each
    std::vector<Vec3d> value;        // what a photon of each counts for: light over probability
};

// One wavelength, its light in the first channel.
PhotonColors OneWavelength(double wavelength_nm, double irradiance);
// Every nanometre from 380 to 780 of a spectrum that is straight between its samples, by
// importance; channels are those of `response`.
PhotonColors ColorsOf(const Spectrum& power, const ColorResponse& response);

// From lens space to pixels of the full frame.
struct SensorMap {
    Vec2d pitch_mm, middle_px;

    Vec2d Pixel(const Vec2d& sensor_mm) const {
        return {middle_px.x - sensor_mm.x / pitch_mm.x, middle_px.y + sensor_mm.y / pitch_mm.y};
    }
};
SensorMap SensorMapOf(const FlareRequest& request);

struct Photon {
    Vec2d pixel;
    Vec3d light;  // E0 mm^2
};

// How many samples are taken where: `even` x `even` strata over the whole front surface, and in
// each cell of the region `fine` x `fine`; or, where there are fewer samples than cells (fine 0),
// `few` spread over the cells.
struct PhotonStrata {
    int even = 1;
    int fine = 0;
    int few = 0;

    // A tenth evenly, the rest in the region.
    static PhotonStrata For(double samples, const PhotonRegion& region);
    std::int64_t in_region(const PhotonRegion& region) const {
        return fine > 0 ? std::int64_t{fine} * fine * static_cast<std::int64_t>(region.cell_count())
                        : few;
    }
    std::int64_t count(const PhotonRegion& region) const {
        return std::int64_t{even} * even + in_region(region);
    }
};

// One lamp through one sequence, and which of its samples: numbers [first, first + count).
// `stream` differs for all that is to be independent.
struct PhotonBatch {
    const PhotonSource& source;
    const PhotonColors& colors;
    const BounceSequence& sequence;
    const PhotonRegion& region;
    std::uint64_t seed = 0;
    std::array<std::uint32_t, 2> stream{};
    PhotonStrata strata;
    std::int64_t first = 0;
    int count = 0;
};

struct LandedPhotons {
    std::vector<Photon> photons;
    double flux_mm2 = 0.0;  // of all that reach the sensor plane: sum of the first channel
};

// Those within `margin` of the window.
LandedPhotons TracePhotons(const Lens& lens, const Iris& iris, const PhotonBatch& batch,
                           const SensorMap& map, const PixelWindow& window, double margin);

}  // namespace flare
