// SPDX-License-Identifier: Apache-2.0
//
// Huffman's tree from two queues: leaves in the order of their counts, and joined nodes, which come
// into being in that order by themselves.
#include "core/image/huffman_code.h"

#include <algorithm>
#include <array>

#include "core/base/check.h"

namespace flare {
namespace {

constexpr int kLongestOfAll = 15;

// Depth of each of the leaves, given by count in ascending order; two of them at least.
std::vector<int> LeafDepths(const std::vector<std::uint64_t>& leaves) {
    const std::size_t count = leaves.size();
    std::vector<std::uint64_t> weight(leaves);
    weight.resize(2 * count - 1);
    std::vector<std::size_t> parent(2 * count - 1, 0);
    std::size_t leaf = 0, joined = count;
    for (std::size_t node = count; node < weight.size(); ++node) {
        for (int k = 0; k < 2; ++k) {
            const bool take_leaf =
                leaf < count && (joined == node || weight[leaf] <= weight[joined]);
            const std::size_t child = take_leaf ? leaf++ : joined++;
            weight[node] += weight[child];
            parent[child] = node;
        }
    }
    std::vector<int> depth(weight.size(), 0);
    for (std::size_t node = weight.size() - 1; node-- > 0;) depth[node] = depth[parent[node]] + 1;
    depth.resize(count);
    return depth;
}

std::vector<std::uint8_t> LengthsOf(const std::vector<std::uint32_t>& counts, int& deepest) {
    std::vector<std::size_t> used;
    for (std::size_t s = 0; s < counts.size(); ++s) {
        if (counts[s] > 0) used.push_back(s);
    }
    std::vector<std::uint8_t> lengths(counts.size(), 0);
    deepest = used.empty() ? 0 : 1;
    if (used.size() == 1) lengths[used.front()] = 1;
    if (used.size() < 2) return lengths;
    std::stable_sort(used.begin(), used.end(),
                     [&](std::size_t a, std::size_t b) { return counts[a] < counts[b]; });
    std::vector<std::uint64_t> leaves;
    for (const std::size_t s : used) leaves.push_back(counts[s]);
    const std::vector<int> depths = LeafDepths(leaves);
    deepest = *std::max_element(depths.begin(), depths.end());
    for (std::size_t k = 0; k < used.size(); ++k) {
        lengths[used[k]] = static_cast<std::uint8_t>(std::min(depths[k], 255));
    }
    return lengths;
}

std::uint16_t Reversed(unsigned code, int bits) {
    unsigned reversed = 0;
    for (int k = 0; k < bits; ++k) reversed |= (code >> k & 1u) << (bits - 1 - k);
    return static_cast<std::uint16_t>(reversed);
}

}  // namespace

HuffmanCode MakeHuffmanCode(std::vector<std::uint32_t> counts, int longest) {
    FLARE_CHECK(longest <= kLongestOfAll);
    HuffmanCode code;
    int deepest = 0;
    code.lengths = LengthsOf(counts, deepest);
    while (deepest > longest) {
        // Flatter counts make a flatter tree; the loss is small, and such trees are rare.
        for (std::uint32_t& count : counts) count = (count + 1) / 2;
        code.lengths = LengthsOf(counts, deepest);
    }
    std::array<unsigned, kLongestOfAll + 1> of_length{}, next{};
    for (const std::uint8_t length : code.lengths) ++of_length[length];
    of_length[0] = 0;
    for (std::size_t bits = 1; bits <= kLongestOfAll; ++bits) {
        next[bits] = (next[bits - 1] + of_length[bits - 1]) << 1;
    }
    for (const std::uint8_t length : code.lengths) {
        code.codes.push_back(length == 0 ? std::uint16_t{0} : Reversed(next[length]++, length));
    }
    return code;
}

}  // namespace flare
