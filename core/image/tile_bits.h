// SPDX-License-Identifier: Apache-2.0
//
// A map over a box of tiles, or of their nodes, one bit each: whole boxes are marked, asked for and
// walked over a word at a time.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace flare {

struct TileBox {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // tiles x0 ... x1 - 1
    int width() const { return x1 - x0; }
    int height() const { return y1 - y0; }
    std::size_t count() const {
        return static_cast<std::size_t>(width()) * static_cast<std::size_t>(height());
    }
};

class TileBits {
  public:
    // Nothing is marked.
    void Start(const TileBox& box) {
        box_ = box;
        words_ = static_cast<std::size_t>(box.width() + 63) / 64;
        bits_.assign(words_ * static_cast<std::size_t>(box.height()), 0);
    }
    void Mark(const TileBox& part) {
        ForWords(*this, part, [](std::uint64_t& word, std::uint64_t mask) {
            word |= mask;
            return false;
        });
    }
    void Mark(int x, int y) { Mark(TileBox{x, y, x + 1, y + 1}); }
    // Marks what both of the others do; all three are over one box.
    void MarkCommon(const TileBits& a, const TileBits& b) {
        for (std::size_t w = 0; w < bits_.size(); ++w) bits_[w] |= a.bits_[w] & b.bits_[w];
    }
    bool Any(const TileBox& part) const {
        return ForWords(*this, part, [](const std::uint64_t& word, std::uint64_t mask) {
            return (word & mask) != 0;
        });
    }
    // Within the box.
    bool Has(int x, int y) const {
        const auto i = static_cast<std::size_t>(x - box_.x0);
        return (bits_[Row(y) + i / 64] >> (i % 64) & 1U) != 0;
    }
    // Calls f(x, y) for all that is marked, row by row.
    template <class F>
    void ForEach(const TileBox& part, F f) const {
        const TileBox p = Within(part);
        if (p.width() <= 0) return;
        for (int y = p.y0; y < p.y1; ++y) {
            const TileBox row{p.x0, y, p.x1, y + 1};
            std::size_t at = static_cast<std::size_t>(p.x0 - box_.x0) / 64;
            ForWords(*this, row, [&](const std::uint64_t& word, std::uint64_t mask) {
                const int first = box_.x0 + static_cast<int>(64 * at++);
                for (std::uint64_t left = word & mask; left != 0; left &= left - 1)
                    f(first + std::countr_zero(left), y);
                return false;
            });
        }
    }

  private:
    TileBox Within(const TileBox& part) const {
        return {std::max(part.x0, box_.x0), std::max(part.y0, box_.y0), std::min(part.x1, box_.x1),
                std::min(part.y1, box_.y1)};
    }
    std::size_t Row(int y) const { return static_cast<std::size_t>(y - box_.y0) * words_; }

    // Calls f(word, mask) for the words that hold the part, until it says true.
    template <class Self, class F>
    static bool ForWords(Self& self, const TileBox& part, F f) {
        const TileBox p = self.Within(part);
        if (p.width() <= 0) return false;
        const auto first = static_cast<std::size_t>(p.x0 - self.box_.x0);
        const auto last = static_cast<std::size_t>(p.x1 - 1 - self.box_.x0);
        for (int y = p.y0; y < p.y1; ++y) {
            for (std::size_t w = first / 64; w <= last / 64; ++w) {
                std::uint64_t mask = ~std::uint64_t{0};
                if (w == first / 64) mask &= ~std::uint64_t{0} << (first % 64);
                if (w == last / 64) mask &= ~std::uint64_t{0} >> (63 - last % 64);
                if (f(self.bits_[self.Row(y) + w], mask)) return true;
            }
        }
        return false;
    }

    TileBox box_;
    std::size_t words_ = 0;  // of a row
    std::vector<std::uint64_t> bits_;
};

}  // namespace flare
