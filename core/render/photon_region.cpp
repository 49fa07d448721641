// SPDX-License-Identifier: Apache-2.0
#include "core/render/photon_region.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/tracing/interaction_list.h"
#include "core/tracing/trace_reference.h"

namespace flare {
namespace {

constexpr int kSide = 24;
constexpr int kLevels = 5;
constexpr int kMostLevels = 9;   // while no ray has passed
constexpr double kChange = 1.5;  // how much further than to the next cell a distance may change
constexpr double kLost = std::numeric_limits<double>::infinity();

// Middle and rim of the lamp's disc, in PhotonSource's square.
constexpr std::array<std::array<double, 2>, 5> kLampPoints{
    {{0.5, 0.5}, {0.0, 0.5}, {1.0, 0.5}, {0.5, 0.0}, {0.5, 1.0}}};

std::size_t At(int i, int j) {
    return static_cast<std::size_t>(j * kSide + i);
}

// What the rays of each cell of the grid found.
struct Look {
    std::vector<double> distance = std::vector<double>(At(0, kSide), kLost);  // the least
    std::vector<int> reached = std::vector<int>(At(0, kSide), 0);             // Search::Reached
    bool any_passed = false;
};

class Search {
  public:
    Search(const Lens& lens, const Iris& iris, const BounceSequence& sequence,
           const PhotonSource& source)
        : iris_(iris), source_(source), list_(WriteOut(lens, sequence, kLineD)) {
        options_.clip = false;
    }

    Look From(Vec2d low, Vec2d step) {
        Look look;
        for (int j = 0; j < kSide; ++j) {
            for (int i = 0; i < kSide; ++i) {
                const Vec2d place = low + Vec2d((i + 0.5) * step.x, (j + 0.5) * step.y);
                double& distance = look.distance[At(i, j)];
                int& reached = look.reached[At(i, j)];
                for (const auto& lamp : kLampPoints) {
                    distance = std::min(distance, Distance(place, {lamp[0], lamp[1]}));
                    reached = std::max(reached, Reached());
                    if (!source_.extended()) break;
                }
                look.any_passed = look.any_passed || distance < 1.0;
            }
        }
        return look;
    }

    std::uint64_t rays() const { return rays_; }

  private:
    double Distance(Vec2d place, Vec2d lamp) {
        const std::optional<PhotonRay> start = source_.At(place, lamp);
        record_.rim_ratio2.clear();
        if (!start) return kLost;
        ++rays_;
        const TraceResult end = TraceRay(list_, start->ray, options_, &record_);
        if (end.fate != RayFate::kArrived) return kLost;
        double distance = std::sqrt(end.max_rim_ratio2);
        for (const Vec2d& at : record_.stop_mm) {
            distance = std::max(distance, at.length() / iris_.outer_radius());
        }
        return distance;
    }

    // Of the last ray: how many surfaces it met within their rims before one beyond, or none.
    int Reached() const {
        int count = 0;
        for (const double ratio2 : record_.rim_ratio2) {
            if (ratio2 > 1.0) break;
            ++count;
        }
        return count;
    }

    const Iris& iris_;
    const PhotonSource& source_;
    InteractionList list_;
    TraceOptions options_;
    RayRecord record_;
    std::uint64_t rays_ = 0;
};

// Calls visit(n) for the cell and those about it.
template <typename Visit>
void Around(int i, int j, const Visit& visit) {
    for (int y = std::max(0, j - 1); y <= std::min(kSide - 1, j + 1); ++y) {
        for (int x = std::max(0, i - 1); x <= std::min(kSide - 1, i + 1); ++x) visit(At(x, y));
    }
}

// May rays of this cell pass, by how the distance changes about it?
bool MayPass(const std::vector<double>& distances, int i, int j) {
    const double own = distances[At(i, j)];
    if (own == kLost) return false;
    double change = 0.0;
    int known = 0;  // of the cells about it, with itself
    Around(i, j, [&](std::size_t n) {
        if (distances[n] == kLost) return;
        change = std::max(change, std::abs(distances[n] - own));
        ++known;
    });
    return own - kChange * change < 1.0 || known == 1;
}

// Where no ray has passed, what does lies near those that came farthest: most rays beside a narrow
// passage are lost on their way and have no distance.
std::vector<std::uint8_t> Promising(const Look& look) {
    const int farthest = *std::max_element(look.reached.begin(), look.reached.end());
    std::vector<std::uint8_t> kept(look.distance.size(), 0);
    for (int j = 0; j < kSide; ++j) {
        for (int i = 0; i < kSide; ++i) {
            const bool far = !look.any_passed && farthest > 0 && look.reached[At(i, j)] == farthest;
            if (far || MayPass(look.distance, i, j)) {
                Around(i, j, [&](std::size_t n) { kept[n] = 1; });
            }
        }
    }
    return kept;
}

}  // namespace

PhotonRegion::PhotonRegion(const Lens& lens, const Iris& iris, const BounceSequence& sequence,
                           const PhotonSource& source) {
    Search search(lens, iris, sequence, source);
    step_ = Vec2d(1.0, 1.0) / kSide;
    for (int level = 0; level < kMostLevels; ++level) {
        const Look look = search.From(low_, step_);
        kept_ = Promising(look);
        const int last = look.any_passed ? kLevels : kMostLevels;
        int x0 = kSide, x1 = -1, y0 = kSide, y1 = -1;
        for (int j = 0; j < kSide; ++j) {
            for (int i = 0; i < kSide; ++i) {
                if (kept_[At(i, j)] == 0) continue;
                x0 = std::min(x0, i);
                x1 = std::max(x1, i);
                y0 = std::min(y0, j);
                y1 = std::max(y1, j);
            }
        }
        const int width = x1 - x0 + 1, height = y1 - y0 + 1;
        // As tight as it gets, or the last look.
        if (width <= 0 || width * height > kSide * kSide / 2 || level + 1 >= last) break;
        low_ += Vec2d(x0 * step_.x, y0 * step_.y);
        step_ = Vec2d(step_.x * width, step_.y * height) / kSide;
    }
    rays_ = search.rays();
    for (std::size_t n = 0; n < kept_.size(); ++n) {
        if (kept_[n] != 0) cells_.push_back(static_cast<int>(n));
    }
}

bool PhotonRegion::Contains(Vec2d place) const {
    const double x = std::floor((place.x - low_.x) / step_.x);
    const double y = std::floor((place.y - low_.y) / step_.y);
    if (!(x >= 0.0 && x < kSide && y >= 0.0 && y < kSide)) return false;
    return kept_[At(static_cast<int>(x), static_cast<int>(y))] != 0;
}

Vec2d PhotonRegion::Place(std::size_t cell, Vec2d within) const {
    const int number = cells_[cell];
    return low_ +
           Vec2d((number % kSide + within.x) * step_.x, (number / kSide + within.y) * step_.y);
}

}  // namespace flare
