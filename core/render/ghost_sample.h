// SPDX-License-Identifier: Apache-2.0
//
// A quick look at one ghost of one light: a few hundred rays, traced in columns and kept nowhere.
// First-order optics at the light's own angle says where in the pupil they go; where that misses,
// the pass region is searched for. Flux is good to about ten per cent
// (tests/physics/ghost_culling_test.cpp), some 0.1 ms a ghost: for choosing what to draw and for
// estimating errors, not for reporting the light of what is drawn.
//
// Every number goes continuously with light, iris, focus and zoom, but for the few per cent by
// which two samplings of one ghost differ. Depends on the arithmetic class of trace_columns.h in
// the last digits.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image/ghost_walk.h"
#include "core/mesh/pass_region.h"
#include "core/mesh/transmission.h"
#include "core/tracing/light_bundle.h"

namespace flare {

// What a ghost is sampled for: which light, through which opening, on which frame.
struct SampleScene {
    const Lens& lens;
    const LightBundle& bundle;
    const CanonicalPose& pose;
    const Iris& iris;
    // At the first wavelength fluxes are told; all of them make the ghost's light, each with its
    // weight (the irradiance of the light there).
    const TransmissionTables& tables;
    std::vector<double> weights;
    PictureMap map;
    double width = 0.0, height = 0.0;  // of the whole frame, pixels
};

struct GhostSample {
    double flux_mm2 = 0.0;        // on the whole sensor plane, for E0 = 1
    double frame_flux_mm2 = 0.0;  // the part of it that falls on the frame
    double frame_light = 0.0;     // the same over all wavelengths, weighted
    // Largest weighted irradiance on the frame: mean over a pixel, raised at folds by as much as a
    // fold of that size can.
    double peak = 0.0;
    double area_px2 = 0.0;                           // of the footprint on the sensor plane
    double box_width_px = 0.0, box_height_px = 0.0;  // around the footprint
    Vec2d box_lo_px{0.0, 0.0}, box_hi_px{0.0, 0.0};  // that box, full-frame pixels
    Rect region;  // of the bundle's plane that was sampled: every ray that passes, and some around
    std::uint64_t rays = 0, ray_surfaces = 0;
};

GhostSample SampleGhost(const SampleScene& scene, const BounceSequence& sequence);

}  // namespace flare
