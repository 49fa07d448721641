// SPDX-License-Identifier: Apache-2.0
//
// Error metrics between a picture and a reference picture. Deterministic; a second or two for six
// channels of 1920 x 1080.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/image/flare_image.h"

namespace flare {

// E is the image, Er the reference; sums run over all pixels and channels of a layer.
//
// Against a black reference a ratio is what its limit says: rel_l1, rel_l2_blur2 and the log errors
// are 0 where the image is black too and infinite where it is not; energy is 0 or +-infinite;
// p999_ratio is 1 or infinite. The percentile p of n values is the ceil(p n)-th smallest. The log
// errors count negative values as 0.
struct ErrorMetrics {
    double rel_l1 = 0.0;  // sum |E - Er| / sum |Er|: converges at caustics, where L2 does not
    double energy = 0.0;  // sum E / sum Er - 1
    double rel_l2_blur2 =
        0.0;  // sqrt(sum (G E - G Er)^2 / sum (G Er)^2), G a sigma = 2 px Gaussian
    double log_error_stops_mean = 0.0, log_error_stops_p99 = 0.0;  // |log2((E + eps) / (Er + eps))|
    double log_error_epsilon = 0.0;  // eps: 1e-4 of the reference's 99.9th percentile (of its
                                     // largest value where that percentile is not positive)
    double p999_ratio = 0.0;         // 99.9th percentile of E over that of Er
    double max_abs = 0.0;            // largest |E - Er|
};

struct LayerComparison {
    std::string layer;  // "" for the root channels
    ErrorMetrics metrics;
};

struct Comparison {
    ErrorMetrics all;                     // over all channels
    std::vector<LayerComparison> layers;  // in the order of the reference's channels
};

// Layers that tell of the picture's own noise (photon_error) are passed over in both.
// Fails with "bad_image" where the two do not have the same windows and channel names, or where a
// value is not finite. The order of the channels does not matter;
// layers are those of channel_name.h.
Result<Comparison> Compare(const FlareImage& image, const FlareImage& reference);

}  // namespace flare
