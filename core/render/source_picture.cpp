// SPDX-License-Identifier: Apache-2.0
#include "core/render/source_picture.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace flare {
namespace {

// How much of cell k of `cells` along a line of `size` pixels lies on each pixel, from the first.
struct Overlap {
    std::size_t first = 0;
    std::vector<double> lengths;  // pixels
};

Overlap OverlapOf(int k, int cells, int size) {
    const double from = static_cast<double>(k) * size / cells;
    const double to = static_cast<double>(k + 1) * size / cells;
    Overlap overlap;
    overlap.first = static_cast<std::size_t>(from);
    const auto end =
        std::min(static_cast<std::size_t>(std::ceil(to)), static_cast<std::size_t>(size));
    for (std::size_t p = overlap.first; p < end; ++p) {
        const auto at = static_cast<double>(p);
        overlap.lengths.push_back(std::max(0.0, std::min(to, at + 1.0) - std::max(from, at)));
    }
    return overlap;
}

}  // namespace

std::shared_ptr<const SourcePicture> SourcePicture::Of(int width, int height,
                                                       const std::vector<float>& values) {
    FLARE_CHECK(width > 0 && height > 0);
    const int size = std::max(width, height);
    const auto across = static_cast<std::size_t>(width);
    FLARE_CHECK(values.size() == across * static_cast<std::size_t>(height));
    const int left = (size - width) / 2;
    const int top = (size - height) / 2;
    const auto pixel = [&](std::size_t x, std::size_t y) {
        const int i = static_cast<int>(x) - left;
        const int j = static_cast<int>(y) - top;
        if (i < 0 || j < 0 || i >= width || j >= height) return 0.0;
        return static_cast<double>(
            values[static_cast<std::size_t>(j) * across + static_cast<std::size_t>(i)]);
    };
    const int side = std::min(size, kMostSide);
    std::vector<Overlap> overlaps;
    for (int k = 0; k < side; ++k) overlaps.push_back(OverlapOf(k, side, size));
    std::vector<double> shares;
    double sum = 0.0;
    for (int j = 0; j < side; ++j) {
        const Overlap& rows = overlaps[static_cast<std::size_t>(side - 1 - j)];
        for (const Overlap& columns : overlaps) {
            double light = 0.0;
            for (std::size_t b = 0; b < rows.lengths.size(); ++b) {
                for (std::size_t a = 0; a < columns.lengths.size(); ++a) {
                    light += rows.lengths[b] * columns.lengths[a] *
                             pixel(columns.first + a, rows.first + b);
                }
            }
            shares.push_back(light);
            sum += light;
        }
    }
    if (!(sum > 0.0)) return nullptr;
    for (double& share : shares) share /= sum;
    return std::shared_ptr<const SourcePicture>(new SourcePicture(side, std::move(shares)));
}

// A disc of radius r has the area pi r^2 for an outline of 2 pi r. An image's outline, shades
// counted by their steps, is its total variation.
SourcePicture::SourcePicture(int side, std::vector<double> shares)
    : side_(side), shares_(std::move(shares)) {
    const auto at = [&](int i, int j) {
        return i < 0 || j < 0 || i >= side ? 0.0 : (j >= side ? 0.0 : At(i, j));
    };
    double variation = 0.0;
    for (int j = -1; j < side; ++j) {
        for (int i = -1; i < side; ++i)
            variation += std::hypot(at(i + 1, j) - at(i, j), at(i, j + 1) - at(i, j));
    }
    detail_ = 2.0 / variation * (2.0 / side);
}

UprightAxes UprightAt(const Vec3d& direction) {
    const Vec3d d = direction.normalized();
    Vec3d up = Vec3d(0.0, 1.0, 0.0) - d * d.y;
    constexpr double kNone = 1e-9;
    if (up.length() < kNone) up = Vec3d(0.0, 0.0, d.y > 0.0 ? -1.0 : 1.0);
    up.normalize();
    return {up.cross(d).normalized(), up};
}

}  // namespace flare
