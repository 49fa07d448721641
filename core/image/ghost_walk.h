// SPDX-License-Identifier: Apache-2.0
//
// Walks over one ghost and hands out the pieces of it that reach the sensor: small
// polygons on the picture, each with the light that falls on it. A piece is a part of a mesh cell
// so small that the map from pupil to sensor is linear over it to a stated tolerance, clipped by
// the iris at every stop crossing and by the rims. All pieces together carry exactly the light that
// passes the masks, also at folds and where the ghost is a point.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/image/ghost_fringes.h"
#include "core/mesh/ghost_surface.h"
#include "core/optics/iris.h"

namespace flare {

// Sensor (canonical lens space) to picture: pixel = linear * mm + offset. Also turns stop
// coordinates back into lens space, since the iris does not turn with the light.
struct PictureMap {
    Vec2d px_per_x{1.0, 0.0}, px_per_y{0.0, 1.0};  // pixels a mm along canonical sensor x and y
    Vec2d offset_px{0.0, 0.0};
    // Canonical x and y as they stand in lens space.
    Vec2d stop_per_x{1.0, 0.0}, stop_per_y{0.0, 1.0};

    Vec2d Pixel(double x_mm, double y_mm) const {
        return offset_px + px_per_x * x_mm + px_per_y * y_mm;
    }
};

// How finely a ghost is cut up.
struct WalkTolerance {
    double position_px = 0.05;   // a piece's edges against the smooth surface
    double density_step = 0.03;  // relative change of irradiance across a piece
    double smallest_px = 1.5;    // pieces are not cut smaller than this for density's sake
    double largest_px = 16.0;
    double mask_step = 0.06;  // length of a piece at a mask's edge, in units of its radius
};

// The masks that cut a ghost anywhere, and the fields that tell of them.
struct MaskFields {
    std::vector<int> crossings;  // of the stop: two fields each, in camera coordinates
    std::vector<int> rims;       // one field each, after all crossings
    int count() const {
        return 2 * static_cast<int>(crossings.size()) + static_cast<int>(rims.size());
    }
};

// A prepared ghost: surface and light. Shared read-only by all threads.
struct GhostLight {
    std::shared_ptr<const GhostSurface> surface;
    int channels = 1;

    // A cell that is drawn, and the first of its points in `light`: a lattice of light_cuts + 1
    // points a side (more than the corners where transmittance bends sharply, as near the critical
    // angle), row by row along v.
    struct Cell {
        CellPlace place;
        double x0 = 0.0, x1 = 0.0, y0 = 0.0, y1 = 0.0;  // what of the picture it may touch
        bool open = false;                              // no mask cuts it at any drawn wavelength
        bool ring = false;  // around the cells that are drawn: for interpolation only
        int light_cuts = 1;
        std::size_t light_at = 0;
    };
    std::vector<Cell> cells;

    MaskFields masks;  // for tiles

    std::shared_ptr<const GhostFringes> fringes;  // none: the iris's edges are sharp

    // Drawn wavelengths, and the weights of the traced nodes.
    struct Band {
        std::vector<double> node_weights;
        int layer = 0;
        double wavelength_nm = 0.0;
    };
    std::vector<Band> bands;

    // Light per du dv (irradiance, transmittance and colour multiplied) in units of `light_unit`:
    // point by point all bands, `channels` numbers a band.
    std::vector<float> light;
    double light_unit = 1.0;
    std::size_t NumbersAPoint() const { return bands.size() * static_cast<std::size_t>(channels); }

    // What cuts it: the iris given, or that of its fringes.
    const Iris& IrisOr(const Iris& iris) const { return fringes ? fringes->iris : iris; }
};

// The part of the picture that is wanted, in pixels; pieces wholly outside may be left out.
struct WalkWindow {
    double x0 = -1e300, y0 = -1e300, x1 = 1e300, y1 = 1e300;
};

// Receives the pieces of a ghost.
class PieceSink {
  public:
    virtual ~PieceSink() = default;
    // Could a piece within this box be of use? Asked before its masks and its light are found.
    virtual bool Wants(const Vec2d& /*lo*/, const Vec2d& /*hi*/) const { return true; }
    // A polygon in pixels (either orientation, simple) at one drawn wavelength and the light on it,
    // one number a channel, in units of E0 mm^2.
    virtual void Add(std::span<const Vec2d> points, std::span<const double> light, int band) = 0;
    // All wavelengths of one part of the pupil have been added.
    virtual void EndOfPiece() = 0;
};

class GhostWalk {
  public:
    // All arguments must outlive the walk.
    GhostWalk(const GhostLight& ghost, const Iris& iris, const PictureMap& map,
              const WalkTolerance& tolerance);
    ~GhostWalk();
    GhostWalk(const GhostWalk&) = delete;
    GhostWalk& operator=(const GhostWalk&) = delete;

    // The pieces of one cell, at all drawn wavelengths, in an order that the window does not
    // change.
    void Cell(const GhostLight::Cell& cell, const WalkWindow& window, PieceSink& sink);

    std::uint64_t pieces() const;

  private:
    struct Work;
    std::unique_ptr<Work> work_;
};

}  // namespace flare
