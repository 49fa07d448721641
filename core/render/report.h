// SPDX-License-Identifier: Apache-2.0
//
// What a render did. `Facts` follow from the request alone and may stand in the image; `Work`
// depends on caches, threads and the machine and stands only in the report.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/vec.h"

namespace flare {

struct LightFacts {
    Vec3d direction{0.0, 0.0, 1.0};  // camera axes, unit length, towards the light
    double field_deg = 0.0;          // angle to the axis
    bool chief_ray_arrives = false;
    Vec2d sensor_mm{0.0, 0.0};  // where the chief ray lands: x right, y up as the image shows it
    Vec2d pixel{0.0, 0.0};      // the same in the full frame
};

// Diffraction fringes of a ghost (fringe_plan.h), of the light and at the passage through the stop
// where they show most.
struct RingingFacts {
    std::string model = "geometric";  // "edge_profile", "propagation"
    // "visible"; or what hides them: "source", "pixel", "focus" (a pattern that is no profile along
    // an edge), "mask" (of an iris with a picture), "not_traced" (too few rays arrive).
    std::string reason;
    double weight = 0.0;  // of the pattern over a sharp edge, 0..1
    double z_mm = 0.0;    // over which the light of the stop spreads
    double fresnel_number = 0.0;
    double fringe_px = 0.0;  // from the geometric edge to the first maximum
};

struct GhostFacts {
    std::vector<int> sequence;
    // Which physics ran for it: RingingFacts::model, "culled" for every light, or "muted" by the
    // request.
    std::string model;
    double flux_mm2 = 0.0;  // sum over lights, per unit E0, on the whole sensor plane, at the d
                            // line (or the first wavelength of a spectral request)
    RingingFacts ringing;
    // Of lights that are no points: from how many directions it was drawn, each blurred by its part
    // of the source; 0 where blur was nowhere to be seen. The most of all lights.
    int source_directions = 0;
};

// The ghosts of four reflections, where they were asked for; sums over the lights.
struct FourReflectionFacts {
    double threshold = 0.0;  // peak irradiance per unit E0
    std::uint64_t sequences = 0, rendered = 0;
    double rendered_flux_mm2 = 0.0, lost_flux_mm2 = 0.0;
};

// Ghosts of two reflections that were left out or drawn fainter, each once a light; fluxes per unit
// E0 at the d line (or the first wavelength), as far as they fall on the frame, summed over the
// lights.
struct CullingFacts {
    std::uint64_t culled = 0, faded = 0;
    double frame_flux_mm2 = 0.0;  // of all ghosts
    double lost_flux_mm2 = 0.0;
};

// Estimated rel_l1 (compare.h) of the picture against the converged one, and its parts
// (error_estimate.h), which add up to it.
struct EstimatedError {
    double rel_l1 = 0.0;
    double culling = 0.0;
    double dispersion = 0.0;  // colours drawn at separate wavelengths
    double colour = 0.0;      // transmittances at few bands
    double mesh = 0.0;        // rays interpolated
    double pieces = 0.0;      // cells cut up
    double source = 0.0;      // lights of some size
};

// The starburst layer; sums over the lights.
struct StarburstFacts {
    bool core = true;          // the direct image is in it
    std::uint64_t lights = 0;  // whose direct image reaches the sensor plane
    double flux_mm2 = 0.0;    // of their patterns per unit E0, core included, at the d line (or the
                              // first wavelength of a spectral request)
    double core_share = 0.0;  // of that flux, inside the first dark ring
};

// Something left out because it cannot be seen.
struct UnseenFacts {
    std::uint64_t count = 0;
    double peak = 0.0;      // the most that a pixel can change by, in the request's units
    double flux_mm2 = 0.0;  // on the frame, per unit E0, at the d line (or the first wavelength)
};

// What was left out below the floor of FlareRequest::visible (visible.h); sums over the lights.
struct VisibleFacts {
    double floor = 0.0;                    // in the request's units
    UnseenFacts ghosts, four_reflections;  // not drawn, each counted once a light
    // Ghosts drawn at the fewest wavelengths, with sharp edges, as of a point; their whole light.
    UnseenFacts details;
    UnseenFacts starburst;  // lights whose tails end within the frame
};

// A picture by photons.
struct PhotonFacts {
    std::uint64_t rays = 0;    // traced, the pilot's included
    std::uint64_t landed = 0;  // on the picture
    double rel_l1 = 0.0;  // expected of the noise: sum of the mean errors over that of the light
};

// The bokeh layer; sums over the lights.
struct BokehFacts {
    std::uint64_t lights = 0;  // whose direct image reaches the sensor plane
    double flux_mm2 = 0.0;     // of these images per unit E0, on the whole sensor plane, at the d
                               // line (or the first wavelength of a spectral request)
};

struct Facts {
    std::optional<double> focus_m, zoom_mm;  // absent: infinity; not a zoom
    double squeeze = 1.0;                    // of an anamorphic lens

    double f_number = 0.0;  // after clamping
    double working_f_number = 0.0;
    double t_axis = 0.0;
    double scene_linear_factor = 1.0;  // multiply sensor irradiance by this for scene_linear
    std::vector<std::string>
        clamped;                   // JSON pointers of values that were clamped, with "from -> to"
    double culled_flux_mm2 = 0.0;  // light left out on purpose: by culling, and of four reflections
    CullingFacts culling;
    EstimatedError estimated_error;
    std::optional<FourReflectionFacts> four_reflections;
    std::optional<StarburstFacts> starburst;
    std::optional<PhotonFacts> photon;
    std::optional<BokehFacts> bokeh;
    std::optional<VisibleFacts> visible;
    std::vector<LightFacts> lights;  // the first 64
    std::vector<GhostFacts> ghosts;
    std::uint64_t saturated_pixels = 0;  // half output clipped at 65504, filled in by the encoder
};

// What looking for a plan took (quality_search.h).
struct SearchWork {
    std::uint64_t pictures = 0;  // drawn, the answer included
    std::uint64_t overruns = 0;  // of them called off
    double total_ms = 0.0;       // of all of them and the survey
};

struct Work {
    std::uint64_t rays_traced = 0;
    std::uint64_t ray_surfaces = 0;
    std::uint64_t sampled_rays = 0;  // traced for the choice of ghosts, and not kept
    std::uint64_t cells = 0;         // mesh cells looked at
    std::uint64_t polygons = 0;      // pieces of cells spread over pixels
    std::uint64_t fragments = 0;     // pixels touched, counted once a piece
    std::uint64_t mesh_hits = 0, mesh_misses = 0;
    std::uint64_t mesh_disk_hits = 0;  // those of mesh_hits that were read from disk
    std::uint64_t ghost_hits = 0;      // those of mesh_hits whose tiles were kept as well
    // Setup: coating tables, plans and the picture's memory, before the first light.
    std::optional<SearchWork> search;
    double setup_ms = 0.0, cull_ms = 0.0, mesh_ms = 0.0, raster_ms = 0.0, resolve_ms = 0.0;

    // The counts of another part of the work, without times.
    void Add(const Work& part) {
        rays_traced += part.rays_traced;
        ray_surfaces += part.ray_surfaces;
        sampled_rays += part.sampled_rays;
        cells += part.cells;
        polygons += part.polygons;
        fragments += part.fragments;
        mesh_hits += part.mesh_hits;
        mesh_misses += part.mesh_misses;
        mesh_disk_hits += part.mesh_disk_hits;
        ghost_hits += part.ghost_hits;
    }
};

struct Report {
    Facts facts;
    Work work;
};

}  // namespace flare
