// SPDX-License-Identifier: Apache-2.0
//
// What a ghost's path lets through, for many rays at once: TransmissionTables::Path in SIMD
// (Highway). Over the squared cosines that a ghost's rays have at an interaction, a narrow range,
// its factor at each wavelength is a polynomial of sixth degree in the squared cosine or in the
// cosine; where neither holds, as about the critical angle, the path itself is asked. The product
// is within 1e-5 of the path's, relative to the largest over the ghost, a factor.
//
// Immutable once built, safe from any thread. Results depend on the instructions chosen as those of
// trace_columns.h do.
#pragma once

#include <cstddef>
#include <vector>

#include "core/mesh/transmission.h"

namespace flare {

// Passages of rays by column, at each traced wavelength (node).
struct PassageColumns {
    std::size_t rays = 0, stride = 0, passages = 0;
    std::vector<float> values;  // [(node * passages + passage) * stride + ray]

    // Reuses the memory.
    void Resize(std::size_t nodes, std::size_t passages_of_each, std::size_t ray_count);
};

// From where to where each passage of a ghost goes, over all rays and nodes.
struct PassageRange {
    std::vector<float> lowest, highest;  // [passage]
    std::vector<float> spread;           // [passage] largest between two nodes of a ray

    explicit PassageRange(std::size_t passages);
    // A ray's passage at each node.
    void Add(const std::vector<const float*>& nodes);
};

class PathInColumns {
  public:
    // `path` must outlive it. node_weights[band][node] are those of NodeWeights.
    PathInColumns(const TransmissionTables::Path& path,
                  std::vector<std::vector<double>> node_weights, const PassageRange& range);

    std::size_t bands() const { return node_weights_.size(); }
    // One number a ray, `stride` of them.
    void Weights(std::size_t band, const PassageColumns& rays, std::vector<float>& out) const;

    // Interactions and bands whose factor no polynomial is good enough for.
    std::size_t asked() const;

    static constexpr std::size_t kTerms = 7;

    // The factor of one interaction at one band.
    struct Fit {
        std::size_t step = 0;
        bool root = false;  // in the cosine, not in its square
        float middle = 0.0F, inverse_half = 1.0F;
        float terms[kTerms] = {};  // in (value - middle) * inverse_half
    };

  private:
    // False if neither polynomial holds.
    bool Choose(std::size_t band, std::size_t step, double lo, double hi, Fit& fit) const;

    const TransmissionTables::Path& path_;
    std::vector<std::vector<double>> node_weights_;
    std::vector<std::vector<Fit>> fits_;           // [band]
    std::vector<std::vector<std::size_t>> asked_;  // [band] interactions
};

}  // namespace flare
