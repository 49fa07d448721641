// SPDX-License-Identifier: Apache-2.0
//
// The diffraction pattern of one light on a picture's pixels: the near pattern in the middle, the
// far one outside, blended between; for a source of some size the middle is convolved with its
// image. Light in a pixel is that of the bands' weights times the share that falls there.
#pragma once

#include <optional>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/parallel.h"
#include "core/image/flare_image.h"
#include "core/image/source_kernel.h"
#include "core/wave/far_pattern.h"
#include "core/wave/near_pattern.h"

namespace flare {

// A wavelength and where its pattern's middle stands, full-frame pixels.
struct SpotBand {
    PatternBand band;
    Vec2d middle{0.0, 0.0};
};

// What the source looks like on the picture, pixels from its middle.
struct SpotSource {
    SourceEllipse ellipse;  // a disc's image, or one with the second moments of the patches
    std::vector<SourcePatch> patches;  // of a shape; of a disc none

    double reach() const;  // nothing of it lies farther from its middle
};

class SpotPattern {
  public:
    // Outlines in mm over pixels a radian, so that pixels over mm are their frequencies;
    // wavelengths in mm. `middle` is the place from which far light is measured, `near_px` how far
    // `near` is good for all wavelengths; it outlives the pattern.
    SpotPattern(const std::vector<ApertureOutline>& outlines, const NearPattern& near,
                const std::vector<SpotBand>& bands, const SpotSource& source, Vec2d middle,
                double outer_px, ThreadPool& threads);

    // The light in each pixel of the window, row by row.
    std::vector<Vec3d> Light(const PixelWindow& window) const;

  private:
    // The convolved middle: cells of `bin` x `bin` pixels.
    struct Patch {
        int x0 = 0, y0 = 0, side = 0, bin = 1;
        std::vector<Vec3d> light;
    };

    std::vector<Vec3d> PointLight(const PixelWindow& cells, int bin) const;
    void AddNear(const PixelWindow& cells, int bin, std::vector<Vec3d>& out) const;
    Vec3d MeanFar(const FarPattern& far, Vec2d place, double size) const;
    Vec3d MeanOutside(Vec2d place, double size) const;
    void BuildPatch(const SpotSource& source, ThreadPool& threads);
    Vec3d FromPatch(double x, double y) const;

    const NearPattern& near_;
    std::vector<SpotBand> bands_;
    Vec2d middle_;
    bool blended_;       // near and far pattern, over some pixels
    double point_edge_;  // from here on a point's pattern is the far one
    FarPattern point_far_;
    double disc_edge_ = 0.0;  // the same of the source's; 0: a point
    std::optional<FarPattern> disc_far_;
    Patch patch_;
};

}  // namespace flare
