// SPDX-License-Identifier: Apache-2.0
//
// What the stop transmits, as a picture over its plane: for irises that are no intersection of
// blades (holes, stars, dust) and for patterns of diffraction. Coordinates are mm in the stop
// plane, x right and y up as seen from behind the camera; dark outside the square.
//
// Values stand on a square grid of `side` x `side` cells over |x|, |y| <= half_width_mm; cell
// (i, j), at values[j * side + i], is the i-th from the left and the j-th from *below*, and holds
// the transmission of light (>= 0; above 1 for patterns) as a mean over the cell. A picture is
// either smooth, bilinear between the cells' middles, or sharp: where it crosses one half there is
// an edge, kept as a signed distance (the grey of antialiased cells says where in the cell), so
// that it stays crisp however far it is magnified, while shades on either side of edges are kept
// as they are. Edges lie within 0.1 cell of where an antialiased drawing had them; corners are
// rounded by about half a cell.
//
// Immutable once made, shared by threads. Memory about 12 bytes a cell, sharp ones 16 (24 with
// shades).
#pragma once

#include <memory>
#include <vector>

#include "core/base/vec.h"

namespace flare {

struct StopGrid {
    int side = 0;
    double half_width_mm = 0.0;
    std::vector<float> values;

    double cell_mm() const { return 2.0 * half_width_mm / side; }
};

// What of the stop plane counts: the parallelogram middle +- right / 2 +- down / 2, as a pixel of
// the image sees it, spread along `smear` (as a band of wavelengths is).
struct StopFootprint {
    Vec2d middle{0.0, 0.0};
    Vec2d right{0.0, 0.0}, down{0.0, 0.0};
    Vec2d smear{0.0, 0.0};
};

class StopPicture {
  public:
    // Values must be finite and >= 0, one a cell.
    static std::shared_ptr<const StopPicture> Smooth(StopGrid grid);
    static std::shared_ptr<const StopPicture> Sharp(StopGrid grid);

    // At a point.
    double At(Vec2d p) const;
    // Mean over a footprint, of any size: at most a few dozen look-ups.
    double Mean(const StopFootprint& footprint) const;

    // Bounds of what At gives within a box, and Mean for footprints that lie in it with a third of
    // their size to spare; not tight.
    struct Range {
        float lo = 0.0F, hi = 0.0F;
        bool dark() const { return hi <= 0.0F; }
        bool clear() const { return lo == 1.0F && hi == 1.0F; }
    };
    Range Over(double x0, double y0, double x1, double y1) const;

    // The integral of the transmission, exactly that of the values.
    double area_mm2() const { return area_mm2_; }
    // Dark farther from the centre than this.
    double outer_radius() const { return outer_radius_; }
    // Exactly 1 nearer to the centre than this; may be 0.
    double clear_radius() const { return clear_radius_; }
    double cell_mm() const { return cell_; }
    // The edges of a sharp picture: closed loops, anticlockwise around light and clockwise around
    // holes, the last point joined to the first.
    const std::vector<std::vector<Vec2d>>& outlines() const { return outlines_; }

  private:
    StopPicture(StopGrid grid, bool sharp);

    struct Plane {
        int side = 0;
        std::vector<float> values;
    };
    // By cells of a level, beyond the grid `outside`.
    static float Bilinear(const Plane& plane, double x, double y, float outside);

    void FindEdges();
    void FindShades(const std::vector<float>& values);
    void MakeLevels();
    void MakeRanges();
    void MeasureRadii();
    double SharpMean(const StopFootprint& footprint, int n, int m, int s) const;
    double LevelMean(const StopFootprint& footprint, int level, int n, int m, int s) const;
    // In cells of level 0, from the lower left corner.
    Vec2d Cells(Vec2d p) const {
        return {(p.x + half_width_) * per_cell_, (p.y + half_width_) * per_cell_};
    }

    double half_width_, cell_, per_cell_;
    bool sharp_;
    std::vector<Plane> levels_;       // means over 2^level cells a side
    std::vector<Plane> lo_, hi_;      // of what interpolation may give in each cell
    Plane distance_;                  // sharp: to the nearest edge in cells, negative in the light
    Plane light_shade_, dark_shade_;  // on both sides of edges; empty: 1 and 0
    std::vector<std::vector<Vec2d>> outlines_;
    double area_mm2_ = 0.0, outer_radius_ = 0.0, clear_radius_ = 0.0;
};

}  // namespace flare
