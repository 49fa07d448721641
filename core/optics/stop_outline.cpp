// SPDX-License-Identifier: Apache-2.0
#include "core/optics/stop_outline.h"

#include <array>
#include <cstdint>
#include <unordered_map>

namespace flare {
namespace {

constexpr float kLevel = 0.5F;

// Walks squares whose corners are the middles of four cells, one cell around the grid included. A
// line enters and leaves a square through its sides; each crossed side ends one stretch of line and
// begins another.
class Outliner {
  public:
    Outliner(const std::vector<float>& values, int side) : values_(values), side_(side) {}

    std::vector<std::vector<Vec2d>> Run() {
        for (int j = -1; j < side_; ++j) {
            for (int i = -1; i < side_; ++i) AddSquare(i, j);
        }
        std::vector<std::vector<Vec2d>> loops;
        for (const std::int64_t start : starts_) {
            if (next_.find(start) == next_.end()) continue;
            std::vector<Vec2d>& loop = loops.emplace_back();
            for (std::int64_t at = start;;) {
                const auto found = next_.find(at);
                if (found == next_.end()) break;
                loop.push_back(PointOn(at));
                at = found->second;
                next_.erase(found);
            }
        }
        return loops;
    }

  private:
    float At(int i, int j) const {
        if (i < 0 || j < 0 || i >= side_ || j >= side_) return 0.0F;
        return values_[static_cast<std::size_t>(j) * static_cast<std::size_t>(side_) +
                       static_cast<std::size_t>(i)];
    }

    // Sides between (i, j) and its neighbour to the right (0) or above (1).
    std::int64_t SideOf(int i, int j, int up) const {
        return ((static_cast<std::int64_t>(j) + 1) * (side_ + 2) + i + 1) * 2 + up;
    }
    Vec2d PointOn(std::int64_t key) const {
        const bool up = key % 2 == 1;
        const int i = static_cast<int>(key / 2 % (side_ + 2)) - 1;
        const int j = static_cast<int>(key / 2 / (side_ + 2)) - 1;
        const auto a = static_cast<double>(At(i, j));
        const auto b = static_cast<double>(up ? At(i, j + 1) : At(i + 1, j));
        const double t = (static_cast<double>(kLevel) - a) / (b - a);
        return {i + 0.5 + (up ? 0.0 : t), j + 0.5 + (up ? t : 0.0)};
    }

    void AddSquare(int i, int j) {
        // Corners anticlockwise from the lower left; side k joins corners k and k + 1.
        const std::array<float, 4> v = {At(i, j), At(i + 1, j), At(i + 1, j + 1), At(i, j + 1)};
        int above = 0;
        for (const float value : v) above += value > kLevel ? 1 : 0;
        if (above == 0 || above == 4) return;
        const std::array<std::int64_t, 4> sides = {SideOf(i, j, 0), SideOf(i + 1, j, 1),
                                                   SideOf(i, j + 1, 0), SideOf(i, j, 1)};
        // Going round, light ends at a side where the line begins, if light is to its left.
        const bool saddle = above == 2 && (v[0] > kLevel) == (v[2] > kLevel);
        const bool joined = 0.25F * (v[0] + v[1] + v[2] + v[3]) > kLevel;
        for (std::size_t k = 0; k < 4; ++k) {
            const bool ends = v[k] > kLevel && v[(k + 1) % 4] <= kLevel;
            if (!ends) continue;
            // The line leads on to the side where light begins: around the dark corners ahead, or
            // back around the lit ones behind.
            std::size_t to = (k + 1) % 4;
            while (!(v[to] <= kLevel && v[(to + 1) % 4] > kLevel)) to = (to + 1) % 4;
            if (saddle && !joined) to = (k + 3) % 4;
            next_[sides[k]] = sides[to];
            starts_.push_back(sides[k]);
        }
    }

    const std::vector<float>& values_;
    int side_;
    std::unordered_map<std::int64_t, std::int64_t> next_;
    std::vector<std::int64_t> starts_;  // in order
};

}  // namespace

std::vector<std::vector<Vec2d>> OutlinesOf(const std::vector<float>& values, int side) {
    return Outliner(values, side).Run();
}

}  // namespace flare
