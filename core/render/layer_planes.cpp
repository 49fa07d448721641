// SPDX-License-Identifier: Apache-2.0
#include "core/render/layer_planes.h"

#include <utility>

namespace flare {

void AppendLayer(const RenderScene& scene, const std::string& name, LayerPlanes planes,
                 FlareImage& image) {
    const std::size_t channels = planes.size();
    const bool first = image.planes.empty();
    std::vector<PlaneValues> layer;
    for (std::vector<float>& plane : planes) layer.emplace_back(std::move(plane));
    for (std::size_t c = 0; c < channels; ++c) {
        if (first) {
            image.planes.push_back({scene.ChannelName(c), layer[c]});
            continue;
        }
        const float* const added = std::as_const(layer[c]).data();
        PlaneValues& root = image.planes[c].values;
        float* const sum = root.data();
        for (std::size_t k = 0; k < root.size(); ++k) {
            sum[k] = PlaneValue(static_cast<double>(sum[k]) + static_cast<double>(added[k]));
        }
    }
    for (std::size_t c = 0; c < channels; ++c) {
        image.planes.push_back({name + "." + scene.ChannelName(c), std::move(layer[c])});
    }
}

void AppendBeside(const RenderScene& scene, const std::string& name, LayerPlanes planes,
                  FlareImage& image) {
    for (std::size_t c = 0; c < planes.size(); ++c) {
        image.planes.push_back({name + "." + scene.ChannelName(c), std::move(planes[c])});
    }
}

}  // namespace flare
