// SPDX-License-Identifier: Apache-2.0
//
// With every label shifted back by the widths before it, "do not overlap" becomes "do not fall":
// isotonic regression, by pooling neighbours that violate it (Ayer et al. 1955).
#include "core/drawing/label_row.h"

#include <algorithm>
#include <numeric>

namespace flare {

std::vector<double> SpreadLabels(const std::vector<RowLabel>& labels, double lo, double hi) {
    if (labels.empty()) return {};
    std::vector<std::size_t> order(labels.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return labels[a].wish < labels[b].wish; });

    struct Pool {
        double sum = 0.0;
        int count = 0;
        double mean() const { return sum / count; }
    };
    std::vector<double> shift(labels.size());
    std::vector<Pool> pools;
    double before = 0.0;
    for (std::size_t k = 0; k < order.size(); ++k) {
        const RowLabel& label = labels[order[k]];
        if (k > 0) before += 0.5 * (labels[order[k - 1]].width + label.width);
        shift[k] = before;
        pools.push_back({label.wish - before, 1});
        while (pools.size() > 1 && pools[pools.size() - 2].mean() > pools.back().mean()) {
            pools[pools.size() - 2].sum += pools.back().sum;
            pools[pools.size() - 2].count += pools.back().count;
            pools.pop_back();
        }
    }

    const double least = lo + 0.5 * labels[order.front()].width;
    const double most = std::max(least, hi - 0.5 * labels[order.back()].width - shift.back());
    std::vector<double> places(labels.size());
    std::size_t k = 0;
    for (const Pool& pool : pools) {
        for (int i = 0; i < pool.count; ++i, ++k) {
            places[order[k]] = std::clamp(pool.mean(), least, most) + shift[k];
        }
    }
    return places;
}

double TextWidth(std::string_view text, double font_size) {
    // Continuation bytes of UTF-8 are no characters of their own.
    const auto letters = std::count_if(text.begin(), text.end(), [](char c) {
        return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
    });
    constexpr double kMeanWidth = 0.56;
    return kMeanWidth * font_size * static_cast<double>(letters);
}

}  // namespace flare
