// SPDX-License-Identifier: Apache-2.0
#include "core/render/photon_map.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"

namespace flare {
namespace {

constexpr int kReach = static_cast<int>(kNearestReach_px);

int Floor(double value) {
    return static_cast<int>(std::floor(value));
}

}  // namespace

PhotonMap::PhotonMap(const PixelWindow& window, int channels, const PhotonSpec& spec)
    : window_(window),
      channels_(channels),
      spec_(spec),
      light_(window.pixels() * static_cast<std::size_t>(channels), 0.0) {}

double PhotonMap::margin() const {
    switch (spec_.estimate) {
        case PhotonEstimate::kPixel:
            return 0.0;
        case PhotonEstimate::kKernel:
            return spec_.kernel_px + 1.0;
        case PhotonEstimate::kNearest:
            return kNearestReach_px;
    }
    return 0.0;
}

void PhotonMap::Add(std::span<const Photon> photons) {
    if (spec_.estimate == PhotonEstimate::kNearest) {
        photons_.insert(photons_.end(), photons.begin(), photons.end());
        return;
    }
    for (const Photon& photon : photons) {
        if (spec_.estimate == PhotonEstimate::kPixel) {
            AddToPixel(photon);
        } else {
            AddKernel(photon);
        }
    }
}

void PhotonMap::AddToPixel(const Photon& photon) {
    const int x = Floor(photon.pixel.x) - window_.x;
    const int y = Floor(photon.pixel.y) - window_.y;
    if (x < 0 || y < 0 || x >= window_.width || y >= window_.height) return;
    for (int c = 0; c < channels_; ++c) At(c, x, y) += photon.light[c];
}

// Pixels by their centres; the weights of all of them, also beyond the window, add up to 1.
void PhotonMap::AddKernel(const Photon& photon) {
    const Vec2d at = photon.pixel - Vec2d(window_.x + 0.5, window_.y + 0.5);
    const double radius = spec_.kernel_px;
    const auto weight = [&](int x, int y) {
        const double dx = x - at.x, dy = y - at.y;
        return std::max(0.0, 1.0 - (dx * dx + dy * dy) / (radius * radius));
    };
    const int x0 = Floor(at.x - radius), x1 = Floor(at.x + radius) + 1;
    const int y0 = Floor(at.y - radius), y1 = Floor(at.y + radius) + 1;
    double all = 0.0;
    for (int y = y0; y <= y1; ++y) {
        for (int x = x0; x <= x1; ++x) all += weight(x, y);
    }
    for (int y = std::max(y0, 0); y <= std::min(y1, window_.height - 1); ++y) {
        for (int x = std::max(x0, 0); x <= std::min(x1, window_.width - 1); ++x) {
            const double share = weight(x, y) / all;
            for (int c = 0; c < channels_; ++c) At(c, x, y) += photon.light[c] * share;
        }
    }
}

// By pixels of the window widened by the reach, in the order they came within each.
void PhotonMap::Sort() {
    const int width = window_.width + 2 * kReach, height = window_.height + 2 * kReach;
    const auto cell_of = [&](const Photon& photon) {
        const int x = std::clamp(Floor(photon.pixel.x) - window_.x + kReach, 0, width - 1);
        const int y = std::clamp(Floor(photon.pixel.y) - window_.y + kReach, 0, height - 1);
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    };
    begins_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) + 1, 0);
    for (const Photon& photon : photons_) ++begins_[cell_of(photon) + 1];
    for (std::size_t i = 1; i < begins_.size(); ++i) begins_[i] += begins_[i - 1];
    std::vector<std::size_t> next(begins_.begin(), begins_.end() - 1);
    std::vector<Photon> sorted(photons_.size());
    for (const Photon& photon : photons_) sorted[next[cell_of(photon)]++] = photon;
    photons_ = std::move(sorted);
}

Vec3d PhotonMap::Nearest(int x, int y, std::vector<std::pair<double, std::size_t>>& found) const {
    const auto k = static_cast<std::size_t>(spec_.nearest);
    const int width = window_.width + 2 * kReach, height = window_.height + 2 * kReach;
    const Vec2d centre(window_.x + x + 0.5, window_.y + y + 0.5);
    double reach2 = kNearestReach_px * kNearestReach_px;
    const auto look = [&](int cx, int cy) {
        if (cx < 0 || cy < 0 || cx >= width || cy >= height) return;
        const auto cell = static_cast<std::size_t>(cy) * static_cast<std::size_t>(width) +
                          static_cast<std::size_t>(cx);
        for (std::size_t i = begins_[cell]; i < begins_[cell + 1]; ++i) {
            const Vec2d off = photons_[i].pixel - centre;
            if (off.dot(off) < reach2) found.emplace_back(off.dot(off), i);
        }
    };
    found.clear();
    // Square rings: all that is nearer than ring + 1/2 has been seen after it.
    bool enough = false;
    for (int ring = 0; ring <= kReach && !enough; ++ring) {
        const int cx = x + kReach, cy = y + kReach;
        for (int d = -ring; d <= ring; ++d) {
            look(cx + d, cy - ring);
            if (ring > 0) look(cx + d, cy + ring);
            if (std::abs(d) == ring) continue;
            look(cx - ring, cy + d);
            look(cx + ring, cy + d);
        }
        if (found.size() < k) continue;
        std::nth_element(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(k - 1),
                         found.end());
        found.resize(k);
        reach2 = found[k - 1].first;
        enough = reach2 <= (ring + 0.5) * (ring + 0.5);
    }
    Vec3d light(0.0);
    const std::size_t counted = found.size() < k ? found.size() : k - 1;
    // A fixed order of summation, whatever the order they were found in.
    std::sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(counted));
    for (std::size_t i = 0; i < counted; ++i) light += photons_[found[i].second].light;
    return light / (kPi * reach2);
}

const std::vector<double>& PhotonMap::Light(ThreadPool& threads, const CancelToken& cancel) {
    if (spec_.estimate != PhotonEstimate::kNearest) return light_;
    Sort();
    threads.For(window_.height, [&](int y) {
        if (cancel.cancelled()) return;
        std::vector<std::pair<double, std::size_t>> found;
        for (int x = 0; x < window_.width; ++x) {
            const Vec3d light = Nearest(x, y, found);
            for (int c = 0; c < channels_; ++c) At(c, x, y) = light[c];
        }
    });
    return light_;
}

void PhotonMap::Clear() {
    std::fill(light_.begin(), light_.end(), 0.0);
    photons_.clear();
}

}  // namespace flare
