// SPDX-License-Identifier: Apache-2.0
#include "core/image/coarse_levels.h"

namespace flare {
namespace {

constexpr int kRows = 32;

int FloorHalf(int value) {
    return value >= 0 ? value / 2 : -((1 - value) / 2);
}

// Pixel x of a finer level lies in pixel `own` of the coarser one, nearer to its neighbour `next`.
struct Sources {
    int own = 0, next = 0;
};

Sources SourcesOf(int x) {
    const int own = FloorHalf(x);
    return {own, own + (x - 2 * own == 0 ? -1 : 1)};
}

void OpenOut(const LightPlanes& from, LightPlanes& to, ThreadPool& threads) {
    const PixelWindow& a = from.window;
    const PixelWindow& b = to.window;
    const auto stride = static_cast<std::size_t>(a.width);
    threads.For((b.height + kRows - 1) / kRows, [&](int strip) {
        std::vector<float> line(stride);
        const int end = std::min(b.height, (strip + 1) * kRows);
        for (int row = strip * kRows; row < end; ++row) {
            const Sources y = SourcesOf(b.y + row);
            for (std::size_t c = 0; c < from.channels.size(); ++c) {
                const float* const plane = from.channels[c].data();
                const float* const own = plane + static_cast<std::size_t>(y.own - a.y) * stride;
                const float* const next = plane + static_cast<std::size_t>(y.next - a.y) * stride;
                // A quarter of a coarse pixel's light is a fine one's.
                for (std::size_t i = 0; i < stride; ++i)
                    line[i] = 0.1875F * own[i] + 0.0625F * next[i];
                float* const out = to.channels[c].data() + static_cast<std::size_t>(row) *
                                                               static_cast<std::size_t>(b.width);
                for (int i = 0; i < b.width; ++i) {
                    const Sources x = SourcesOf(b.x + i);
                    out[i] += 0.75F * line[static_cast<std::size_t>(x.own - a.x)] +
                              0.25F * line[static_cast<std::size_t>(x.next - a.x)];
                }
            }
        }
    });
}

}  // namespace

CoarseLevels::CoarseLevels(const PixelWindow& window, std::size_t channels) : channels_(channels) {
    windows_.push_back(window);
    for (int level = 1; level <= kCoarsest; ++level) {
        const PixelWindow& fine = windows_.back();
        const int x0 = FloorHalf(fine.x) - 1;
        const int y0 = FloorHalf(fine.y) - 1;
        windows_.push_back({x0, y0, FloorHalf(fine.x + fine.width - 1) + 2 - x0,
                            FloorHalf(fine.y + fine.height - 1) + 2 - y0});
    }
    levels_.resize(windows_.size());
}

PixelWindow CoarseLevels::WindowOf(int level) const {
    return windows_[static_cast<std::size_t>(level)];
}

LightPlanes& CoarseLevels::Level(int level) {
    std::optional<LightPlanes>& planes = levels_[static_cast<std::size_t>(level)];
    if (!planes) planes.emplace(WindowOf(level), channels_);
    return *planes;
}

LightPlanes CoarseLevels::Take(ThreadPool& threads) {
    for (int level = kCoarsest; level > 0; --level) {
        std::optional<LightPlanes>& planes = levels_[static_cast<std::size_t>(level)];
        if (!planes) continue;
        OpenOut(*planes, Level(level - 1), threads);
        planes.reset();
    }
    LightPlanes finest = std::move(Level(0));
    levels_[0].reset();
    return finest;
}

}  // namespace flare
