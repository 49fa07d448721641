// SPDX-License-Identifier: Apache-2.0
//
// What a light of some size makes of a ghost: the point's picture convolved with the source's image
// (docs/physics/area-lights.md). A kernel is that image as weights on pixels: the exact area of
// each pixel that it covers, made smaller by what pixels blur of themselves, with the first and
// second moments of the image set right: so an image far below a pixel gives all but the identity,
// and nothing changes suddenly with its size.
#pragma once

#include <vector>

#include "core/base/parallel.h"
#include "core/base/vec.h"
#include "core/image/flare_image.h"

namespace flare {

// A piece of a source, evenly bright: components of the turn from some point, radians.
struct SourcePatch {
    std::vector<Vec2d> outline;
    double share = 1.0;  // of the light of all patches
};

// A part of a source, seen from its middle.
struct SourceCell {
    std::vector<SourcePatch> patches;     // about the centroid of their light
    double xx = 0.0, xy = 0.0, yy = 0.0;  // second moments of their light
};

// From patches about any point, whose shares are made to add up to 1: their centroid, which is
// taken off them, and the cell.
SourceCell CellOfPatches(std::vector<SourcePatch> patches, Vec2d& centroid);

// The image of a cell on a picture of pixels of 2^coarse.
struct SourceImage {
    Vec2d along_u{0.0, 0.0}, along_v{0.0, 0.0};  // pixels of 2^coarse a radian
    int coarse = 0;
};

struct BlurKernel {
    int x0 = 0, y0 = 0, width = 0, height = 0;  // offsets that it reaches
    std::vector<float> weights;                 // row by row; their sum is 1
    std::vector<int> first, end;                // of each row: where weights are not 0
};

BlurKernel KernelOf(const SourceCell& cell, const SourceImage& image);

// Channels of light over a window.
struct LightPlanes {
    PixelWindow window;
    std::vector<std::vector<float>> channels;

    LightPlanes() = default;
    LightPlanes(const PixelWindow& around, std::size_t channel_count)
        : window(around), channels(channel_count, std::vector<float>(around.pixels(), 0.0F)) {}
};

// A window with the black columns around it that AddBlurred wants.
PixelWindow WithBlurMargin(const PixelWindow& window, const BlurKernel& kernel);

// Adds `from` convolved with the kernel to `to`, as far as that reaches. `from` is black in the
// columns of its margin (WithBlurMargin). A pixel's sum does not depend on the windows, nor on
// threads.
void AddBlurred(const LightPlanes& from, const BlurKernel& kernel, LightPlanes& to,
                ThreadPool& threads);

}  // namespace flare
