// SPDX-License-Identifier: Apache-2.0
#include "core/render/light_split.h"

#include <iterator>
#include <utility>

namespace flare {

void LightSplit::Add(std::size_t index, FlareImage picture) {
    if (sums_.empty()) {
        for (const ImagePlane& plane : picture.planes) {
            sums_.push_back({plane.name, std::vector<double>(plane.values.size(), 0.0)});
        }
    }
    for (std::size_t p = 0; p < sums_.size(); ++p) {
        const float* const values = std::as_const(picture.planes[p].values).data();
        for (std::size_t k = 0; k < sums_[p].values.size(); ++k) {
            sums_[p].values[k] += static_cast<double>(values[k]);
        }
    }
    for (std::size_t c = 0; c < scene_.channel_count(); ++c) {
        lights_.push_back({"light" + std::to_string(index) + "." + scene_.ChannelName(c),
                           std::move(picture.planes[c].values)});
    }
}

void LightSplit::AppendTo(FlareImage& image) {
    for (Sum& sum : sums_) {
        std::vector<float> plane(sum.values.size());
        for (std::size_t k = 0; k < plane.size(); ++k) plane[k] = PlaneValue(sum.values[k]);
        sum.values = {};
        image.planes.push_back({std::move(sum.name), std::move(plane)});
    }
    std::move(lights_.begin(), lights_.end(), std::back_inserter(image.planes));
    sums_.clear();
    lights_.clear();
}

}  // namespace flare
