// SPDX-License-Identifier: Apache-2.0
//
// From photons on the sensor to light a pixel, in three ways:
//   pixel    every photon counts for the pixel it falls in. Unbiased for the mean over the pixel.
//   kernel   every photon is spread over the pixels about it by Epanechnikov's kernel of a fixed
//            radius: less noise, edges as soft as the radius.
//   nearest  a pixel takes the density about its centre from the k nearest photons: the light of
//            k - 1 of them over the area of the circle through the k-th, which is unbiased where
//            the density is even (k over that area would be too bright by k / (k - 1)).
//            Where fewer than k lie within kNearestReach_px, those over the area of that circle.
#pragma once

#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/parallel.h"
#include "core/render/photon_trace.h"

namespace flare {

inline constexpr double kNearestReach_px = 16.0;

class PhotonMap {
  public:
    // `channels` of a photon's light are used.
    PhotonMap(const PixelWindow& window, int channels, const PhotonSpec& spec);

    // How far outside the window photons still count, in pixels.
    double margin() const;
    void Add(std::span<const Photon> photons);
    // Once all photons are in: the light a pixel, channel after channel. The map is empty again
    // after Clear. Unfinished when cancelled.
    const std::vector<double>& Light(ThreadPool& threads, const CancelToken& cancel);
    void Clear();

  private:
    void AddToPixel(const Photon& photon);
    void AddKernel(const Photon& photon);
    void Sort();
    Vec3d Nearest(int x, int y, std::vector<std::pair<double, std::size_t>>& found) const;
    double& At(int channel, int x, int y) {
        return light_[static_cast<std::size_t>(channel) * window_.pixels() +
                      static_cast<std::size_t>(y) * static_cast<std::size_t>(window_.width) +
                      static_cast<std::size_t>(x)];
    }

    PixelWindow window_;
    int channels_;
    PhotonSpec spec_;
    std::vector<double> light_;
    // Of the nearest ones: all photons, by the pixel they lie in, and where each pixel's begin.
    std::vector<Photon> photons_;
    std::vector<std::size_t> begins_;
};

}  // namespace flare
