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

#include <cstddef>
#include <memory>
#include <vector>

#include "core/base/fingerprint.h"
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

// Bounds of a transmission.
struct StopRange {
    float lo = 0.0F, hi = 0.0F;
    bool dark() const { return hi <= 0.0F; }
    bool clear() const { return lo == 1.0F && hi == 1.0F; }
};

struct StopCells;
class StopPicture;

// Means over footprints of one size, wherever they lie: what does not depend on the place is found
// once. The picture must outlive it.
class StopSampler {
  public:
    StopSampler(const StopPicture& picture, Vec2d right, Vec2d down, Vec2d smear);
    double At(Vec2d middle) const;

  private:
    double SharpMean(Vec2d middle) const;

    const StopPicture& picture_;
    const StopCells& cells_;
    bool dark_ = false;  // without bounds
    std::size_t level_ = 0;
    double size_ = 1.0;                      // of a cell of level 0, in cells of the level
    Vec2d right_, down_, smear_;             // of one part, in cells of the level
    int across_ = 1, along_ = 1, deep_ = 1;  // parts
    double reach_ = 0.0;                     // of the whole, cells
};

class StopPicture {
  public:
    // Values must be finite and >= 0, one a cell. Takes a second or so for 2048 x 2048 cells.
    static std::shared_ptr<const StopPicture> Smooth(StopGrid grid);
    static std::shared_ptr<const StopPicture> Sharp(StopGrid grid);

    // The same picture in another size, turned anticlockwise about the centre; shares the cells.
    std::shared_ptr<const StopPicture> Placed(double half_width_mm, double turn_rad) const;

    // At a point.
    double At(Vec2d p) const;
    // Mean over a footprint, of any size: at most a few dozen look-ups.
    double Mean(const StopFootprint& footprint) const;

    // Bounds of what At gives within a box, and Mean for footprints that lie in it with a third of
    // their size to spare; not tight.
    StopRange Over(double x0, double y0, double x1, double y1) const;

    // The integral of the transmission, exactly that of the values.
    double area_mm2() const { return area_mm2_; }
    // Dark farther from the centre than this.
    double outer_radius() const { return outer_radius_; }
    // Exactly 1 nearer to the centre than this; may be 0.
    double clear_radius() const { return clear_radius_; }
    double half_width_mm() const { return half_width_; }
    // Of values, size and turn.
    Fingerprint fingerprint() const;
    double cell_mm() const { return 1.0 / per_cell_; }
    // The edges of a sharp picture: closed loops, anticlockwise around light and clockwise around
    // holes, the last point joined to the first.
    std::vector<std::vector<Vec2d>> Outlines() const;

  private:
    friend class StopSampler;
    StopPicture(std::shared_ptr<const StopCells> cells, double half_width_mm, double turn_rad);

    // Points and lengths in cells; points from the grid's lower left corner.
    Vec2d Turned(Vec2d mm) const { return {mm.dot(across_), mm.dot(up_)}; }
    Vec2d InCells(Vec2d mm) const { return Turned(mm) + middle_; }

    std::shared_ptr<const StopCells> cells_;
    double half_width_, per_cell_;
    Vec2d across_, up_;  // cells a mm, along the grid's rows and columns
    Vec2d middle_;       // of the grid, in cells
    double area_mm2_ = 0.0, outer_radius_ = 0.0, clear_radius_ = 0.0;
};

}  // namespace flare
